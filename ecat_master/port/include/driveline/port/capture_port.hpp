#pragma once

#include <array>
#include <atomic>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <thread>
#include <tl/expected.hpp>
#include <vector>

#include "driveline/port/counter.hpp"
#include "driveline/port/pcapng_writer.hpp"
#include "driveline/port/port.hpp"
#include "driveline/port/port_error.hpp"
#include "driveline/rt/clock.hpp"
#include "driveline/rt/file_descriptor.hpp"
#include "driveline/rt/spsc_ring.hpp"

namespace driveline::port {

/// /// Settings of a capture: destination file, buffer size, time base.
struct CaptureConfig {
  std::filesystem::path file;  ///< created or overwritten; may be a named pipe that Wireshark reads
  std::string interface_name;  ///< shown by Wireshark; empty for none
  std::size_t ring_frames =
      4096;  ///< frames buffered on their way to the file, >= 1; 4096 are 256 ms of an 8 kHz cycle, 6 MiB
  /// UNIX time at the zero of the clock; without a value the system clock's time at open(). Set it to make captures on
  /// a virtual clock reproducible.
  std::optional<std::chrono::nanoseconds> unix_time_of_zero{};
};

/// Counters of the frames that passed a CapturePort.
struct CaptureStatistics {
  std::uint64_t frames = 0;   ///< frames sent and received while capturing
  std::uint64_t written = 0;  ///< frames written to the file
  std::uint64_t dropped =
      0;  ///< frames missing from the file because the ring was full or the file could not be written
};

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
  ~CapturePort() override;

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
  // No default member initialisers: with them Record could not be an element of ring_ inside the class that declares
  // it.
  struct Record {
    std::chrono::nanoseconds time;
    std::uint64_t dropped_so_far;
    CaptureDirection direction;
    std::uint16_t size;
    std::array<std::byte, kMaxFrameBytes> bytes;

    [[nodiscard]] std::span<const std::byte> frame() const noexcept { return std::span{bytes}.first(size); }
  };

  CapturePort(Port& inner, const rt::Clock& clock, const CaptureConfig& config, rt::FileDescriptor file);

  // Used by the thread that uses the port.
  void record(CaptureDirection direction, std::chrono::nanoseconds time, std::span<const std::byte> frame) noexcept;

  // Used by the writer thread.
  void start_writer();
  void write_until_closed();
  void drain();
  void flush(std::uint64_t frames);
  [[nodiscard]] bool write_pending() noexcept;

  Port& inner_;
  const rt::Clock& clock_;
  const std::filesystem::path path_;
  const std::chrono::nanoseconds unix_time_of_zero_;

  rt::SpscRing<Record> ring_;
  Record outgoing_{};  // filled here and copied into the ring; too large for the stack of a cycle
  bool capturing_ = true;
  Counter frames_;

  rt::FileDescriptor file_;
  std::vector<std::byte> pending_;  // whole blocks not yet in the file
  PcapngWriter writer_{pending_};
  std::vector<Record> batch_;
  std::uint64_t dropped_reported_ = 0;
  std::int64_t file_bytes_ = 0;  // whole blocks in the file
  int write_error_ = 0;          // errno of the write that failed; afterwards nothing more is written
  Counter written_;
  Counter unwritten_;
  std::atomic<bool> closing_{false};
  std::thread thread_;
};

}  // namespace driveline::port
