#pragma once

#include <poll.h>

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "driveline/rt/file_descriptor.hpp"
#include "outcome.hpp"

namespace driveline::endpoint {

/// TCP echo (RFC 862): returns all received data.
class EchoServer {
 public:
  static constexpr std::uint16_t kPort = 7;           ///< port of RFC 862
  static constexpr std::size_t kMaxConnections = 16;  ///< connections at the same time; further ones wait

  /// Listens on all addresses.
  [[nodiscard]] static Outcome<EchoServer> open();

  /// Appends the descriptors to wait for.
  void wait_for(std::vector<pollfd>& descriptors) const;
  /// Handles everything that is possible without waiting.
  void serve();

 private:
  explicit EchoServer(rt::FileDescriptor listener) : listener_(std::move(listener)) {}
  struct Connection {
    rt::FileDescriptor socket;
    std::vector<std::byte> waiting;  ///< received but not yet sent back
  };
  /// Returns false when the connection has ended.
  [[nodiscard]] static bool serve(Connection& connection);

  rt::FileDescriptor listener_;
  std::vector<Connection> connections_;
};

}  // namespace driveline::endpoint
