#include "driveline/canopen_port/socketcand_port.hpp"

#include <string>

#include "endpoints.hpp"
#include "error_frame.hpp"

namespace driveline::canopen {

using std::chrono::nanoseconds;

tl::expected<std::unique_ptr<SocketcandPort>, CanPortError> SocketcandPort::open(std::string_view address,
                                                                                 std::string_view bus,
                                                                                 const CanPortOptions& options,
                                                                                 rt::Clock& clock) {
  auto descriptor = connect_tcp(address, kPatience);
  if (!descriptor) return tl::unexpected(descriptor.error());
  return on(std::move(*descriptor), address, bus, options, clock);
}

tl::expected<std::unique_ptr<SocketcandPort>, CanPortError> SocketcandPort::on(rt::FileDescriptor descriptor,
                                                                               std::string_view place,
                                                                               std::string_view bus,
                                                                               const CanPortOptions& options,
                                                                               rt::Clock& clock, nanoseconds patience) {
  // Not make_unique: the constructor is private.
  std::unique_ptr<SocketcandPort> port{new SocketcandPort{std::move(descriptor), options, clock}};
  if (auto done = port->expect(Event::kGreeting, "to greet with < hi >", place, patience); !done)
    return tl::unexpected(done.error());
  const std::string open_command = "< open " + std::string(bus) + " >";
  static_cast<void>(port->stream().write(open_command));
  if (auto done = port->expect(Event::kOk, "to answer " + open_command + " with < ok >", place, patience); !done)
    return tl::unexpected(done.error());
  static_cast<void>(port->stream().write("< rawmode >"));
  if (auto done = port->expect(Event::kOk, "to answer < rawmode > with < ok >", place, patience); !done)
    return tl::unexpected(done.error());
  return port;
}

tl::expected<void, CanPortError> SocketcandPort::expect(Event event, std::string_view what, std::string_view place,
                                                        nanoseconds patience) {
  const auto fail = [&](std::string_view reason) {
    return tl::unexpected(CanPortError{CanPortErrorCode::kMachine, "the socketcand server at " + std::string(place) +
                                                                       " was expected " + std::string(what) + ": " +
                                                                       std::string(reason) + "."});
  };
  const nanoseconds deadline = clock().now() + patience;
  while (const auto byte = await_byte(deadline)) {
    const Event got = reader_.take(*byte);
    if (got == event) return {};
    if (got == Event::kFailure) return fail(reader_.reason());
    if (clock().now() >= deadline) break;
  }
  if (stream().ended()) return fail("it has closed the connection");
  return fail(reader_.malformed() > 0 ? "it sends something else" : "no answer");
}

std::optional<Frame> SocketcandPort::take(char byte) noexcept {
  switch (reader_.take(byte)) {
    case Event::kFrame:
      return reader_.frame();
    case Event::kErrorFrame:
      apply_error_frame(counters(), reader_.error_classes(), {});
      return reader_.frame();
    case Event::kFailure:
      ++counters().lost;
      break;
    case Event::kNone:
    case Event::kGreeting:
    case Event::kOk:
      break;
  }
  return std::nullopt;
}

SendStatus SocketcandPort::write_frame(const Frame& frame) noexcept {
  return stream().write(socketcand::command_of(frame).view()) ? SendStatus::kSent : SendStatus::kBusy;
}

}  // namespace driveline::canopen
