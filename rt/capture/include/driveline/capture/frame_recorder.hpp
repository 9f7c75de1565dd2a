#pragma once

#include <algorithm>
#include <array>

#include "driveline/capture/capture_file.hpp"
#include "driveline/rt/spsc_ring.hpp"

namespace driveline::capture {

/// Records frames of up to `MaxBytes` from a cycle into a file: a frame is copied into a wait-free ring, and an
/// ordinary thread writes the file. When the file cannot keep up, frames are dropped and counted.
template <std::size_t MaxBytes>
class FrameRecorder {
 public:
  /// Creates the file and starts the writer thread, which inherits the scheduling of the caller. `clock` must outlive
  /// the recorder. Not for the cycle.
  [[nodiscard]] static tl::expected<std::unique_ptr<FrameRecorder>, CaptureError> open(const CaptureConfig& config,
                                                                                       MakeCaptureFormat make_format,
                                                                                       const rt::Clock& clock) {
    auto file = CaptureFile::create(config, make_format, clock);
    if (!file) return tl::unexpected(file.error());
    // Not make_unique: the constructor is private.
    std::unique_ptr<FrameRecorder> recorder{new FrameRecorder{config.ring_frames, std::move(*file)}};
    FrameRecorder* self = recorder.get();
    if (auto started = self->file_->start([self] { self->drain(); }, [self] { self->finish(); }); !started)
      return tl::unexpected(started.error());
    return recorder;
  }

  FrameRecorder(const FrameRecorder&) = delete;
  FrameRecorder& operator=(const FrameRecorder&) = delete;
  /// Closes the file and discards the result of close().
  ~FrameRecorder() { file_->stop(); }

  /// Copies a frame that passed at `time` of the clock; bytes beyond `MaxBytes` are cut. Only one thread at a time.
  /// \rtsafe
  void record(CaptureDirection direction, std::chrono::nanoseconds time, std::span<const std::byte> frame) noexcept {
    if (!capturing_) return;
    outgoing_.time = time;
    outgoing_.dropped_so_far = ring_.dropped();
    outgoing_.direction = direction;
    outgoing_.size = static_cast<std::uint16_t>(std::min(frame.size(), outgoing_.bytes.size()));
    std::copy_n(frame.begin(), outgoing_.size, outgoing_.bytes.begin());
    frames_.add();
    ring_.try_push(outgoing_);  // a full ring counts the drop
  }

  /// Writes the frames still in the ring, closes the file and returns the counters; an error if the file could not be
  /// written completely. Later frames are not recorded. Call it from the thread that records, outside the cycle; a
  /// second call returns the same result.
  tl::expected<CaptureStatistics, CaptureError> close() {
    capturing_ = false;
    file_->stop();
    if (auto error = file_->error()) return tl::unexpected(*error);
    return statistics();
  }

  /// Counters so far; `written` lags behind `frames`. Any thread. \rtsafe
  [[nodiscard]] CaptureStatistics statistics() const noexcept {
    return {.frames = frames_.value(), .written = file_->written(), .dropped = ring_.dropped() + file_->unwritten()};
  }

 private:
  static constexpr std::size_t kBatchFrames = 64;  // frames written to the file in one call

  // No default member initialisers: with them Record could not be an element of ring_ inside the class that declares
  // it.
  struct Record {
    std::chrono::nanoseconds time;
    std::uint64_t dropped_so_far;
    CaptureDirection direction;
    std::uint16_t size;
    std::array<std::byte, MaxBytes> bytes;
  };

  FrameRecorder(std::size_t ring_frames, std::unique_ptr<CaptureFile> file)
      : ring_{ring_frames}, batch_(kBatchFrames), file_{std::move(file)} {}

  // Used by the writer thread.
  void drain() {
    for (std::size_t count = ring_.pop(batch_); count != 0; count = ring_.pop(batch_)) {
      for (const Record& record : std::span{batch_}.first(count)) {
        file_->packet(record.time, record.direction, record.dropped_so_far - dropped_reported_,
                      std::span{record.bytes}.first(record.size));
        dropped_reported_ = record.dropped_so_far;
      }
      file_->flush(count);
    }
  }
  void finish() { file_->finish(frames_.value(), ring_.dropped()); }

  rt::SpscRing<Record> ring_;
  Record outgoing_{};  // filled here and copied into the ring; too large for the stack of a cycle
  bool capturing_ = true;
  rt::Counter frames_;
  std::vector<Record> batch_;
  std::uint64_t dropped_reported_ = 0;
  std::unique_ptr<CaptureFile> file_;
};

}  // namespace driveline::capture
