#include "driveline/canopen_client/bus_link.hpp"

#include <algorithm>

namespace driveline::canopen {
namespace {

using std::chrono::milliseconds;
using std::chrono::nanoseconds;

constexpr nanoseconds kStopInterval = milliseconds{50};  ///< between two looks at whether to stop
constexpr nanoseconds kRetryInterval = milliseconds{1};  ///< between two tries to send to a full queue

}  // namespace

ClientResult<void> BusLink::send(const Frame& frame, nanoseconds patience) {
  const nanoseconds begin = clock_->now();
  for (;;) {
    switch (port_->send(frame)) {
      case SendStatus::kSent:
        return {};
      case SendStatus::kNotValid:
        return tl::unexpected(ClientError{ClientErrorKind::kNotCarried});
      case SendStatus::kDown:
        return tl::unexpected(ClientError{ClientErrorKind::kDown});
      case SendStatus::kBusy:
        break;
    }
    if (stopped()) return tl::unexpected(ClientError{ClientErrorKind::kStopped});
    if (clock_->now() - begin >= patience) {
      ClientError error{ClientErrorKind::kBusy};
      error.waited = patience;
      return tl::unexpected(error);
    }
    clock_->sleep_until(clock_->now() + kRetryInterval);
  }
}

std::optional<ReceivedFrame> BusLink::receive(nanoseconds deadline) {
  for (;;) {
    if (auto frame = port_->receive()) {
      if (listener_) listener_(*frame);
      return frame;
    }
    const nanoseconds now = clock_->now();
    if (now >= deadline || down() || stopped()) return std::nullopt;
    static_cast<void>(port_->wait_readable(std::min(deadline, now + kStopInterval)));
  }
}

}  // namespace driveline::canopen
