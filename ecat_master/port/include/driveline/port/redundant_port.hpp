#pragma once

#include <array>
#include <atomic>
#include <vector>

#include "driveline/port/port.hpp"
#include "driveline/rt/clock.hpp"
#include "driveline/rt/counter.hpp"

namespace driveline::port {

/// State of the ring as last seen by a RedundantPort.
struct RingStatus {
  /// What the frames of the last exchange show about the ring.
  enum class State : std::uint8_t {
    kUnknown,  ///< no frame has returned yet
    kClosed,   ///< frames arrive at the other end
    kOpen,     ///< frames return to the end that sent them
  };
  State state = State::kUnknown;  ///< closed, open (broken) or not known yet
  /// While open: number of slaves between the primary interface and the break, and between the break and the secondary
  /// interface. Known from frames that start with a broadcast read. When only one half of an answer arrives, the other
  /// half may merely be late, so the state changes after RedundantPort::kLoneHalves such answers in a row, or at once
  /// when the other interface could not send.
  std::uint16_t primary_slaves = 0;
  std::uint16_t secondary_slaves = 0;  ///< number of slaves that the secondary interface reaches
};

/// The two ends of a ring as one port. Every frame leaves on both interfaces. In a whole ring the primary copy arrives
/// at the secondary end, processed by all slaves, and the secondary copy, which slaves only forward, at the primary
/// end. When the ring is broken, each copy returns at the break and brings back the work of the slaves on its side; the
/// port merges the two, so that a broken ring loses nothing. When the ring breaks or is repaired while a frame is in
/// flight, one copy may travel through the old ring and the other through the new one: then the work of the slaves on
/// one side is missing in the answer and its working counters. So a break or a repair costs at most the frames in
/// flight, and only the data of the slaves on one side.
///
/// In the secondary copy, commands that would act twice or on the wrong slave are NOPs: commands that count positions
/// (APxx, ARMW) and commands that read one slave and write the others (FRMW). While the ring is open, slaves behind the
/// break can therefore be addressed by station address, not by position.
///
/// The time of the reference clock (FRMW to 0x0910) is the exception: route_time() sets how it reaches both parts.
///
/// One thread at a time, like any port; other threads may read status() and the counters. Does not allocate after
/// construction.
class RedundantPort final : public Port {
 public:
  /// Time-outs of the port.
  struct Settings {
    /// How long after sending one half of an answer waits for the other half before it is handed over alone: longer
    /// than a frame takes, shorter than the master waits for the answer.
    std::chrono::nanoseconds half_wait = std::chrono::microseconds{60};
  };
  /// Frames that may be in flight at the same time.
  static constexpr std::size_t kMaxInFlight = 16;
  /// Number of answers in a row with only one half after which the ring counts as open, see RingStatus.
  static constexpr unsigned kLoneHalves = 3;

  /// How the time of the reference clock travels (FRMW to register 0x0910, ETG.1000.4 Table 60).
  struct TimeRoute {
    /// The interface whose copy carries the reference time when it passes the reference clock.
    enum class Leader : std::uint8_t { kPrimary, kSecondary };
    Leader leader = Leader::kPrimary;  ///< depends on the position of the reference clock
    /// With kPrimary: the time in the secondary copy is the time that the master has written plus this delay in ns, by
    /// which the copy passes later. Empty: the secondary copy carries no time.
    std::optional<std::int32_t> other_later_ns{};
    /// RingStatus::primary_slaves of the break that this route is for. Once the ring is closed, or open elsewhere, the
    /// primary copy leads and the other carries no time.
    std::uint16_t primary_slaves = 0;
  };

  /// `primary`, `secondary` and `clock` must outlive this port.
  RedundantPort(Port& primary, Port& secondary, const rt::Clock& clock, Settings settings);
  /// With the default settings. `primary`, `secondary` and `clock` must outlive this port.
  RedundantPort(Port& primary, Port& secondary, const rt::Clock& clock)
      : RedundantPort(primary, secondary, clock, Settings{}) {}

  /// kLinkDown only when both interfaces have no link. \rtsafe
  [[nodiscard]] SendStatus send(std::span<const std::byte> frame) noexcept override;
  void hold_until(std::chrono::nanoseconds instant) noexcept override {
    primary_.hold_until(instant);
    secondary_.hold_until(instant);
  }
  /// \rtsafe
  [[nodiscard]] std::optional<ReceivedFrame> receive() noexcept override;
  bool wait_readable(std::chrono::nanoseconds deadline) noexcept override;
  /// \rtsafe
  [[nodiscard]] std::chrono::nanoseconds last_send_time() const noexcept override { return last_send_; }

  /// Takes effect with the next frame. Any one thread. \rtsafe
  void route_time(const TimeRoute& route) noexcept;

  /// State of the ring as last seen. Any thread. \rtsafe
  [[nodiscard]] RingStatus status() const noexcept;
  /// Number of answers merged from two halves. Any thread. \rtsafe
  [[nodiscard]] std::uint64_t merged() const noexcept { return merged_.value(); }
  /// Number of halves of answers that were handed over alone. Any thread. \rtsafe
  [[nodiscard]] std::uint64_t halves() const noexcept { return halves_.value(); }
  /// Number of halves() whose other half was expected but late or lost. For the rest there was no other half, because
  /// the other copy had passed the whole ring. Any thread. \rtsafe
  [[nodiscard]] std::uint64_t late_halves() const noexcept { return late_halves_.value(); }

 private:
  enum class Side : std::uint8_t { kPrimary, kSecondary };
  using Bytes = std::array<std::byte, kMaxFrameBytes>;

  struct Flight {
    bool open = false;
    bool other_expected = false;  ///< both copies are on the wire
    Side time_leader = Side::kPrimary;
    std::size_t size = 0;
    std::chrono::nanoseconds sent_at{0};
    std::optional<Side> half;  ///< the side whose answer is in `answer`
    std::chrono::nanoseconds half_time{0};
    Bytes sent;
    Bytes answer;
  };

  [[nodiscard]] Flight& new_flight(std::span<const std::byte> frame) noexcept;
  [[nodiscard]] Flight* find(std::span<const std::byte> frame) noexcept;
  [[nodiscard]] bool poll() noexcept;
  [[nodiscard]] bool poll(Port& port, Side side) noexcept;
  [[nodiscard]] bool accept(const ReceivedFrame& frame, Side arrived) noexcept;
  [[nodiscard]] bool take_half(Flight& flight, const ReceivedFrame& frame, Side copy) noexcept;
  [[nodiscard]] bool hand_over_late_half() noexcept;
  void hand_over(Flight& flight) noexcept;
  [[nodiscard]] TimeRoute time_route() const noexcept;
  [[nodiscard]] std::span<const std::byte> make_copy(std::span<const std::byte> frame, const TimeRoute& route) noexcept;
  static void settle_time(const Flight& flight, Side from, std::span<const std::byte> leader,
                          std::span<std::byte> into) noexcept;
  void note_open(const Flight& flight, std::span<const std::byte> other) noexcept;
  void note_half(const Flight& flight, std::span<const std::byte> answer) noexcept;

  Port& primary_;
  Port& secondary_;
  const rt::Clock& clock_;
  Settings settings_;
  std::vector<Flight> flights_;
  std::size_t next_flight_ = 0;
  unsigned lone_halves_ = 0;  ///< answers in a row with only one half
  Bytes copy_{};
  Bytes merged_frame_{};
  std::optional<ReceivedFrame> ready_;
  std::chrono::nanoseconds last_send_{0};
  rt::Counter merged_;
  rt::Counter halves_;
  rt::Counter late_halves_;
  std::atomic<std::uint64_t> status_{0};
  std::atomic<std::uint64_t> time_route_{0};
};

}  // namespace driveline::port
