#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <deque>
#include <functional>
#include <vector>

#include "driveline/port/port.hpp"
#include "driveline/rt/clock.hpp"
#include "driveline/wire/command.hpp"

namespace driveline::bus_test {

/// Forwards everything to another port; base of the decorators below.
class PassingPort : public port::Port {
 public:
  explicit PassingPort(port::Port& inner) : inner_(inner) {}
  [[nodiscard]] port::SendStatus send(std::span<const std::byte> frame) noexcept override { return inner_.send(frame); }
  void hold_until(std::chrono::nanoseconds instant) noexcept override { inner_.hold_until(instant); }
  [[nodiscard]] std::optional<port::ReceivedFrame> receive() noexcept override { return inner_.receive(); }
  bool wait_readable(std::chrono::nanoseconds deadline) noexcept override { return inner_.wait_readable(deadline); }
  [[nodiscard]] std::chrono::nanoseconds last_send_time() const noexcept override { return inner_.last_send_time(); }

 protected:
  port::Port& inner_;
};

/// The source address, which holds the master's frame number, without the bit that slaves set.
using SourceAddress = std::array<std::byte, 6>;
[[nodiscard]] SourceAddress source_of(std::span<const std::byte> frame) noexcept;

/// Reproducible chance: a call returns true with the probability 1 / `one_in`, without a pattern that the master's
/// own sequences could match.
class Chance {
 public:
  explicit Chance(std::uint32_t one_in, std::uint32_t seed = 1) : one_in_(one_in), state_(seed) {}
  [[nodiscard]] bool operator()() noexcept {
    state_ = state_ * 1664525U + 1013904223U;
    return (state_ >> 8) % one_in_ == 0;
  }

 private:
  std::uint32_t one_in_;
  std::uint32_t state_;
};

/// Loses chosen frames: on their way out, so that no slave sees them, or on their way back, after all slaves have
/// processed them.
class LossyPort final : public PassingPort {
 public:
  enum class Direction : std::uint8_t { kOut, kBack };
  /// Decides by the number of the frame (0 = first) and its bytes.
  using Loses = std::function<bool(std::uint64_t number, std::span<const std::byte> frame)>;

  LossyPort(port::Port& inner, Direction direction, Loses loses)
      : PassingPort(inner), direction_(direction), loses_(std::move(loses)) {}

  [[nodiscard]] port::SendStatus send(std::span<const std::byte> frame) noexcept override;
  [[nodiscard]] std::optional<port::ReceivedFrame> receive() noexcept override;

  [[nodiscard]] std::uint64_t sent() const noexcept { return sent_; }
  [[nodiscard]] std::uint64_t lost() const noexcept { return lost_; }

 private:
  Direction direction_;
  Loses loses_;
  std::uint64_t sent_ = 0;
  std::uint64_t lost_ = 0;
  std::vector<SourceAddress> doomed_;
};

/// Delays frames selected by `delays` for an additional `delay`; other frames overtake them.
class LatePort final : public PassingPort {
 public:
  using Delays = std::function<bool(std::uint64_t number)>;

  LatePort(port::Port& inner, rt::Clock& clock, std::chrono::nanoseconds delay, Delays delays)
      : PassingPort(inner), clock_(clock), delay_(delay), delays_(std::move(delays)) {}

  [[nodiscard]] port::SendStatus send(std::span<const std::byte> frame) noexcept override;
  [[nodiscard]] std::optional<port::ReceivedFrame> receive() noexcept override;
  bool wait_readable(std::chrono::nanoseconds deadline) noexcept override;

  [[nodiscard]] std::uint64_t delayed() const noexcept { return delayed_; }

 private:
  struct Kept {
    std::vector<std::byte> bytes;
    std::chrono::nanoseconds due{};
  };

  rt::Clock& clock_;
  std::chrono::nanoseconds delay_;
  Delays delays_;
  std::uint64_t sent_ = 0;
  std::uint64_t delayed_ = 0;
  std::vector<SourceAddress> late_;
  std::deque<Kept> kept_;
  std::vector<std::byte> handed_out_;
};

/// A port with launch times: frames leave at the instant of hold_until(). The caller waits instead of the kernel, which
/// makes no difference on the virtual clock.
class HoldingPort final : public PassingPort {
 public:
  HoldingPort(port::Port& inner, rt::VirtualClock& clock) : PassingPort(inner), clock_(clock) {}
  [[nodiscard]] port::SendStatus send(std::span<const std::byte> frame) noexcept override {
    earliest_ = std::max(earliest_, hold_until_ - clock_.now());
    clock_.sleep_until(hold_until_);
    return inner_.send(frame);
  }
  void hold_until(std::chrono::nanoseconds instant) noexcept override { hold_until_ = instant; }
  /// The longest time that a frame was held back.
  [[nodiscard]] std::chrono::nanoseconds earliest() const noexcept { return earliest_; }

 private:
  rt::VirtualClock& clock_;
  std::chrono::nanoseconds hold_until_{};
  std::chrono::nanoseconds earliest_{};
};

/// Changes frames on their way out or back.
class ChangingPort final : public PassingPort {
 public:
  using Change = std::function<void(std::span<std::byte> frame)>;

  /// Either function may be empty.
  ChangingPort(port::Port& inner, Change out, Change back)
      : PassingPort(inner), out_(std::move(out)), back_(std::move(back)) {}

  [[nodiscard]] port::SendStatus send(std::span<const std::byte> frame) noexcept override;
  [[nodiscard]] std::optional<port::ReceivedFrame> receive() noexcept override;

 private:
  Change out_;
  Change back_;
  std::vector<std::byte> bytes_;
};

/// The first datagram of a frame built by the master (offsets: Ethernet 14, EtherCAT header 2).
struct FirstDatagram {
  wire::Command command;
  std::uint16_t adp;
  std::uint16_t ado;
  std::span<const std::byte> data;
};
[[nodiscard]] FirstDatagram first_datagram(std::span<const std::byte> frame) noexcept;

}  // namespace driveline::bus_test
