#include "driveline/port/descriptor_reserve.hpp"

#include <fcntl.h>
#include <sys/socket.h>

#include <cerrno>

namespace driveline::port {
namespace {

rt::FileDescriptor open_spare() noexcept {
  return rt::FileDescriptor{::open("/dev/null", O_RDONLY | O_CLOEXEC)};
}

/// Whether the system call that failed last found no free descriptor.
bool none_left() noexcept {
  return errno == EMFILE || errno == ENFILE;
}

}  // namespace

DescriptorReserve::DescriptorReserve() noexcept : spare_{open_spare()} {}

bool DescriptorReserve::turn_away(int listener, std::string_view farewell) noexcept {
  if (!none_left()) return true;
  if (spare_.valid()) ::close(spare_.release());
  bool possible = true;
  {
    // Linux looks for a free descriptor before it looks for a connection, so there may be none.
    const rt::FileDescriptor client{::accept4(listener, nullptr, nullptr, SOCK_CLOEXEC | SOCK_NONBLOCK)};
    possible = client.valid() || !none_left();
    if (client.valid() && !farewell.empty()) {
      [[maybe_unused]] const auto sent = ::send(client.get(), farewell.data(), farewell.size(), MSG_NOSIGNAL);
    }
  }
  spare_ = open_spare();
  return possible;
}

}  // namespace driveline::port
