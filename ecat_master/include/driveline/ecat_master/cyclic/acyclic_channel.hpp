#pragma once

#include <array>
#include <atomic>
#include <functional>

#include "driveline/ecat_master/datagram_exchange.hpp"
#include "driveline/ecat_master/frame_tag.hpp"
#include "driveline/port/port.hpp"
#include "driveline/rt/clock.hpp"
#include "driveline/rt/spsc_ring.hpp"

namespace driveline::ecat_master {

/// A frame on its way through an AcyclicChannel.
struct AcyclicJob {
  std::uint64_t id = 0;
  bool answered = false;
  std::uint16_t size = 0;
  std::array<std::byte, port::kMaxFrameBytes> bytes{};
};

/// Carries frames of other threads through the cycle: they go in by one wait-free ring and come back by another, one
/// frame on the wire at a time, so that the time a cycle lends to them is bounded by one frame.
class AcyclicChannel {
 public:
  explicit AcyclicChannel(std::uint32_t lost_after_cycles = 8);

  // The cycle's side. \rtsafe
  /// Sends the next frame when none is on its way. `tag` numbers it.
  void send_next(port::Port& port, FrameTag tag) noexcept;
  /// Takes a received frame when it is the one on its way.
  [[nodiscard]] bool accept(std::span<const std::byte> frame, FrameTag tag) noexcept;
  /// Gives up a frame that has been on its way for too many cycles; call once per cycle.
  void end_cycle() noexcept;

  // The other side; one thread.
  [[nodiscard]] bool submit(const AcyclicJob& job) noexcept { return requests_.try_push(job); }
  [[nodiscard]] bool take_answer(AcyclicJob& job) noexcept { return answers_.try_pop(job); }

 private:
  rt::SpscRing<AcyclicJob> requests_;
  rt::SpscRing<AcyclicJob> answers_;
  std::uint32_t lost_after_cycles_;
  AcyclicJob flying_;
  FrameTag tag_{};
  bool in_flight_ = false;
  std::uint32_t age_ = 0;
};

/// DatagramExchange through an AcyclicChannel: acyclic work while the cycle runs.
class CyclicExchange final : public DatagramExchange {
 public:
  /// Lets time pass while waiting for the cycle: sleeps beside a real-time thread, runs cycles on virtual time.
  using Pass = std::function<void(std::chrono::nanoseconds)>;

  CyclicExchange(AcyclicChannel& channel, rt::Clock& clock, Pass pass);

  [[nodiscard]] Result<void> exchange(std::span<Request> requests) override;
  void pause(std::chrono::nanoseconds duration) override { pass_(duration); }
  [[nodiscard]] std::chrono::nanoseconds now() const noexcept override { return clock_.now(); }

 private:
  [[nodiscard]] Result<std::size_t> exchange_frame(std::span<Request> requests);
  [[nodiscard]] bool await(std::uint64_t id, AcyclicJob& job);

  AcyclicChannel& channel_;
  rt::Clock& clock_;
  Pass pass_;
  std::uint64_t next_id_ = 1;
};

}  // namespace driveline::ecat_master
