#pragma once

#include <string>

#include "driveline/rt/file_descriptor.hpp"

namespace driveline::bench {

/// A packet socket with the options of port::RawSocketPort, for loops without a port.
class PacketSocket {
 public:
  enum class Look { kReturnsAtOnce, kSleeps };
  /// Receives nothing until bind_to(), so that a receive ring can be installed in between. `look`: what recv() does
  /// without a frame; kSleeps returns after 50 ms at most, so that its thread notices a stop request. Throws
  /// std::runtime_error.
  explicit PacketSocket(Look look = Look::kReturnsAtOnce);
  /// Receives the EtherCAT frames of this interface. Throws std::runtime_error.
  void bind_to(const std::string& interface) const;
  [[nodiscard]] int get() const noexcept { return socket_.get(); }

 private:
  rt::FileDescriptor socket_;
};

}  // namespace driveline::bench
