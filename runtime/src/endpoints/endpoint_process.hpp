#pragma once

#include <sys/types.h>

#include <cstdint>
#include <filesystem>
#include <utility>

#include "driveline/port/file_descriptor.hpp"
#include "driveline/runtime/error.hpp"
#include "driveline/slaves/endpoint/endpoint_protocol.hpp"

namespace driveline::runtime {

/// A running `driveline-endpoint`, and the socket to it. It ends with this object.
class EndpointProcess {
 public:
  /// What became of a message.
  enum class Transfer : std::uint8_t { kDone, kNotNow, kEnded };

  /// None.
  EndpointProcess() = default;
  EndpointProcess(EndpointProcess&& other) noexcept
      : socket_(std::move(other.socket_)), child_(std::exchange(other.child_, 0)) {}
  EndpointProcess& operator=(EndpointProcess&& other) noexcept;
  ~EndpointProcess() { end(); }

  /// Starts `program`.
  [[nodiscard]] static Result<EndpointProcess> start(const std::filesystem::path& program);

  /// Without waiting.
  [[nodiscard]] Transfer send(const slaves::EndpointPacket& packet) noexcept;
  /// The same.
  [[nodiscard]] Transfer receive(slaves::EndpointPacket& packet) noexcept;
  /// Closes the socket, which ends the process, and waits for it.
  void end() noexcept;

  /// There is one.
  [[nodiscard]] bool valid() const noexcept { return child_ != 0; }
  /// 0: none.
  [[nodiscard]] pid_t id() const noexcept { return child_; }
  /// To wait for.
  [[nodiscard]] int descriptor() const noexcept { return socket_.get(); }

 private:
  EndpointProcess(port::FileDescriptor socket, pid_t child) : socket_(std::move(socket)), child_(child) {}

  port::FileDescriptor socket_;
  pid_t child_ = 0;
};

}  // namespace driveline::runtime
