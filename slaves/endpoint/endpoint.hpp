#pragma once

#include <array>
#include <chrono>
#include <cstddef>
#include <optional>
#include <string_view>

#include "cockpit.hpp"
#include "driveline/rt/file_descriptor.hpp"
#include "driveline/slaves/endpoint/endpoint_protocol.hpp"
#include "echo_server.hpp"
#include "outcome.hpp"
#include "virtual_wire.hpp"
#include "web_server.hpp"

namespace driveline::endpoint {

/// The IP stack of a device: transfers frames between the socket to the device's simulation and the kernel's stack in a
/// separate network namespace, and runs the servers there.
class Endpoint {
 public:
  /// Takes ownership of `socket`, an end of a SOCK_SEQPACKET pair.
  explicit Endpoint(int socket) : socket_(socket) {}
  Endpoint(const Endpoint&) = delete;  // the web server refers to the state of this object
  Endpoint& operator=(const Endpoint&) = delete;

  /// Runs until the other end of the socket is closed. The error, also sent to the other end, states why it cannot run.
  [[nodiscard]] Outcome<void> run();

 private:
  [[nodiscard]] Outcome<void> set_up();
  [[nodiscard]] Outcome<void> pump();
  /// Returns false when the other end is closed.
  [[nodiscard]] bool take_messages();
  void take(const slaves::EndpointPacket& packet);
  void forward_frames();
  void tell(slaves::EndpointMessage message, std::string_view text = {});

  rt::FileDescriptor socket_;
  CockpitState state_;
  std::optional<VirtualWire> wire_;
  std::optional<EchoServer> echo_;
  std::optional<WebServer> web_;
  slaves::EndpointPacket packet_;
  std::array<std::byte, wire::kMaxEoeFrame> frame_{};
  std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
};

}  // namespace driveline::endpoint
