#pragma once

#include <memory>
#include <string_view>
#include <tl/expected.hpp>
#include <utility>

#include "driveline/canopen_port/can_port_error.hpp"
#include "driveline/canopen_port/stream_port.hpp"
#include "driveline/canopen_wire/cannelloni_tcp.hpp"

namespace driveline::canopen {

/// A tunnel of cannelloni over TCP (doc/tcp_protocol.md of cannelloni, version 1). The stream has no delimiter: a
/// length that no frame has ends the connection. Nothing is known of the bus at its far end.
class CannelloniTcpPort final : public StreamPort {
 public:
  /// Connects to "HOST:PORT".
  [[nodiscard]] static tl::expected<std::unique_ptr<CannelloniTcpPort>, CanPortError> open(
      std::string_view address, const CanPortOptions& options, rt::Clock& clock);
  /// Greets the other end of a descriptor and waits for its greeting; `place` is for errors.
  [[nodiscard]] static tl::expected<std::unique_ptr<CannelloniTcpPort>, CanPortError> on(
      rt::FileDescriptor descriptor, std::string_view place, const CanPortOptions& options, rt::Clock& clock,
      std::chrono::nanoseconds patience = kPatience);

 private:
  CannelloniTcpPort(rt::FileDescriptor descriptor, const CanPortOptions& options, rt::Clock& clock) noexcept
      : StreamPort(std::move(descriptor), options, clock) {}
  [[nodiscard]] tl::expected<void, CanPortError> greet(std::string_view place, std::chrono::nanoseconds patience);

  [[nodiscard]] std::optional<Frame> take(char byte) noexcept override;
  [[nodiscard]] SendStatus write_frame(const Frame& frame) noexcept override;
  [[nodiscard]] std::uint64_t malformed() const noexcept override { return malformed_; }

  cannelloni::StreamReader reader_;
  std::uint64_t malformed_ = 0;
};

}  // namespace driveline::canopen
