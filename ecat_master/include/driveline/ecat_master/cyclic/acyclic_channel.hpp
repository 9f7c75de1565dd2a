#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "driveline/ecat_master/bus/frame_tag.hpp"
#include "driveline/port/port.hpp"
#include "driveline/rt/spsc_ring.hpp"

namespace driveline::ecat_master {

/// A frame on its way through an AcyclicChannel.
struct AcyclicJob {
  std::uint64_t id = 0;                                 ///< chosen by the sender, to recognise the answer
  bool answered = false;                                ///< on the way back: false, when the frame was lost
  bool withheld = false;                                ///< on the way back: true, when it was not sent
  std::uint64_t round = 0;                              ///< that it is part of; 0: none
  std::uint64_t behind = 0;                             ///< round that must have gone well before; 0: none
  std::uint16_t size = 0;                               ///< of `bytes`, Ethernet header included
  std::array<std::byte, port::kMaxFrameBytes> bytes{};  ///< the frame, its answer on the way back
};

/// Carries frames of other threads through the cycle: they go in by one wait-free ring and come back by another,
/// several on the wire at a time. They share a budget of bytes per cycle; a longer frame waits until enough cycles have
/// accumulated its bytes, so the average never exceeds the budget.
///
/// Frames may be handed in before it is known whether they may be sent: one that stands behind a round waits until all
/// frames of that round are back, and comes back unsent when one of them was lost or a slave has not taken its write.
/// So the thread that makes the frames has a whole cycle for it, and none passes unused.
class AcyclicChannel {
 public:
  /// Cycles without an answer until a frame counts as lost.
  static constexpr std::uint32_t kLostAfterCycles = 8;
  /// Frames on the wire, or taken from the ring to be sent next.
  static constexpr std::size_t kMostFrames = 8;

  /// `bytes_per_cycle`: the budget. Takes all memory the channel will need.
  explicit AcyclicChannel(std::uint32_t lost_after_cycles = kLostAfterCycles,
                          std::size_t bytes_per_cycle = port::kMaxFrameBytes);

  // The cycle's side. \rtsafe
  /// Sends the next frames as far as the budget allows it, numbered from the one behind `last` on; returns the number
  /// of the last one. Call once per cycle.
  [[nodiscard]] FrameTag send_due(port::Port& port, FrameTag last) noexcept;
  /// What is to be sent next waits for frames that are on their way.
  [[nodiscard]] bool awaits_round() noexcept;
  /// Takes a received frame when it is one of those on their way.
  [[nodiscard]] bool accept(std::span<const std::byte> frame, FrameTag tag) noexcept;
  /// A frame is on its way and has not been given up.
  [[nodiscard]] bool in_flight() const noexcept { return flying_ != 0; }
  /// Gives up frames that have been on their way for too many cycles; call once per cycle.
  void end_cycle() noexcept;

  // The other side; one thread.
  /// Frames up to this length leave in the cycle they are offered in, when no others are in front of them.
  [[nodiscard]] std::size_t bytes_per_cycle() const noexcept { return bytes_per_cycle_; }
  /// False: as many frames wait as the ring holds.
  [[nodiscard]] bool submit(const AcyclicJob& job) noexcept { return requests_.try_push(job); }
  /// The next answer, in the order in which they came back; false: none is there yet.
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

  /// The last round of which a frame was sent, or was to be sent.
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
  std::array<Flight, kMostFrames> flights_;
  Flight* waiting_ = nullptr;  ///< the one that is sent next
  bool saving_ = false;        ///< it waits for bytes
  Round round_;
  std::size_t flying_ = 0;
};

}  // namespace driveline::ecat_master
