#pragma once

#include <memory>
#include <string_view>
#include <tl/expected.hpp>
#include <utility>

#include "driveline/canopen_port/can_port_error.hpp"
#include "driveline/canopen_port/socketcand_reader.hpp"
#include "driveline/canopen_port/stream_port.hpp"

namespace driveline::canopen {

/// A bus of a server of socketcand (doc/protocol.md of socketcand), in its raw mode. The server sets bit rate and mode
/// of its buses itself; a frame that it refuses counts as lost. Older servers know no remote frames: they refuse them,
/// and do not pass them on.
class SocketcandPort final : public StreamPort {
 public:
  /// Opens `bus` of the server at "HOST:PORT".
  [[nodiscard]] static tl::expected<std::unique_ptr<SocketcandPort>, CanPortError> open(std::string_view address,
                                                                                        std::string_view bus,
                                                                                        const CanPortOptions& options,
                                                                                        rt::Clock& clock);
  /// Opens `bus` of the server at the other end of a descriptor; `place` is for errors.
  [[nodiscard]] static tl::expected<std::unique_ptr<SocketcandPort>, CanPortError> on(
      rt::FileDescriptor descriptor, std::string_view place, std::string_view bus, const CanPortOptions& options,
      rt::Clock& clock, std::chrono::nanoseconds patience = kPatience);

 private:
  using Event = SocketcandReader::Event;

  SocketcandPort(rt::FileDescriptor descriptor, const CanPortOptions& options, rt::Clock& clock) noexcept
      : StreamPort(std::move(descriptor), options, clock) {}
  [[nodiscard]] tl::expected<void, CanPortError> expect(Event event, std::string_view what, std::string_view place,
                                                        std::chrono::nanoseconds patience);

  [[nodiscard]] std::optional<Frame> take(char byte) noexcept override;
  [[nodiscard]] SendStatus write_frame(const Frame& frame) noexcept override;
  [[nodiscard]] std::uint64_t malformed() const noexcept override { return reader_.malformed(); }

  SocketcandReader reader_;
};

}  // namespace driveline::canopen
