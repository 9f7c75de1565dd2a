#pragma once

#include <fcntl.h>
#include <gtest/gtest.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <array>
#include <atomic>
#include <cerrno>
#include <functional>
#include <stdexcept>
#include <string>
#include <string_view>
#include <thread>
#include <utility>
#include <vector>

#include "driveline/canopen_port/can_port.hpp"
#include "driveline/rt/clock.hpp"
#include "driveline/rt/file_descriptor.hpp"

namespace driveline::canopen::port_test {

using namespace std::chrono_literals;

/// Longer than any machine stands still: what a test expects to come is waited for so long.
inline constexpr std::chrono::nanoseconds kLong = 60s;

/// Both ends of a connection in this process.
struct Connection {
  explicit Connection(int type = SOCK_STREAM) {
    std::array<int, 2> ends{};
    if (::socketpair(AF_UNIX, type | SOCK_CLOEXEC, 0, ends.data()) != 0) throw std::runtime_error("socketpair");
    near_end = rt::FileDescriptor{ends[0]};
    far_end = rt::FileDescriptor{ends[1]};
  }
  rt::FileDescriptor near_end;
  rt::FileDescriptor far_end;
};

/// Writes a whole text, whatever the time that takes.
inline void write_all(int descriptor, std::string_view text) {
  while (!text.empty()) {
    ssize_t count = ::send(descriptor, text.data(), text.size(), MSG_NOSIGNAL);
    if (count < 0 && errno == ENOTSOCK) count = ::write(descriptor, text.data(), text.size());
    if (count < 0 && errno == EPIPE) return;  // the other end has closed the connection
    if (count < 0 && errno != EAGAIN && errno != EINTR) throw std::runtime_error("write");
    if (count > 0) text.remove_prefix(static_cast<std::size_t>(count));
    pollfd request{descriptor, POLLOUT, 0};
    if (count < 0) ::poll(&request, 1, 100);
  }
}

/// What can be read now.
inline std::string read_now(int descriptor) {
  std::string text;
  std::array<char, 4096> piece{};
  pollfd request{descriptor, POLLIN, 0};
  while (::poll(&request, 1, 0) > 0) {
    const ssize_t count = ::read(descriptor, piece.data(), piece.size());
    if (count <= 0) break;
    text.append(piece.data(), static_cast<std::size_t>(count));
  }
  return text;
}

/// What comes up to and including `end`; the test fails if that does not come.
inline std::string read_until(int descriptor, std::string_view end) {
  std::string text;
  while (!text.ends_with(end)) {
    pollfd request{descriptor, POLLIN, 0};
    if (::poll(&request, 1, 60'000) != 1) throw std::runtime_error("it has not come");
    text += read_now(descriptor);
  }
  return text;
}

/// The other end of a port while it is opened: a thread that answers each piece of text up to and including `end`.
class Peer {
 public:
  using Answer = std::function<std::string(const std::string&)>;

  Peer(int descriptor, char end, Answer answer)
      : descriptor_(descriptor), end_(end), answer_(std::move(answer)), thread_([this] { run(); }) {}
  Peer(const Peer&) = delete;
  Peer& operator=(const Peer&) = delete;
  ~Peer() { stop(); }

  /// Ends the thread; returns what has come, one piece for each answer.
  std::vector<std::string> stop() {
    stopping_ = true;
    if (thread_.joinable()) thread_.join();
    return pieces_;
  }

 private:
  void run() {
    std::string piece;
    while (!stopping_) {
      pollfd request{descriptor_, POLLIN, 0};
      if (::poll(&request, 1, 2) <= 0) continue;
      char c = 0;
      if (::read(descriptor_, &c, 1) <= 0) return;
      piece += c;
      if (c != end_) continue;
      pieces_.push_back(piece);
      write_all(descriptor_, answer_(piece));
      piece.clear();
    }
  }

  int descriptor_;
  char end_;
  Answer answer_;
  std::vector<std::string> pieces_;
  std::atomic<bool> stopping_{false};
  std::thread thread_;
};

/// Waits for a frame and receives it; the test fails if none comes.
inline Frame receive_one(CanPort& port, rt::Clock& clock) {
  if (!port.wait_readable(clock.now() + kLong)) throw std::runtime_error("no frame has come");
  const auto received = port.receive();
  if (!received) throw std::runtime_error("wait_readable() promised a frame");
  return received->frame;
}

}  // namespace driveline::canopen::port_test
