#pragma once

#include <chrono>
#include <cstddef>
#include <memory>
#include <optional>
#include <tl/expected.hpp>
#include <utility>

#include "driveline/canopen_port/can_port.hpp"
#include "driveline/canopen_port/can_port_error.hpp"
#include "driveline/canopen_wire/socketcan.hpp"
#include "driveline/capture/frame_recorder.hpp"
#include "driveline/rt/clock.hpp"

namespace driveline::canopen {

/// Settings of a capture. A file whose name ends in ".pcapng" is written for Wireshark, with link type 227; any other
/// one is a log of candump. The name of the interface is that of the bus; empty for "can0".
using CanCaptureConfig = capture::CaptureConfig;
/// Counters of the frames that passed a CanCapture.
using CanCaptureStatistics = capture::CaptureStatistics;

/// A tee: passes every frame to another port and from it, and writes those that were sent and received to a file. The
/// cycle does no file access: a frame is copied into a wait-free ring, and an ordinary thread writes the file. When the
/// file cannot keep up, frames are dropped and counted; a pcapng file tells where, a log of candump cannot.
class CanCapture final : public CanPort {
 public:
  /// Creates the file and starts the writer thread. `inner` and `clock` (the clock of `inner`) must outlive the port.
  /// Not for the cycle; call it from an ordinary thread, whose scheduling the writer thread inherits. Error: the file
  /// cannot be written.
  [[nodiscard]] static tl::expected<std::unique_ptr<CanCapture>, CanPortError> open(CanPort& inner,
                                                                                    const rt::Clock& clock,
                                                                                    const CanCaptureConfig& config);

  [[nodiscard]] SendStatus send(const Frame& frame) noexcept override;
  [[nodiscard]] std::optional<ReceivedFrame> receive() noexcept override;
  bool wait_readable(std::chrono::nanoseconds deadline) noexcept override { return inner_.wait_readable(deadline); }
  [[nodiscard]] PortStatistics statistics() const noexcept override { return inner_.statistics(); }

  /// Writes the frames still in the ring, closes the file and returns the counters; an error if the file could not be
  /// written completely. Later frames are passed on without being recorded. Call it from the thread that uses the port,
  /// outside the cycle; a second call returns the same result.
  tl::expected<CanCaptureStatistics, CanPortError> close();
  /// Counters of the capture so far; `written` lags behind `frames`. Any thread. \rtsafe
  [[nodiscard]] CanCaptureStatistics capture_statistics() const noexcept { return recorder_->statistics(); }

 private:
  using Recorder = capture::FrameRecorder<socketcan::kFrameBytes>;

  CanCapture(CanPort& inner, const rt::Clock& clock, std::unique_ptr<Recorder> recorder) noexcept
      : inner_(inner), clock_(clock), recorder_(std::move(recorder)) {}

  CanPort& inner_;
  const rt::Clock& clock_;
  std::unique_ptr<Recorder> recorder_;
};

}  // namespace driveline::canopen
