#include "driveline/capture/capture_file.hpp"

#include <fcntl.h>
#include <pthread.h>
#include <unistd.h>

#include <cerrno>
#include <csignal>
#include <system_error>
#include <utility>

namespace driveline::capture {

namespace {

using std::chrono::nanoseconds;

constexpr std::chrono::milliseconds kDrainInterval{2};  // the cycle must not wake the writer, so the writer polls

CaptureError file_error(const std::filesystem::path& path, const char* what, int error_number) {
  return {true, error_number,
          std::string{"Cannot "} + what + " capture file '" + path.string() +
              "': " + std::generic_category().message(error_number) + "."};
}

nanoseconds unix_time_of_zero_now(const rt::Clock& clock) {
  return std::chrono::system_clock::now().time_since_epoch() - clock.now();
}

}  // namespace

tl::expected<std::unique_ptr<CaptureFile>, CaptureError> CaptureFile::create(const CaptureConfig& config,
                                                                             MakeCaptureFormat make_format,
                                                                             const rt::Clock& clock) {
  rt::FileDescriptor file{::open(config.file.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0644)};
  if (!file.valid()) return tl::unexpected(file_error(config.file, "create", errno));
  // Not make_unique: the constructor is private.
  std::unique_ptr<CaptureFile> capture{new CaptureFile{config, make_format, clock, std::move(file)}};
  capture->format_->header(config.interface_name);
  if (!capture->write_pending()) return tl::unexpected(file_error(config.file, "write", capture->write_error_));
  return capture;
}

CaptureFile::CaptureFile(const CaptureConfig& config, MakeCaptureFormat make_format, const rt::Clock& clock,
                         rt::FileDescriptor file)
    : clock_{clock},
      path_{config.file},
      unix_time_of_zero_{config.unix_time_of_zero ? *config.unix_time_of_zero : unix_time_of_zero_now(clock)},
      file_{std::move(file)},
      format_{make_format(pending_)} {}

tl::expected<void, CaptureError> CaptureFile::start(std::function<void()> drain, std::function<void()> end) {
  // The writer handles no signals: they are for the threads that shut the line down in order, and with SIGPIPE blocked
  // a pipe without a reader is an error of write() instead of the end of the process.
  sigset_t all{};
  sigset_t before{};
  sigfillset(&all);
  pthread_sigmask(SIG_SETMASK, &all, &before);
  const std::unique_ptr<sigset_t, void (*)(sigset_t*)> restore{
      &before, [](sigset_t* mask) { pthread_sigmask(SIG_SETMASK, mask, nullptr); }};
  try {
    thread_ = std::thread{[this, work = std::move(drain), last = std::move(end)] {
      // Read the flag before emptying the ring, so that everything captured before stop() is in the file.
      while (!closing_.load(std::memory_order_acquire)) {
        work();
        std::this_thread::sleep_for(kDrainInterval);
      }
      work();
      last();
    }};
  } catch (const std::system_error& error) {
    return tl::unexpected(
        CaptureError{false, error.code().value(),
                     std::string{"Cannot start the thread that writes the capture: "} + error.code().message() + "."});
  }
  return {};
}

void CaptureFile::stop() {
  if (!thread_.joinable()) return;
  closing_.store(true, std::memory_order_release);
  thread_.join();
  // Some file systems report a failed write only on close().
  if (::close(file_.release()) != 0 && write_error_ == 0) write_error_ = errno;
}

void CaptureFile::packet(nanoseconds time, CaptureDirection direction, std::uint64_t dropped_before,
                         std::span<const std::byte> bytes) {
  format_->packet({.unix_time = unix_time_of_zero_ + time,
                   .direction = direction,
                   .dropped_before = dropped_before,
                   .bytes = bytes});
}

void CaptureFile::flush(std::uint64_t frames) {
  const bool written = write_error_ == 0 && write_pending();
  (written ? written_ : unwritten_).add(frames);
  pending_.clear();
}

void CaptureFile::finish(std::uint64_t frames, std::uint64_t dropped) {
  format_->statistics(unix_time_of_zero_ + clock_.now(), frames, dropped + unwritten());
  flush(0);
}

bool CaptureFile::write_pending() noexcept {
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

std::optional<CaptureError> CaptureFile::error() const {
  if (write_error_ == 0) return std::nullopt;
  return file_error(path_, "write", write_error_);
}

}  // namespace driveline::capture
