#pragma once

#include <array>
#include <atomic>
#include <vector>

#include "driveline/port/counter.hpp"
#include "driveline/port/port.hpp"
#include "driveline/rt/clock.hpp"

namespace driveline::port {

/// State of the ring as a RedundantPort has seen it last.
struct RingStatus {
  /// What is known about the ring from the frames of the last exchange.
  enum class State : std::uint8_t {
    kUnknown,  ///< no frame has come back yet
    kClosed,   ///< frames come out at the other end
    kOpen,     ///< frames come back to the end they were sent from
  };
  State state = State::kUnknown;  ///< closed, broken, or not known yet
  /// While open: slaves between the primary interface and the break, and between the break and the secondary one. Known
  /// from frames that begin with a broadcast read. The other half of a single half may only be late, so the state
  /// changes after RedundantPort::kLoneHalves of them in a row, or at once when the other interface could not send.
  std::uint16_t primary_slaves = 0;
  std::uint16_t secondary_slaves = 0;  ///< slaves that the secondary interface reached
};

/// The two ends of a ring as one port. Every frame leaves on both interfaces. In a whole ring the primary one comes out
/// at the secondary end with the work of all slaves done, and the copy, which slaves only pass on, at the primary end.
/// When the ring is broken somewhere each copy turns round at the break and brings back the work of the slaves on its
/// side; the two are put together, so that a broken ring loses nothing. Of a frame that is under way in the moment of
/// the break, or of its repair, one copy may travel through the ring as it was before and the other as it is after:
/// then the slaves of one side are missing in the answer and its working counters. So a break and a repair cost at most
/// the frames that are under way, and those for the slaves of one side only.
///
/// The copy on the secondary interface does nothing where it must not do it twice or at the wrong place: commands that
/// count positions (APxx, ARMW) and those that read one slave and write the others (FRMW) are NOPs in it. While the
/// ring is open slaves behind the break can therefore be addressed by station address, not by position.
///
/// The time of the reference clock (FRMW to 0x0910) is the exception: route_time() says how it gets to both parts.
///
/// One thread at a time, like any port; status() and the counters may be read by others. Nothing allocates after
/// construction.
class RedundantPort final : public Port {
 public:
  /// How long to wait for the other half of an answer.
  struct Settings {
    /// How long after the send half of an answer waits for the other half before it is handed over alone: longer than
    /// a frame takes, shorter than the master waits for it.
    std::chrono::nanoseconds half_wait = std::chrono::microseconds{60};
  };
  /// Frames that may be on the way at the same time.
  static constexpr std::size_t kMaxInFlight = 16;
  /// After so many answers in a row of which only one half has come the ring counts as open, see RingStatus.
  static constexpr unsigned kLoneHalves = 3;

  /// How the time of the reference clock travels (FRMW to register 0x0910, ETG.1000.4 Table 60).
  struct TimeRoute {
    /// The interface whose copy passes the reference clock while it holds the reference time.
    enum class Leader : std::uint8_t { kPrimary, kSecondary };
    Leader leader = Leader::kPrimary;  ///< by the place of the reference clock
    /// With kPrimary: the time in the secondary copy is the one that the master has written, plus this delay in ns by
    /// which the copy passes later. Nothing: the secondary copy carries no time.
    std::optional<std::int32_t> other_later_ns{};
    /// RingStatus::primary_slaves of the break it was made for. Once the ring is closed, or open elsewhere, the primary
    /// copy leads and the other carries no time.
    std::uint16_t primary_slaves = 0;
  };

  /// Both ports and the clock must outlive this one.
  RedundantPort(Port& primary, Port& secondary, const rt::Clock& clock, Settings settings);
  /// With the default settings. Both ports and the clock must outlive it.
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

  /// From the next frame on. Any one thread. \rtsafe
  void route_time(const TimeRoute& route) noexcept;

  /// Any thread. \rtsafe
  [[nodiscard]] RingStatus status() const noexcept;
  /// Answers put together of two halves. Any thread. \rtsafe
  [[nodiscard]] std::uint64_t merged() const noexcept { return merged_.value(); }
  /// Halves of answers that were handed over alone. Any thread. \rtsafe
  [[nodiscard]] std::uint64_t halves() const noexcept { return halves_.value(); }
  /// Those of halves() whose other half was waited for in vain: it was late or lost. For the rest there was no other
  /// half, because the other copy had come all the way round. Any thread. \rtsafe
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
  unsigned lone_halves_ = 0;  ///< in a row
  Bytes copy_{};
  Bytes merged_frame_{};
  std::optional<ReceivedFrame> ready_;
  std::chrono::nanoseconds last_send_{0};
  Counter merged_;
  Counter halves_;
  Counter late_halves_;
  std::atomic<std::uint64_t> status_{0};
  std::atomic<std::uint64_t> time_route_{0};
};

}  // namespace driveline::port
