#pragma once

#include <atomic>
#include <chrono>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <thread>
#include <tl/expected.hpp>
#include <vector>

#include "driveline/capture/capture_format.hpp"
#include "driveline/rt/clock.hpp"
#include "driveline/rt/counter.hpp"
#include "driveline/rt/file_descriptor.hpp"

namespace driveline::capture {

/// Settings of a capture: destination file, buffer size, time base.
struct CaptureConfig {
  std::filesystem::path file{};    ///< created or overwritten; may be a named pipe
  std::string interface_name{};    ///< of the bus; empty for none
  std::size_t ring_frames = 4096;  ///< frames buffered on their way to the file, >= 1
  /// UNIX time at the zero of the clock; without a value the system clock's time at open(). Set it to make captures on
  /// a virtual clock reproducible.
  std::optional<std::chrono::nanoseconds> unix_time_of_zero{};
};

/// Why a capture could not be started or written.
struct CaptureError {
  bool of_file = true;   ///< about the file; else about the thread that writes it
  int error_number = 0;  ///< errno
  std::string message;   ///< one sentence: what is wrong
};

/// Counters of the frames of a capture.
struct CaptureStatistics {
  std::uint64_t frames = 0;   ///< frames that passed while capturing
  std::uint64_t written = 0;  ///< frames written to the file
  std::uint64_t dropped =
      0;  ///< frames missing from the file because the ring was full or the file could not be written
};

/// The file of a capture, and the ordinary thread that writes it. The file grows by whole blocks: it is readable up to
/// the last complete block while the capture runs, after a crash and after the disk has become full.
class CaptureFile {
 public:
  /// Creates the file and writes its header. Not for the cycle.
  [[nodiscard]] static tl::expected<std::unique_ptr<CaptureFile>, CaptureError> create(const CaptureConfig& config,
                                                                                       MakeCaptureFormat make_format,
                                                                                       const rt::Clock& clock);
  CaptureFile(const CaptureFile&) = delete;
  CaptureFile& operator=(const CaptureFile&) = delete;
  /// Precondition: the thread has been stopped.
  ~CaptureFile() = default;

  /// Starts the thread, which calls `drain` every few milliseconds and, when stop() has been called, a last time before
  /// `end`. The thread inherits the scheduling of the caller.
  [[nodiscard]] tl::expected<void, CaptureError> start(std::function<void()> drain, std::function<void()> end);
  /// Ends the thread and closes the file; a second call does nothing.
  void stop();

  /// \name Functions of the thread
  /// @{

  /// Encodes a frame that was captured at `time` of the clock.
  void packet(std::chrono::nanoseconds time, CaptureDirection direction, std::uint64_t dropped_before,
              std::span<const std::byte> bytes);
  /// Writes what has been encoded, which holds `frames` frames. After the first failure it is discarded and counted.
  void flush(std::uint64_t frames);
  /// Writes the end of the file; `frames` have passed, and `dropped` of them found no room in the ring.
  void finish(std::uint64_t frames, std::uint64_t dropped);
  /// @}

  /// Frames in the file. Any thread. \rtsafe
  [[nodiscard]] std::uint64_t written() const noexcept { return written_.value(); }
  /// Frames that could not be written. Any thread. \rtsafe
  [[nodiscard]] std::uint64_t unwritten() const noexcept { return unwritten_.value(); }
  /// Why the file is not complete; empty if it is. After stop().
  [[nodiscard]] std::optional<CaptureError> error() const;

 private:
  CaptureFile(const CaptureConfig& config, MakeCaptureFormat make_format, const rt::Clock& clock,
              rt::FileDescriptor file);
  [[nodiscard]] bool write_pending() noexcept;

  const rt::Clock& clock_;
  const std::filesystem::path path_;
  const std::chrono::nanoseconds unix_time_of_zero_;
  rt::FileDescriptor file_;
  std::vector<std::byte> pending_;  // whole blocks not yet in the file
  std::unique_ptr<CaptureFormat> format_;
  std::int64_t file_bytes_ = 0;  // whole blocks in the file
  int write_error_ = 0;          // errno of the write that failed; afterwards nothing more is written
  rt::Counter written_;
  rt::Counter unwritten_;
  std::atomic<bool> closing_{false};
  std::thread thread_;
};

}  // namespace driveline::capture
