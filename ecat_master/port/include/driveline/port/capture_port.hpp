#pragma once

#include <chrono>
#include <cstddef>
#include <memory>
#include <optional>
#include <span>
#include <tl/expected.hpp>
#include <utility>

#include "driveline/capture/frame_recorder.hpp"
#include "driveline/port/port.hpp"
#include "driveline/port/port_error.hpp"
#include "driveline/rt/clock.hpp"

namespace driveline::port {

/// Settings of a capture; 4096 frames are 256 ms of an 8 kHz cycle and take 6 MiB.
using CaptureConfig = capture::CaptureConfig;
/// Counters of the frames that passed a CapturePort.
using CaptureStatistics = capture::CaptureStatistics;

/// A tee: passes every frame to another port and writes the frames that were really sent and received to a pcapng file
/// that Wireshark opens.
///
/// The cycle does no file access: a frame is copied into a wait-free ring, and an ordinary thread writes the file. When
/// the file cannot keep up, frames are dropped and counted, and the next packet in the file says how many are missing
/// before it.
///
/// The file grows by whole blocks. It is readable up to the last complete block while the capture runs, after a crash
/// and after the disk has become full.
class CapturePort final : public Port {
 public:
  /// Creates the file and starts the writer thread. `inner` and `clock` (the clock of `inner`) must outlive the port.
  /// Not for the cycle; call it from an ordinary thread, whose scheduling the writer thread inherits.
  [[nodiscard]] static tl::expected<std::unique_ptr<CapturePort>, PortError> open(Port& inner, const rt::Clock& clock,
                                                                                  const CaptureConfig& config);

  CapturePort(const CapturePort&) = delete;
  CapturePort& operator=(const CapturePort&) = delete;
  /// Closes the file and discards the result of close().
  ~CapturePort() override = default;

  /// \rtsafe
  [[nodiscard]] SendStatus send(std::span<const std::byte> frame) noexcept override;
  /// \rtsafe
  void hold_until(std::chrono::nanoseconds instant) noexcept override { inner_.hold_until(instant); }
  /// \rtsafe
  [[nodiscard]] std::optional<ReceivedFrame> receive() noexcept override;
  bool wait_readable(std::chrono::nanoseconds deadline) noexcept override { return inner_.wait_readable(deadline); }
  /// \rtsafe
  [[nodiscard]] std::chrono::nanoseconds last_send_time() const noexcept override { return inner_.last_send_time(); }

  /// Writes the frames still in the ring, closes the file and returns the counters; kFile if the file could not be
  /// written completely. Later frames are passed on without being recorded. Call it from the thread that uses the port,
  /// outside the cycle; a second call returns the same result.
  tl::expected<CaptureStatistics, PortError> close();

  /// Counters so far; `written` lags behind `frames`. Any thread. \rtsafe
  [[nodiscard]] CaptureStatistics statistics() const noexcept;

 private:
  using Recorder = capture::FrameRecorder<kMaxFrameBytes>;

  CapturePort(Port& inner, std::unique_ptr<Recorder> recorder) noexcept
      : inner_{inner}, recorder_{std::move(recorder)} {}

  Port& inner_;
  std::unique_ptr<Recorder> recorder_;
};

}  // namespace driveline::port
