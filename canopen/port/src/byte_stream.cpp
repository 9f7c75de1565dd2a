#include "driveline/canopen_port/byte_stream.hpp"

#include <fcntl.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <utility>

#include "driveline/rt/time_conversion.hpp"

namespace driveline::canopen {
namespace {

using std::chrono::nanoseconds;

bool is_socket(int descriptor) noexcept {
  int type = 0;
  socklen_t size = sizeof type;
  return ::getsockopt(descriptor, SOL_SOCKET, SO_TYPE, &type, &size) == 0;
}

/// The call is to be repeated later, or at once.
bool is_passing(int error_number) noexcept {
  return error_number == EAGAIN || error_number == EINTR;
}

}  // namespace

ByteStream::ByteStream(rt::FileDescriptor descriptor, rt::Clock& clock) noexcept
    : descriptor_(std::move(descriptor)), clock_(clock), socket_(is_socket(descriptor_.get())) {
  const int flags = ::fcntl(descriptor_.get(), F_GETFL);
  if (flags >= 0) ::fcntl(descriptor_.get(), F_SETFL, flags | O_NONBLOCK);
}

std::string_view ByteStream::read() noexcept {
  flush();
  if (ended_) return {};
  const ssize_t count = ::read(descriptor_.get(), input_.data(), input_.size());
  if (count > 0) return {input_.data(), static_cast<std::size_t>(count)};
  // A terminal that hangs up gives EIO.
  if (count == 0 || !is_passing(errno)) ended_ = true;
  return {};
}

bool ByteStream::write(std::string_view text) noexcept {
  if (broken()) return false;
  flush();
  if (end_ + text.size() > output_.size()) make_room();
  if (end_ + text.size() > output_.size()) return false;
  std::copy(text.begin(), text.end(), output_.begin() + static_cast<std::ptrdiff_t>(end_));
  end_ += text.size();
  flush();
  return true;
}

void ByteStream::make_room() noexcept {
  std::copy(output_.begin() + static_cast<std::ptrdiff_t>(begin_), output_.begin() + static_cast<std::ptrdiff_t>(end_),
            output_.begin());
  end_ -= std::exchange(begin_, 0);
}

void ByteStream::flush() noexcept {
  while (begin_ < end_ && !broken()) {
    const char* from = output_.data() + begin_;
    const ssize_t count = socket_ ? ::send(descriptor_.get(), from, end_ - begin_, MSG_NOSIGNAL | MSG_DONTWAIT)
                                  : ::write(descriptor_.get(), from, end_ - begin_);
    if (count > 0) {
      begin_ += static_cast<std::size_t>(count);
    } else if (count < 0 && errno == EINTR) {
      continue;
    } else {
      broken_ = count < 0 && !is_passing(errno);
      break;
    }
  }
  if (begin_ == end_ || broken()) begin_ = end_ = 0;
}

bool ByteStream::wait(nanoseconds deadline) noexcept {
  while (!ended_) {
    const timespec timeout = rt::to_timespec(std::max(deadline - clock_.now(), nanoseconds::zero()));
    const int out = begin_ < end_ && !broken_ ? POLLOUT : 0;
    pollfd request{descriptor_.get(), static_cast<short>(POLLIN | out), 0};
    const int ready = ::ppoll(&request, 1, &timeout, nullptr);
    if (ready == 0) return false;
    if (ready < 0) {
      if (errno == EINTR) continue;
      ended_ = true;
    } else if ((request.revents & POLLOUT) != 0) {
      flush();
    }
    if ((request.revents & (POLLIN | POLLHUP | POLLERR | POLLNVAL)) != 0) return true;
  }
  return true;
}

}  // namespace driveline::canopen
