#include "driveline/port/frame_waiter.hpp"

#include <poll.h>
#include <sys/socket.h>
#include <sys/timerfd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>

#include "driveline/rt/time_conversion.hpp"

namespace driveline::port {

tl::expected<std::unique_ptr<FrameWaiter>, PortError> FrameWaiter::open(const RawSocketPort& first,
                                                                        const RawSocketPort* second) {
  rt::FileDescriptor timer{timerfd_create(CLOCK_MONOTONIC, TFD_NONBLOCK | TFD_CLOEXEC)};
  if (!timer.valid()) {
    return tl::unexpected(
        PortError{PortErrorCode::kSystem, errno, std::string("No timer to wait with: ") + std::strerror(errno)});
  }
  // Not make_unique: the constructor is private. poll() skips negative descriptors.
  return std::unique_ptr<FrameWaiter>{
      new FrameWaiter{std::move(timer), {first.descriptor(), second != nullptr ? second->descriptor() : -1}}};
}

bool FrameWaiter::wait(std::chrono::nanoseconds deadline) noexcept {
  if (deadline != armed_) {
    // 0 would disarm the timer; a time in the past expires at once.
    itimerspec at{};
    at.it_value = rt::to_timespec(std::max(deadline, std::chrono::nanoseconds{1}));
    if (timerfd_settime(timer_.get(), TFD_TIMER_ABSTIME, &at, nullptr) != 0) return false;
    armed_ = deadline;
  }
  while (true) {
    std::array<pollfd, 3> requests{pollfd{sockets_[0], POLLIN, 0}, pollfd{sockets_[1], POLLIN, 0},
                                   pollfd{timer_.get(), POLLIN, 0}};
    if (ppoll(requests.data(), requests.size(), nullptr, nullptr) < 0) {
      if (errno == EINTR) continue;
      return false;
    }
    const auto readable = [](const pollfd& request) { return (request.revents & POLLIN) != 0; };
    if (std::any_of(requests.begin(), requests.begin() + 2, readable)) return true;
    if (readable(requests[2])) return false;
    // An interface went down: its socket reports that once. Read the report and continue to wait for the interface.
    for (const int socket : sockets_) {
      int error_number = 0;
      socklen_t size = sizeof error_number;
      if (socket >= 0) getsockopt(socket, SOL_SOCKET, SO_ERROR, &error_number, &size);
    }
  }
}

}  // namespace driveline::port
