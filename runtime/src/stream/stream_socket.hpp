#pragma once

#include <array>
#include <cstddef>
#include <filesystem>
#include <optional>
#include <span>
#include <vector>

#include "driveline/port/file_descriptor.hpp"
#include "driveline/runtime/error.hpp"
#include "driveline/stream/greeting.hpp"

namespace driveline::runtime {

/// The Unix socket (SOCK_SEQPACKET) at which clients connect. Nothing here waits. The file goes with the object.
class StreamSocket {
 public:
  /// Listens at `path`; a file that a run before has left there is replaced. `everybody`: the file may be opened by any
  /// user, who is looked at when he connects; otherwise by the user of this process. Error (kMachine): it cannot be
  /// had, or another process listens there.
  [[nodiscard]] static Result<StreamSocket> listen(const std::filesystem::path& path, bool everybody);
  ~StreamSocket();
  StreamSocket(StreamSocket&&) noexcept = default;
  StreamSocket& operator=(StreamSocket&&) = delete;

  /// The next client; none: there is none.
  [[nodiscard]] port::FileDescriptor accept() const;

 private:
  StreamSocket(port::FileDescriptor socket, std::filesystem::path path);

  port::FileDescriptor socket_;
  std::filesystem::path path_;
};

/// What has come from a client.
struct StreamMessage {
  bool closed = false;           ///< the connection is gone
  std::vector<std::byte> bytes;  ///< empty: nothing has come
};
/// Takes the next message of a client without waiting.
[[nodiscard]] StreamMessage receive_message(int socket);

/// Sends the answer and the descriptors. False: the client is gone.
[[nodiscard]] bool send_answer(int socket, const stream::Answer& answer, std::span<const int> descriptors);

}  // namespace driveline::runtime
