#pragma once

#include <chrono>
#include <cstddef>
#include <functional>
#include <optional>

#include "driveline/canopen_port/can_port.hpp"
#include "driveline/rt/clock.hpp"
#include "driveline/rt/published_value.hpp"
#include "driveline/rt/spsc_ring.hpp"

namespace driveline::canopen {

/// Passes frames between the cycle, which has the port, and the owner of the master: what arrives and is no process
/// data one way, requests the other way. Neither side waits.
class AcyclicChannel {
 public:
  /// Default room for frames to the owner: those of a full bus at 1 Mbit/s in 100 ms.
  static constexpr std::size_t kToOwner = 2048;
  /// Default room for frames to the bus.
  static constexpr std::size_t kToBus = 256;

  /// Allocates room for at least so many frames in each direction.
  explicit AcyclicChannel(std::size_t to_owner = kToOwner, std::size_t to_bus = kToBus)
      : to_owner_(to_owner), to_bus_(to_bus) {}

  /// \name For the cycle, \rtsafe
  /// @{

  /// Passes a frame on; it is lost and counted when the owner has left no room.
  void deliver(const ReceivedFrame& frame) noexcept { static_cast<void>(to_owner_.try_push(frame)); }
  /// The next frame that the owner wants to send; it stays the next one until sent(). Null: there is none.
  [[nodiscard]] const Frame* next() noexcept {
    if (!next_) {
      Frame frame;
      if (!to_bus_.try_pop(frame)) return nullptr;
      next_ = frame;
    }
    return &*next_;
  }
  /// next() has been sent, or cannot be.
  void sent() noexcept { next_.reset(); }
  /// Tells the counters of the port.
  void publish(const PortStatistics& statistics) noexcept { statistics_.write(statistics); }
  /// @}

  /// \name For the owner, one thread
  /// @{

  /// Takes the oldest frame that has arrived. \rtsafe
  [[nodiscard]] bool take(ReceivedFrame& frame) noexcept { return to_owner_.try_pop(frame); }
  /// Whether a frame has arrived. \rtsafe
  [[nodiscard]] bool waiting() const noexcept { return to_owner_.size() > 0; }
  /// Queues a frame for the bus; false: there is no room. \rtsafe
  [[nodiscard]] bool request(const Frame& frame) noexcept { return to_bus_.try_push(frame); }
  /// The counters of the port as of the last cycle.
  [[nodiscard]] PortStatistics statistics() const noexcept { return statistics_.read(); }
  /// @}

  /// Frames that were lost because the owner had left no room. Any thread. \rtsafe
  [[nodiscard]] std::uint64_t lost() const noexcept { return to_owner_.dropped(); }

 private:
  rt::SpscRing<ReceivedFrame> to_owner_;
  rt::SpscRing<Frame> to_bus_;
  std::optional<Frame> next_;  ///< frame that the cycle sends next
  rt::PublishedValue<PortStatistics> statistics_;
};

/// The bus as the owner of a master sees it while a CanCycle has the port: frames that are no process data. A frame
/// leaves with one of the next cycles, as far as the bus has room there; what arrived is there after the next cycle.
///
/// Times of received frames are those of the port below. statistics() are those of the port below as of the last cycle,
/// with the frames that were lost between cycle and owner in PortStatistics::lost. One thread.
class AcyclicPort final : public CanPort {
 public:
  /// Lets cycles pass for this long: motion::CycleRunner::pass(). Empty: sleeps on the clock, while the cycle runs in a
  /// thread of its own.
  using Pass = std::function<void(std::chrono::nanoseconds duration)>;

  /// `step`: interval between two looks at what has arrived, the period of the cycle. Channel and clock must outlive
  /// this.
  AcyclicPort(AcyclicChannel& channel, rt::Clock& clock, std::chrono::nanoseconds step, Pass pass = {});

  /// Queues a frame. kBusy: there is no room; kNotValid: not possible on a bus; kDown: the port below was down in the
  /// last cycle.
  [[nodiscard]] SendStatus send(const Frame& frame) noexcept override;
  [[nodiscard]] std::optional<ReceivedFrame> receive() noexcept override;
  /// Lets cycles pass until a frame is there.
  bool wait_readable(std::chrono::nanoseconds deadline) noexcept override;
  [[nodiscard]] PortStatistics statistics() const noexcept override;

 private:
  AcyclicChannel* channel_;
  rt::Clock* clock_;
  std::chrono::nanoseconds step_;
  Pass pass_;
  bool told_down_ = false;  ///< wait_readable() has returned early because the port is down
};

/// The clock of an owner whose sleep lets cycles pass, for BusLink over an AcyclicPort on virtual time.
class PassingClock final : public rt::Clock {
 public:
  /// The clock below must outlive this; `pass` as that of AcyclicPort.
  PassingClock(rt::Clock& clock, AcyclicPort::Pass pass) : clock_(&clock), pass_(std::move(pass)) {}

  [[nodiscard]] std::chrono::nanoseconds now() const noexcept override { return clock_->now(); }
  void sleep_until(std::chrono::nanoseconds deadline) noexcept override;
  void spin() noexcept override { clock_->spin(); }
  [[nodiscard]] std::chrono::nanoseconds cpu_time() const noexcept override { return clock_->cpu_time(); }

 private:
  rt::Clock* clock_;
  AcyclicPort::Pass pass_;
};

}  // namespace driveline::canopen
