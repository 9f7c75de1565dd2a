#pragma once

#include <array>
#include <optional>
#include <vector>

#include "driveline/ecat_master/bus/datagram_exchange.hpp"
#include "driveline/ecat_master/bus/frame_tag.hpp"
#include "driveline/port/port.hpp"
#include "driveline/rt/clock.hpp"

namespace driveline::ecat_master {

/// Exchange directly through the port, while no cycle runs.
class DirectExchange final : public DatagramExchange {
 public:
  /// Most frames in flight: more would overrun the receive buffers of network cards and sockets.
  static constexpr std::size_t kMaxInFlight = 24;
  /// Most other frames that are taken while answers are awaited; the time-out may end the wait before.
  static constexpr std::uint32_t kMostUnexpected = 10'000;

  /// Time-out and retries of frames.
  struct Settings {
    /// Time-out for the answers of the first try; the transmission time of the frames is added. Each further try waits
    /// four times as long as the previous one, at most 512 ms: a lost frame costs 2 ms, and a line whose machine is
    /// suspended may be silent for 0.68 s.
    std::chrono::nanoseconds timeout = std::chrono::milliseconds{2};
    int retries = 4;  ///< further tries after the first
    /// FrameTag::instance; none: an unused instance from next_frame_instance().
    std::optional<std::uint16_t> instance = std::nullopt;
    bool guest = false;  ///< for a tool on a line that may have a master: marks its frames (FrameTag::guest())
  };

  /// Port and clock must outlive the exchange.
  DirectExchange(port::Port& port, rt::Clock& clock, Settings settings);
  /// With the default settings.
  DirectExchange(port::Port& port, rt::Clock& clock) : DirectExchange(port, clock, Settings{}) {}

  [[nodiscard]] Result<void> exchange(std::span<Request> requests) override;
  void pause(std::chrono::nanoseconds duration) override;
  /// Time of the clock given to the constructor.
  [[nodiscard]] std::chrono::nanoseconds now() const noexcept override { return clock_.now(); }
  /// FrameTag::instance of all frames of this exchange.
  [[nodiscard]] std::uint16_t instance() const noexcept { return instance_; }
  /// Counters since construction.
  [[nodiscard]] const ExchangeStatistics& statistics() const noexcept { return statistics_; }

 private:
  /// A frame in flight: it carries the requests first..last and has the number `sequence`.
  struct Flight {
    std::uint32_t sequence = 0;
    std::size_t first = 0;
    std::size_t last = 0;
    bool pending = false;
  };

  [[nodiscard]] bool is_open(const Request& request) const noexcept;
  [[nodiscard]] Result<std::size_t> send_pending(std::span<Request> requests, std::size_t next);
  [[nodiscard]] Result<std::size_t> send_frame(std::span<Request> requests, std::size_t first);
  [[nodiscard]] std::chrono::nanoseconds timeout() const noexcept;
  void collect(std::span<Request> requests);
  [[nodiscard]] bool accept(std::span<Request> requests, std::span<const std::byte> frame);
  [[nodiscard]] FrameTag next_tag() noexcept;
  void note_foreign(std::span<const std::byte> frame);

  port::Port& port_;
  rt::Clock& clock_;
  Settings settings_;
  std::uint16_t instance_;
  ExchangeStatistics statistics_;
  std::uint32_t sequence_ = 0;
  int attempt_ = 0;
  std::vector<Flight> flights_;
  std::array<std::byte, port::kMaxFrameBytes> buffer_{};
};

/// Copies the answers in `frame` into `requests` when its datagrams match the requests, numbered from 0 in the same
/// order. Returns false and changes nothing when they do not match. \rtsafe
[[nodiscard]] bool match_answers(std::span<Request> requests, std::span<const std::byte> frame) noexcept;

}  // namespace driveline::ecat_master
