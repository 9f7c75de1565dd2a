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

/// Request of a client.
struct Wish {
  std::string name = "client";      ///< name of the client, for messages
  std::vector<std::string> axes{};  ///< names in the line description, 1 to kMaxAxes
  bool power = false;               ///< switches the axes on
  bool take_over = false;  ///< takes over axes of other clients, too, which lose them; the axes are halted first
};

/// Details of the connection.
namespace client_detail {

/// A file descriptor that is closed by the destructor.
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

/// Waits up to `timeout` for data on the socket, despite signals. Returns whether there are any.
inline bool wait_for_answer(int socket, std::chrono::milliseconds timeout) {
  using Clock = std::chrono::steady_clock;
  const auto limit = Clock::now() + timeout;
  pollfd ready{socket, POLLIN, 0};
  for (auto left = timeout;; left = std::chrono::ceil<std::chrono::milliseconds>(limit - Clock::now())) {
    const int found = ::poll(&ready, 1, static_cast<int>(std::max(left, std::chrono::milliseconds{0}).count()));
    if (found >= 0 || errno != EINTR) return found == 1;
  }
}

/// The answer of the line with its descriptors.
struct Received {
  Answer answer{};
  std::array<Descriptor, 2> descriptors{};
};

inline std::variant<Received, std::string> receive_answer(int socket, std::chrono::milliseconds timeout) {
  if (!wait_for_answer(socket, timeout)) return std::string{"the line does not answer"};
  std::array<std::byte, sizeof(Answer)> bytes{};
  iovec part{bytes.data(), bytes.size()};
  alignas(cmsghdr) std::array<std::byte, CMSG_SPACE(2 * sizeof(int))> control{};
  msghdr message{};
  message.msg_iov = &part;
  message.msg_iovlen = 1;
  message.msg_control = control.data();
  message.msg_controllen = control.size();
  auto length = ::recvmsg(socket, &message, MSG_CMSG_CLOEXEC);
  // A line that has disconnected may have sent the reason before: that message follows the error.
  if (length < 0 && errno == ECONNRESET) length = ::recvmsg(socket, &message, MSG_CMSG_CLOEXEC);
  if (length < 0) return system_text("the line does not answer");
  if (length == 0) return std::string{"the line has closed the connection"};
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
  if (!answer) return std::string{"the other end is not a line, or a line of another version"};
  received.answer = *answer;
  if (answer->accepted == 0) return std::string{answer->refusal.text()};
  if (answer->version != kVersion) {
    return "the line uses version " + std::to_string(answer->version) + " of the stream, this client " +
           std::to_string(kVersion);
  }
  return received;
}

}  // namespace client_detail

/// A program that streams setpoints to axes of a running line. Only connect() waits for the line; send() and status()
/// neither allocate nor make a system call, so a real-time thread may call them. Belongs to one thread.
///
///     auto connected = stream::Client::connect("/run/cell/stream.sock", {.name = "sine", .axes = {"x", "y"}});
///     if (const auto* refusal = std::get_if<std::string>(&connected)) die(*refusal);
///     auto& client = std::get<stream::Client>(connected);
class Client {
 public:
  /// Requests axes from a line. Returns a sentence if the line refuses, or does not answer each of the two messages
  /// within `timeout`.
  [[nodiscard]] static std::variant<Client, std::string> connect(
      const std::string& socket_path, const Wish& wish, std::chrono::milliseconds timeout = std::chrono::seconds{2}) {
    using client_detail::system_text;
    if (wish.axes.empty() || wish.axes.size() > kMaxAxes) {
      return "a client has 1 to " + std::to_string(kMaxAxes) + " axes, not " + std::to_string(wish.axes.size());
    }
    sockaddr_un address{};
    address.sun_family = AF_UNIX;
    if (socket_path.size() >= sizeof address.sun_path)
      return socket_path + ": the path of a socket must not exceed 107 bytes";
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
    // If the line has already refused, its answer contains the reason.
    static_cast<void>(::send(socket.get(), bytes.data(), bytes.size(), MSG_NOSIGNAL));
    auto received = client_detail::receive_answer(socket.get(), timeout);
    if (auto* refusal = std::get_if<std::string>(&received)) return std::move(*refusal);
    return open(std::move(socket), *std::get_if<client_detail::Received>(&received), hello.axis_count, timeout);
  }

  /// Returns the answer of the line: period, keep-alive time, bounds of the axes.
  [[nodiscard]] const Answer& line() const noexcept { return answer_; }
  /// Returns the number of axes, as requested.
  [[nodiscard]] std::size_t axis_count() const noexcept { return axis_count_; }

  /// Sends the targets of the axes at `time`, on a time axis of the client. Times must increase from setpoint to
  /// setpoint.
  /// @return false: there is no room, because the line has not taken the preceding setpoints yet. \rtsafe
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
  /// Reports that this client is alive, for times without setpoints. \rtsafe
  bool heartbeat() noexcept { return say(RecordKind::kHeartbeat); }
  /// Makes axes follow again that do not follow, because another motion has taken them or they were not enabled. An
  /// axis that another client has taken over follows as soon as it has no owner. \rtsafe
  bool follow() noexcept { return say(RecordKind::kFollow); }
  /// Brings the axes to rest; they are free when status() shows kOver. \rtsafe
  bool end() noexcept { return say(RecordKind::kEnd); }

  /// Returns the newest status; none: the first one has not arrived yet. \rtsafe
  [[nodiscard]] std::optional<StatusRecord> status() const noexcept {
    StatusRecord record;
    if (!broadcast_.latest(record)) return std::nullopt;
    return record;
  }
  /// Waits for the next status by polling, until `deadline`. For programs that calculate one setpoint per cycle: the
  /// record contains the number of the cycle.
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

  /// Whether the line is still connected. Makes a system call.
  [[nodiscard]] bool connected() const noexcept {
    pollfd look{socket_.get(), 0, 0};
    return ::poll(&look, 1, 0) == 0;
  }

 private:
  static std::variant<Client, std::string> open(client_detail::Descriptor socket, client_detail::Received& received,
                                                std::size_t axis_count, std::chrono::milliseconds timeout) {
    auto ring = rt::SharedMapping::open(received.descriptors[0].get(), setpoint_ring(), rt::SharedSealing::kSizeOnly);
    if (const auto* wrong = std::get_if<rt::SharedRegionError>(&ring)) return describe(*wrong);
    auto broadcast = rt::SharedMapping::open(received.descriptors[1].get(), status_broadcast());
    if (const auto* wrong = std::get_if<rt::SharedRegionError>(&broadcast)) return describe(*wrong);
    const auto mapped = to_bytes(Mapped{});
    static_cast<void>(::send(socket.get(), mapped.data(), mapped.size(), MSG_NOSIGNAL));
    auto begun = client_detail::receive_answer(socket.get(), timeout);
    if (auto* refusal = std::get_if<std::string>(&begun)) return std::move(*refusal);
    try {
      return Client{std::move(socket), received.answer, axis_count, std::move(*std::get_if<rt::SharedMapping>(&ring)),
                    std::move(*std::get_if<rt::SharedMapping>(&broadcast))};
    } catch (const std::invalid_argument& wrong) {  // ring and broadcast check the layout once more
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
