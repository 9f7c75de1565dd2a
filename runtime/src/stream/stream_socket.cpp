#include "stream/stream_socket.hpp"

#include <fmt/format.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <system_error>
#include <utility>

namespace driveline::runtime {
namespace {

constexpr int kWaitingClients = 8;
/// Longest valid message plus one: a longer one is truncated and then is no Hello.
constexpr std::size_t kLongestMessage = sizeof(stream::Hello) + 1;
constexpr std::size_t kMaxDescriptors = 2;

sockaddr_un address_of(const std::string& path) {
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  std::copy(path.begin(), path.end(), address.sun_path);
  return address;
}

/// The socket functions take a pointer to the generic address type.
const sockaddr* generic(const sockaddr_un& address) noexcept {
  return reinterpret_cast<const sockaddr*>(&address);
}

rt::FileDescriptor make_socket() {
  return rt::FileDescriptor{::socket(AF_UNIX, SOCK_SEQPACKET | SOCK_NONBLOCK | SOCK_CLOEXEC, 0)};
}

/// Whether the file is a socket at which no process listens any more.
bool left_over(const std::string& path, const sockaddr_un& address) {
  struct stat status {};
  if (::lstat(path.c_str(), &status) != 0 || !S_ISSOCK(status.st_mode)) return false;
  const auto probe = make_socket();
  return ::connect(probe.get(), generic(address), sizeof address) != 0 && errno == ECONNREFUSED;
}

}  // namespace

StreamSocket::StreamSocket(rt::FileDescriptor socket, std::filesystem::path path)
    : socket_(std::move(socket)), path_(std::move(path)) {}

StreamSocket::~StreamSocket() {
  if (socket_.valid()) ::unlink(path_.c_str());
}

Result<StreamSocket> StreamSocket::listen(const std::filesystem::path& path, bool everybody) {
  const auto text = path.string();
  const auto refuse = [&](const std::string& reason) {
    return fail(ErrorKind::kMachine, reason, "[stream] socket " + text);
  };
  if (text.size() >= sizeof(sockaddr_un::sun_path)) return refuse("the path of a socket must not exceed 107 bytes");
  const auto address = address_of(text);
  if (left_over(text, address)) ::unlink(text.c_str());
  auto socket = make_socket();
  // Prevent other users from opening the file before its permissions are set.
  const auto mask = ::umask(0177);
  const bool bound = ::bind(socket.get(), generic(address), sizeof address) == 0;
  const int error = errno;
  ::umask(mask);
  if (!bound && error == EADDRINUSE) return refuse("another process listens there, or the file is not a socket");
  if (!bound) return refuse(fmt::format("cannot be made: {}", std::strerror(error)));
  StreamSocket made{std::move(socket), path};
  if (everybody && ::chmod(text.c_str(), 0666) != 0) return refuse(std::strerror(errno));
  if (::listen(made.socket_.get(), kWaitingClients) != 0) return refuse(std::strerror(errno));
  return made;
}

rt::FileDescriptor StreamSocket::accept() {
  rt::FileDescriptor client{::accept4(socket_.get(), nullptr, nullptr, SOCK_NONBLOCK | SOCK_CLOEXEC)};
  // The caller does not poll the socket, so it need not pause.
  if (!client.valid()) static_cast<void>(reserve_.turn_away(socket_.get()));
  return client;
}

StreamMessage receive_message(int socket) {
  StreamMessage message;
  message.bytes.resize(kLongestMessage);
  const auto length = ::recv(socket, message.bytes.data(), message.bytes.size(), MSG_DONTWAIT);
  message.closed = length == 0 || (length < 0 && errno != EAGAIN && errno != EINTR);
  message.bytes.resize(length > 0 ? static_cast<std::size_t>(length) : 0);
  return message;
}

bool send_answer(int socket, const stream::Answer& answer, std::span<const int> descriptors) {
  auto bytes = stream::to_bytes(answer);
  iovec part{bytes.data(), bytes.size()};
  msghdr message{};
  message.msg_iov = &part;
  message.msg_iovlen = 1;
  alignas(cmsghdr) std::array<std::byte, CMSG_SPACE(kMaxDescriptors * sizeof(int))> control{};
  if (!descriptors.empty()) {
    message.msg_control = control.data();
    message.msg_controllen = CMSG_SPACE(descriptors.size_bytes());
    auto* rights = CMSG_FIRSTHDR(&message);
    rights->cmsg_level = SOL_SOCKET;
    rights->cmsg_type = SCM_RIGHTS;
    rights->cmsg_len = CMSG_LEN(descriptors.size_bytes());
    std::memcpy(CMSG_DATA(rights), descriptors.data(), descriptors.size_bytes());
  }
  return ::sendmsg(socket, &message, MSG_NOSIGNAL | MSG_DONTWAIT) == static_cast<ssize_t>(bytes.size());
}

}  // namespace driveline::runtime
