#pragma once

#include <fcntl.h>
#include <poll.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <optional>
#include <span>
#include <stdexcept>
#include <string>
#include <system_error>
#include <utility>
#include <variant>
#include <vector>

#include "driveline/rt/shared_broadcast.hpp"
#include "driveline/rt/shared_mapping.hpp"
#include "driveline/rt/shared_region_error.hpp"
#include "driveline/rt/shared_ring.hpp"
#include "driveline/stream/greeting.hpp"
#include "driveline/stream/records.hpp"

namespace driveline::stream {

/// What a client wants.
struct Wish {
  std::string name = "client";      ///< of itself, for people
  std::vector<std::string> axes{};  ///< by their names in the line description, 1 to kMaxAxes
  bool power = false;               ///< the axes are to be switched on
  bool take_over = false;           ///< also axes that somebody else commands, who loses them; they are halted first
};

/// Details of the connection.
namespace client_detail {

/// A descriptor that is closed in the end.
class Descriptor {
 public:
  Descriptor() = default;
  explicit Descriptor(int number) noexcept : number_{number} {}
  ~Descriptor() {
    if (number_ >= 0) ::close(number_);
  }
  Descriptor(Descriptor&& other) noexcept : number_{std::exchange(other.number_, -1)} {}
  Descriptor& operator=(Descriptor&& other) noexcept {
    std::swap(number_, other.number_);
    return *this;
  }
  [[nodiscard]] int get() const noexcept { return number_; }
  [[nodiscard]] bool valid() const noexcept { return number_ >= 0; }

 private:
  int number_ = -1;
};

inline std::string system_text(const std::string& what) {
  return what + ": " + std::generic_category().message(errno);
}

/// Whether something has come within `patience`, signals or not.
inline bool wait_for_answer(int socket, std::chrono::milliseconds patience) {
  using Clock = std::chrono::steady_clock;
  const auto limit = Clock::now() + patience;
  pollfd ready{socket, POLLIN, 0};
  for (auto left = patience;; left = std::chrono::ceil<std::chrono::milliseconds>(limit - Clock::now())) {
    const int found = ::poll(&ready, 1, static_cast<int>(std::max(left, std::chrono::milliseconds{0}).count()));
    if (found >= 0 || errno != EINTR) return found == 1;
  }
}

/// The answer and its descriptors; a sentence when there is none.
struct Received {
  Answer answer{};
  std::array<Descriptor, 2> descriptors{};
};

inline std::variant<Received, std::string> receive_answer(int socket, std::chrono::milliseconds patience) {
  if (!wait_for_answer(socket, patience)) return std::string{"the line does not answer"};
  std::array<std::byte, sizeof(Answer)> bytes{};
  iovec part{bytes.data(), bytes.size()};
  alignas(cmsghdr) std::array<std::byte, CMSG_SPACE(2 * sizeof(int))> control{};
  msghdr message{};
  message.msg_iov = &part;
  message.msg_iovlen = 1;
  message.msg_control = control.data();
  message.msg_controllen = control.size();
  auto length = ::recvmsg(socket, &message, MSG_CMSG_CLOEXEC);
  // A line that has hung up may have said before why: that comes behind the error.
  if (length < 0 && errno == ECONNRESET) length = ::recvmsg(socket, &message, MSG_CMSG_CLOEXEC);
  if (length < 0) return system_text("the line does not answer");
  if (length == 0) return std::string{"the line has hung up"};
  Received received;
  for (const cmsghdr* part_of = CMSG_FIRSTHDR(&message); part_of != nullptr;
       part_of = CMSG_NXTHDR(&message, const_cast<cmsghdr*>(part_of))) {
    if (part_of->cmsg_level != SOL_SOCKET || part_of->cmsg_type != SCM_RIGHTS) continue;
    const auto count = std::min<std::size_t>((part_of->cmsg_len - CMSG_LEN(0)) / sizeof(int), 2);
    for (std::size_t i = 0; i < count; ++i) {
      int number = -1;
      std::memcpy(&number, CMSG_DATA(part_of) + i * sizeof(int), sizeof number);
      received.descriptors[i] = Descriptor{number};
    }
  }
  const auto answer = from_bytes<Answer>(std::span<const std::byte>(bytes).first(static_cast<std::size_t>(length)));
  if (!answer) return std::string{"what listens there is no line, or one of another version"};
  received.answer = *answer;
  if (answer->accepted == 0) return std::string{answer->refusal.text()};
  if (answer->version != kVersion) {
    return "the line speaks version " + std::to_string(answer->version) + " of the stream, this client " +
           std::to_string(kVersion);
  }
  return received;
}

}  // namespace client_detail

/// A program that streams setpoints into axes of a running line. Nothing here waits for the line but connect(); send()
/// and status() neither allocate nor make a system call, so they may be called in a real-time thread. Belongs to one
/// thread.
///
///     auto connected = stream::Client::connect("/run/cell/stream.sock", {.name = "sine", .axes = {"x", "y"}});
///     if (const auto* refusal = std::get_if<std::string>(&connected)) die(*refusal);
///     auto& client = std::get<stream::Client>(connected);
class Client {
 public:
  /// Asks a line for axes. A sentence when it refuses, or does not answer within `patience`.
  [[nodiscard]] static std::variant<Client, std::string> connect(
      const std::string& socket_path, const Wish& wish, std::chrono::milliseconds patience = std::chrono::seconds{2}) {
    using client_detail::system_text;
    if (wish.axes.empty() || wish.axes.size() > kMaxAxes) {
      return "a client has 1 to " + std::to_string(kMaxAxes) + " axes, not " + std::to_string(wish.axes.size());
    }
    sockaddr_un address{};
    address.sun_family = AF_UNIX;
    if (socket_path.size() >= sizeof address.sun_path)
      return socket_path + ": the path of a socket has 107 bytes at most";
    std::copy(socket_path.begin(), socket_path.end(), address.sun_path);
    client_detail::Descriptor socket{::socket(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC, 0)};
    if (!socket.valid()) return system_text("no socket");
    int connected = 0;
    do {
      connected = ::connect(socket.get(), reinterpret_cast<const sockaddr*>(&address), sizeof address);
    } while (connected != 0 && errno == EINTR);
    if (connected != 0) return system_text(socket_path);
    Hello hello;
    hello.axis_count = static_cast<std::uint32_t>(wish.axes.size());
    hello.power = wish.power ? 1 : 0;
    hello.take_over = wish.take_over ? 1 : 0;
    hello.name.set(wish.name);
    for (std::size_t i = 0; i < wish.axes.size(); ++i) hello.axes[i].set(wish.axes[i]);
    const auto bytes = to_bytes(hello);
    // A line that does not listen any more has said why.
    static_cast<void>(::send(socket.get(), bytes.data(), bytes.size(), MSG_NOSIGNAL));
    auto received = client_detail::receive_answer(socket.get(), patience);
    if (auto* refusal = std::get_if<std::string>(&received)) return std::move(*refusal);
    return open(std::move(socket), *std::get_if<client_detail::Received>(&received), hello.axis_count);
  }

  /// What the line has said: period, keep-alive time, bounds of the axes.
  [[nodiscard]] const Answer& line() const noexcept { return answer_; }
  /// Axes, as asked for.
  [[nodiscard]] std::size_t axis_count() const noexcept { return axis_count_; }

  /// Where the axes shall be at `time` on a time axis of the client's own. Times rise from setpoint to setpoint.
  /// @return false: the line has not taken the setpoints before, there is no room for this one. \rtsafe
  bool send(std::chrono::nanoseconds time, std::span<const AxisTarget> targets) noexcept {
    SetpointRecord record;
    record.kind = RecordKind::kSetpoint;
    record.number = number_ + 1;
    record.time_ns = time.count();
    record.axis_count = static_cast<std::uint32_t>(targets.size());
    std::copy_n(targets.begin(), std::min(targets.size(), kMaxAxes), record.targets.begin());
    const bool sent = ring_.try_push(record);
    number_ += sent ? 1 : 0;
    return sent;
  }
  /// Says that this client is alive, for a time without setpoints. \rtsafe
  bool heartbeat() noexcept { return say(RecordKind::kHeartbeat); }
  /// Axes that do not follow are to do so again: another motion had taken them, or they were not enabled. One that
  /// somebody else has taken over follows when nobody commands it any more. \rtsafe
  bool follow() noexcept { return say(RecordKind::kFollow); }
  /// The axes are to come to rest; they are free when status() says kOver. \rtsafe
  bool end() noexcept { return say(RecordKind::kEnd); }

  /// The newest status; none: the first has not come yet. \rtsafe
  [[nodiscard]] std::optional<StatusRecord> status() const noexcept {
    StatusRecord record;
    if (!broadcast_.latest(record)) return std::nullopt;
    return record;
  }
  /// Waits for the next status by looking again and again, until `deadline` is over. For programs that calculate a
  /// setpoint per cycle: the record tells which cycle this is.
  [[nodiscard]] std::optional<StatusRecord> next_status(std::chrono::steady_clock::time_point deadline) noexcept {
    do {
      if (auto record = status(); record && record->cycle != last_cycle_) {
        last_cycle_ = record->cycle;
        return record;
      }
      static_cast<void>(::poll(nullptr, 0, 0));
    } while (std::chrono::steady_clock::now() < deadline);
    return std::nullopt;
  }

  /// The line is still there. Makes a system call.
  [[nodiscard]] bool connected() const noexcept {
    pollfd look{socket_.get(), 0, 0};
    return ::poll(&look, 1, 0) == 0;
  }

 private:
  static std::variant<Client, std::string> open(client_detail::Descriptor socket, client_detail::Received& received,
                                                std::size_t axis_count) {
    auto ring = rt::SharedMapping::open(received.descriptors[0].get(), setpoint_ring());
    if (const auto* wrong = std::get_if<rt::SharedRegionError>(&ring)) return describe(*wrong);
    auto broadcast = rt::SharedMapping::open(received.descriptors[1].get(), status_broadcast());
    if (const auto* wrong = std::get_if<rt::SharedRegionError>(&broadcast)) return describe(*wrong);
    try {
      return Client{std::move(socket), received.answer, axis_count, std::move(*std::get_if<rt::SharedMapping>(&ring)),
                    std::move(*std::get_if<rt::SharedMapping>(&broadcast))};
    } catch (const std::invalid_argument& wrong) {  // ring and broadcast look at the form once more
      return std::string{wrong.what()};
    }
  }

  Client(client_detail::Descriptor socket, const Answer& answer, std::size_t axis_count, rt::SharedMapping ring,
         rt::SharedMapping broadcast)
      : socket_{std::move(socket)},
        answer_{answer},
        axis_count_{axis_count},
        ring_memory_{std::move(ring)},
        broadcast_memory_{std::move(broadcast)},
        ring_{ring_memory_},
        broadcast_{broadcast_memory_} {}

  bool say(RecordKind kind) noexcept {
    SetpointRecord record;
    record.kind = kind;
    return ring_.try_push(record);
  }

  client_detail::Descriptor socket_;
  Answer answer_;
  std::size_t axis_count_;
  rt::SharedMapping ring_memory_;
  rt::SharedMapping broadcast_memory_;
  rt::SharedRingWriter<SetpointRecord> ring_;
  rt::SharedBroadcastReader<StatusRecord> broadcast_;
  std::uint64_t number_ = 0;
  std::int64_t last_cycle_ = -1;
};

}  // namespace driveline::stream
