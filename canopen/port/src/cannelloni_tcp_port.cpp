#include "driveline/canopen_port/cannelloni_tcp_port.hpp"

#include <algorithm>
#include <string>

#include "endpoints.hpp"

namespace driveline::canopen {

using std::chrono::nanoseconds;

tl::expected<std::unique_ptr<CannelloniTcpPort>, CanPortError> CannelloniTcpPort::open(std::string_view address,
                                                                                       const CanPortOptions& options,
                                                                                       rt::Clock& clock) {
  auto descriptor = connect_tcp(address, kPatience);
  if (!descriptor) return tl::unexpected(descriptor.error());
  return on(std::move(*descriptor), address, options, clock);
}

tl::expected<std::unique_ptr<CannelloniTcpPort>, CanPortError> CannelloniTcpPort::on(rt::FileDescriptor descriptor,
                                                                                     std::string_view place,
                                                                                     const CanPortOptions& options,
                                                                                     rt::Clock& clock,
                                                                                     nanoseconds patience) {
  // Not make_unique: the constructor is private.
  std::unique_ptr<CannelloniTcpPort> port{new CannelloniTcpPort{std::move(descriptor), options, clock}};
  if (auto done = port->greet(place, patience); !done) return tl::unexpected(done.error());
  return port;
}

tl::expected<void, CanPortError> CannelloniTcpPort::greet(std::string_view place, nanoseconds patience) {
  static_cast<void>(stream().write(cannelloni::kTcpGreeting));
  const nanoseconds deadline = clock().now() + patience;
  for (const char expected : cannelloni::kTcpGreeting) {
    const auto byte = await_byte(deadline);
    if (byte == expected) continue;
    const std::string_view reason = byte               ? "it sends something else"
                                    : stream().ended() ? "it has closed the connection"
                                                       : "no answer";
    return tl::unexpected(CanPortError{CanPortErrorCode::kMachine,
                                       "the cannelloni peer at " + std::string(place) + " was expected to greet with " +
                                           std::string(cannelloni::kTcpGreeting) + ": " + std::string(reason) + "."});
  }
  return {};
}

std::optional<Frame> CannelloniTcpPort::take(char byte) noexcept {
  using Event = cannelloni::StreamReader::Event;
  switch (reader_.take(static_cast<std::byte>(byte))) {
    case Event::kFrame:
      return reader_.frame();
    case Event::kPassedOver:
      ++malformed_;
      break;
    case Event::kBroken:
      if (!stream().ended()) ++malformed_;
      stream().end();
      break;
    case Event::kMore:
      break;
  }
  return std::nullopt;
}

SendStatus CannelloniTcpPort::write_frame(const Frame& frame) noexcept {
  const auto encoded = cannelloni::stream_frame_of(frame);
  std::array<char, sizeof encoded.bytes> text{};
  std::transform(encoded.bytes.begin(), encoded.bytes.end(), text.begin(),
                 [](std::byte byte) { return static_cast<char>(byte); });
  return stream().write({text.data(), encoded.size}) ? SendStatus::kSent : SendStatus::kBusy;
}

}  // namespace driveline::canopen
