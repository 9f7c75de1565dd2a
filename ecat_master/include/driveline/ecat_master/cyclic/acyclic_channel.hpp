#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "driveline/ecat_master/bus/frame_tag.hpp"
#include "driveline/port/port.hpp"
#include "driveline/rt/spsc_ring.hpp"

namespace driveline::ecat_master {

/// A frame that passes through an AcyclicChannel.
struct AcyclicJob {
  std::uint64_t id = 0;                                 ///< chosen by the sender, to identify the answer
  bool answered = false;                                ///< in the answer: false if the frame was lost
  bool withheld = false;                                ///< in the answer: true if the frame was not sent
  std::uint64_t round = 0;                              ///< round that the frame is part of; 0: none
  std::uint64_t behind = 0;                             ///< round that must have succeeded before; 0: none
  std::uint16_t size = 0;                               ///< size of `bytes`, including the Ethernet header
  std::array<std::byte, port::kMaxFrameBytes> bytes{};  ///< the frame; in the answer, the frame that came back
};

/// Carries frames of other threads through the cycle: they enter by one wait-free ring buffer and come back by another,
/// several on the wire at a time. They share a budget of bytes per cycle; a longer frame waits until enough cycles have
/// accumulated its bytes, so that the average never exceeds the budget.
///
/// Frames may be submitted before it is known whether they may be sent: a frame that depends on a round waits until all
/// frames of that round are back, and comes back unsent if a frame was lost or a slave did not take its write. So the
/// thread that makes the frames has a whole cycle for it, and no cycle stays unused.
class AcyclicChannel {
 public:
  /// Cycles without an answer after which a frame counts as lost.
  static constexpr std::uint32_t kLostAfterCycles = 8;
  /// Maximum number of frames on the wire or taken from the ring to be sent next.
  static constexpr std::size_t kMaxFrames = 8;
  /// The largest budget: kMaxFrames frames of maximum length.
  static constexpr std::size_t kMaxBytes = kMaxFrames * port::kMaxFrameBytes;

  /// `bytes_per_cycle`: the budget. Allocates all memory that the channel needs.
  explicit AcyclicChannel(std::uint32_t lost_after_cycles = kLostAfterCycles,
                          std::size_t bytes_per_cycle = port::kMaxFrameBytes);

  // Functions for the cycle. \rtsafe
  /// Sends the next frames as far as the budget permits, numbered from `last` + 1 on; returns the number of the last
  /// one. Call once per cycle.
  [[nodiscard]] FrameTag send_due(port::Port& port, FrameTag last) noexcept;
  /// Whether the next frame waits for frames in flight.
  [[nodiscard]] bool awaits_round() noexcept;
  /// Takes a received frame if it belongs to a frame in flight.
  [[nodiscard]] bool accept(std::span<const std::byte> frame, FrameTag tag) noexcept;
  /// Whether a frame is in flight and does not count as lost.
  [[nodiscard]] bool in_flight() const noexcept { return flying_ != 0; }
  /// Drops frames that have been in flight for too many cycles; call once per cycle.
  void end_cycle() noexcept;

  // Functions for the other side; one thread.
  /// Frames up to this length are sent in the cycle in which they are submitted, if no others are queued before them.
  [[nodiscard]] std::size_t bytes_per_cycle() const noexcept { return bytes_per_cycle_; }
  /// Submits a frame; false: the ring is full.
  [[nodiscard]] bool submit(const AcyclicJob& job) noexcept { return requests_.try_push(job); }
  /// Takes the next answer, in the order in which they came back; false: there is none yet.
  [[nodiscard]] bool take_answer(AcyclicJob& job) noexcept { return answers_.try_pop(job); }

 private:
  /// A frame that the cycle has taken from the ring.
  struct Flight {
    enum class State : std::uint8_t { kFree, kWaiting, kFlying };
    State state = State::kFree;
    FrameTag tag{};
    std::uint32_t age = 0;
    AcyclicJob job;
  };

  /// The last round of which a frame was sent or withheld.
  struct Round {
    std::uint64_t number = 0;
    std::size_t flying = 0;
    bool good = true;
  };

  [[nodiscard]] Flight* next_waiting() noexcept;
  [[nodiscard]] bool must_wait(const AcyclicJob& job) const noexcept;
  [[nodiscard]] bool may_not_go(const AcyclicJob& job) const noexcept;
  void withhold(Flight& flight) noexcept;
  void take_off(Flight& flight, FrameTag tag, port::Port& port) noexcept;
  void end(Flight& flight, bool answered) noexcept;

  rt::SpscRing<AcyclicJob> requests_;
  rt::SpscRing<AcyclicJob> answers_;
  std::uint32_t lost_after_cycles_;
  std::size_t bytes_per_cycle_;
  std::size_t credit_ = 0;
  std::array<Flight, kMaxFrames> flights_;
  Flight* waiting_ = nullptr;  ///< the frame to be sent next
  bool saving_ = false;        ///< waiting_ waits for more bytes
  Round round_;
  std::size_t flying_ = 0;
};

}  // namespace driveline::ecat_master
