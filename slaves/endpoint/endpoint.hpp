#pragma once

#include <array>
#include <chrono>
#include <cstddef>
#include <optional>
#include <string_view>

#include "cockpit.hpp"
#include "driveline/port/file_descriptor.hpp"
#include "driveline/slaves/endpoint/endpoint_protocol.hpp"
#include "echo_server.hpp"
#include "outcome.hpp"
#include "virtual_wire.hpp"
#include "web_server.hpp"

namespace driveline::endpoint {

/// The IP stack of one device: frames between the socket to its simulation and the kernel's stack in a namespace of its
/// own, and what listens there.
class Endpoint {
 public:
  /// Takes over `socket`, the end of a SOCK_SEQPACKET pair.
  explicit Endpoint(int socket) : socket_(socket) {}
  Endpoint(const Endpoint&) = delete;  // the web server refers to the state in here
  Endpoint& operator=(const Endpoint&) = delete;

  /// Runs until the other end of the socket is closed. Error: why it cannot run, told to the other end, too.
  [[nodiscard]] Outcome<void> run();

 private:
  [[nodiscard]] Outcome<void> set_up();
  [[nodiscard]] Outcome<void> pump();
  /// False: the other end is closed.
  [[nodiscard]] bool take_messages();
  void take(const slaves::EndpointPacket& packet);
  void forward_frames();
  void tell(slaves::EndpointMessage message, std::string_view text = {});

  port::FileDescriptor socket_;
  CockpitState state_;
  std::optional<VirtualWire> wire_;
  std::optional<EchoServer> echo_;
  std::optional<WebServer> web_;
  slaves::EndpointPacket packet_;
  std::array<std::byte, wire::kMaxEoeFrame> frame_{};
  std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
};

}  // namespace driveline::endpoint
