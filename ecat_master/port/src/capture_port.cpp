#include "driveline/port/capture_port.hpp"

#include <fcntl.h>
#include <pthread.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <csignal>
#include <system_error>

namespace driveline::port {

namespace {

using std::chrono::nanoseconds;

constexpr std::size_t kBatchFrames = 64;                // frames written to the file in one call
constexpr std::chrono::milliseconds kDrainInterval{2};  // the cycle must not wake the writer, so the writer polls

PortError file_error(const std::filesystem::path& path, const char* what, int error_number) {
  return {PortErrorCode::kFile, error_number,
          std::string{"Cannot "} + what + " capture file '" + path.string() +
              "': " + std::generic_category().message(error_number) + "."};
}

nanoseconds unix_time_of_zero_now(const rt::Clock& clock) {
  return std::chrono::system_clock::now().time_since_epoch() - clock.now();
}

}  // namespace

tl::expected<std::unique_ptr<CapturePort>, PortError> CapturePort::open(Port& inner, const rt::Clock& clock,
                                                                        const CaptureConfig& config) {
  rt::FileDescriptor file{::open(config.file.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0644)};
  if (!file.valid()) return tl::unexpected(file_error(config.file, "create", errno));

  // Not make_unique: the constructor is private.
  std::unique_ptr<CapturePort> port{new CapturePort{inner, clock, config, std::move(file)}};
  port->writer_.header(config.interface_name);
  if (!port->write_pending()) return tl::unexpected(file_error(config.file, "write", port->write_error_));
  try {
    port->start_writer();
  } catch (const std::system_error& error) {
    return tl::unexpected(
        PortError{PortErrorCode::kSystem, error.code().value(),
                  std::string{"Cannot start the thread that writes the capture: "} + error.code().message() + "."});
  }
  return port;
}

CapturePort::CapturePort(Port& inner, const rt::Clock& clock, const CaptureConfig& config, rt::FileDescriptor file)
    : inner_{inner},
      clock_{clock},
      path_{config.file},
      unix_time_of_zero_{config.unix_time_of_zero ? *config.unix_time_of_zero : unix_time_of_zero_now(clock)},
      ring_{config.ring_frames},
      file_{std::move(file)},
      batch_(kBatchFrames) {}

CapturePort::~CapturePort() {
  static_cast<void>(close());
}

SendStatus CapturePort::send(std::span<const std::byte> frame) noexcept {
  const SendStatus status = inner_.send(frame);
  if (status == SendStatus::kSent) record(CaptureDirection::kOutbound, inner_.last_send_time(), frame);
  return status;
}

std::optional<ReceivedFrame> CapturePort::receive() noexcept {
  const auto frame = inner_.receive();
  if (frame) record(CaptureDirection::kInbound, frame->time, frame->bytes);
  return frame;
}

void CapturePort::record(CaptureDirection direction, nanoseconds time, std::span<const std::byte> frame) noexcept {
  if (!capturing_) return;
  outgoing_.time = time;
  outgoing_.dropped_so_far = ring_.dropped();
  outgoing_.direction = direction;
  outgoing_.size = static_cast<std::uint16_t>(std::min(frame.size(), outgoing_.bytes.size()));
  std::copy_n(frame.begin(), outgoing_.size, outgoing_.bytes.begin());
  frames_.add();
  ring_.try_push(outgoing_);  // a full ring counts the drop
}

void CapturePort::start_writer() {
  // The writer handles no signals: they are for the threads that shut the line down in order, and with SIGPIPE blocked
  // a pipe without a reader is an error of write() instead of the end of the process.
  sigset_t all{};
  sigset_t before{};
  sigfillset(&all);
  pthread_sigmask(SIG_SETMASK, &all, &before);
  const std::unique_ptr<sigset_t, void (*)(sigset_t*)> restore{
      &before, [](sigset_t* mask) { pthread_sigmask(SIG_SETMASK, mask, nullptr); }};
  thread_ = std::thread{[this] { write_until_closed(); }};
}

void CapturePort::write_until_closed() {
  // Read the flag before emptying the ring, so that everything captured before close() is in the file.
  while (!closing_.load(std::memory_order_acquire)) {
    drain();
    std::this_thread::sleep_for(kDrainInterval);
  }
  drain();
  writer_.statistics(unix_time_of_zero_ + clock_.now(), frames_.value(), ring_.dropped() + unwritten_.value());
  flush(0);
}

void CapturePort::drain() {
  for (std::size_t count = ring_.pop(batch_); count != 0; count = ring_.pop(batch_)) {
    for (const Record& record : std::span{batch_}.first(count)) {
      writer_.packet({.unix_time = unix_time_of_zero_ + record.time,
                      .direction = record.direction,
                      .dropped_before = record.dropped_so_far - dropped_reported_,
                      .bytes = record.frame()});
      dropped_reported_ = record.dropped_so_far;
    }
    flush(count);
  }
}

/// Writes the pending blocks, which hold `frames` frames. After the first failure, discards them.
void CapturePort::flush(std::uint64_t frames) {
  const bool written = write_error_ == 0 && write_pending();
  (written ? written_ : unwritten_).add(frames);
  pending_.clear();
}

bool CapturePort::write_pending() noexcept {
  std::span<const std::byte> rest{pending_};
  while (!rest.empty()) {
    const ssize_t result = ::write(file_.get(), rest.data(), rest.size());
    if (result < 0) {
      if (errno == EINTR) continue;
      write_error_ = errno;
      // Removes a half-written block. A pipe cannot be truncated: its reader gets the fragment.
      [[maybe_unused]] const int ignored = ::ftruncate(file_.get(), file_bytes_);
      return false;
    }
    rest = rest.subspan(static_cast<std::size_t>(result));
  }
  file_bytes_ += static_cast<std::int64_t>(pending_.size());
  pending_.clear();
  return true;
}

tl::expected<CaptureStatistics, PortError> CapturePort::close() {
  capturing_ = false;
  if (thread_.joinable()) {
    closing_.store(true, std::memory_order_release);
    thread_.join();
    // Some file systems report a failed write only on close().
    if (::close(file_.release()) != 0 && write_error_ == 0) write_error_ = errno;
  }
  if (write_error_ != 0) return tl::unexpected(file_error(path_, "write", write_error_));
  return statistics();
}

CaptureStatistics CapturePort::statistics() const noexcept {
  return {.frames = frames_.value(), .written = written_.value(), .dropped = ring_.dropped() + unwritten_.value()};
}

}  // namespace driveline::port
