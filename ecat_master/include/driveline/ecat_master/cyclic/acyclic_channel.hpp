#pragma once

#include <array>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "driveline/ecat_master/bus/datagram_exchange.hpp"
#include "driveline/ecat_master/bus/frame_tag.hpp"
#include "driveline/port/port.hpp"
#include "driveline/rt/clock.hpp"
#include "driveline/rt/spsc_ring.hpp"

namespace driveline::ecat_master {

/// A frame on its way through an AcyclicChannel.
struct AcyclicJob {
  std::uint64_t id = 0;                                 ///< chosen by the sender, to recognise the answer
  bool answered = false;                                ///< on the way back: false, when the frame was lost
  std::uint16_t size = 0;                               ///< of `bytes`, Ethernet header included
  std::array<std::byte, port::kMaxFrameBytes> bytes{};  ///< the frame, its answer on the way back
};

/// Carries frames of other threads through the cycle: they go in by one wait-free ring and come back by another,
/// several on the wire at a time. They share a budget of bytes per cycle; a longer frame waits until enough cycles have
/// accumulated its bytes, so the average never exceeds the budget.
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

  [[nodiscard]] Flight* next_waiting() noexcept;
  void end(Flight& flight, bool answered) noexcept;

  rt::SpscRing<AcyclicJob> requests_;
  rt::SpscRing<AcyclicJob> answers_;
  std::uint32_t lost_after_cycles_;
  std::size_t bytes_per_cycle_;
  std::size_t credit_ = 0;
  std::array<Flight, kMostFrames> flights_;
  Flight* waiting_ = nullptr;  ///< the one that is sent next
  std::size_t flying_ = 0;
};

/// DatagramExchange through an AcyclicChannel: acyclic work while the cycle runs.
class CyclicExchange final : public DatagramExchange {
 public:
  /// Lets time pass while waiting for the cycle: sleeps beside a real-time thread, runs cycles on virtual time.
  using Pass = std::function<void(std::chrono::nanoseconds)>;

  /// Channel and clock must outlive this, which belongs to the one thread on the channel's other side. Not \rtsafe.
  CyclicExchange(AcyclicChannel& channel, rt::Clock& clock, Pass pass);

  /// Errors beside those of DatagramExchange: ExchangeFull when frames given up before still fill the channel.
  [[nodiscard]] Result<void> exchange(std::span<Request> requests) override;
  void pause(std::chrono::nanoseconds duration) override { pass_(duration); }
  [[nodiscard]] std::chrono::nanoseconds now() const noexcept override { return clock_.now(); }

 private:
  /// Requests first to first + count travel in one frame.
  struct Part {
    std::size_t first = 0;
    std::size_t count = 0;
    std::uint64_t id = 0;  ///< of the job that carries them now; 0: none does
    int tries = 0;
    std::chrono::nanoseconds deadline{0};
    bool done = false;
  };

  [[nodiscard]] Result<void> cut(std::span<const Request> requests);
  [[nodiscard]] Result<void> submit_open(std::span<const Request> requests);
  [[nodiscard]] AcyclicJob make_job(std::span<const Request> requests, std::uint64_t id);
  [[nodiscard]] bool take_answers(std::span<Request> requests);
  void give_up_late(std::span<const Request> requests);
  void reopen(std::size_t part, std::span<const Request> requests);

  AcyclicChannel& channel_;
  rt::Clock& clock_;
  Pass pass_;
  std::uint64_t next_id_ = 1;
  std::vector<Part> parts_;
};

}  // namespace driveline::ecat_master
