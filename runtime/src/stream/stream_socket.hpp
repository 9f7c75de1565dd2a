#pragma once

#include <array>
#include <cstddef>
#include <filesystem>
#include <optional>
#include <span>
#include <vector>

#include "driveline/port/descriptor_reserve.hpp"
#include "driveline/rt/file_descriptor.hpp"
#include "driveline/runtime/error.hpp"
#include "driveline/stream/greeting.hpp"

namespace driveline::runtime {

/// Unix socket (SOCK_SEQPACKET) to which clients connect. Never waits. The file is removed with the object.
class StreamSocket {
 public:
  /// Listens at `path`; replaces a file that an earlier run has left there. `everybody`: any user may open the file,
  /// and is checked when connecting; otherwise only the user of this process may. Error (kMachine): the path is not
  /// available, or another process listens there.
  [[nodiscard]] static Result<StreamSocket> listen(const std::filesystem::path& path, bool everybody);
  ~StreamSocket();
  StreamSocket(StreamSocket&&) noexcept = default;
  StreamSocket& operator=(StreamSocket&&) = delete;

  /// Accepts the next client; invalid: there is none. A client for which no file descriptor is left is disconnected.
  [[nodiscard]] rt::FileDescriptor accept();

 private:
  StreamSocket(rt::FileDescriptor socket, std::filesystem::path path);

  rt::FileDescriptor socket_;
  port::DescriptorReserve reserve_;
  std::filesystem::path path_;
};

/// Data received from a client.
struct StreamMessage {
  bool closed = false;           ///< the connection is closed
  std::vector<std::byte> bytes;  ///< empty: nothing was received
};
/// Receives the next message of a client without waiting.
[[nodiscard]] StreamMessage receive_message(int socket);

/// Sends the answer and the descriptors. False: the client has disconnected.
[[nodiscard]] bool send_answer(int socket, const stream::Answer& answer, std::span<const int> descriptors);

}  // namespace driveline::runtime
