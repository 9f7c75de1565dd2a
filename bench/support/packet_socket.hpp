#pragma once

#include <string>

#include "driveline/port/file_descriptor.hpp"

namespace driveline::bench {

/// A packet socket with the options of port::RawSocketPort, for loops that use it without one.
class PacketSocket {
 public:
  enum class Look { kReturnsAtOnce, kSleeps };
  /// Hears nothing until bind_to(): a receive ring comes in between. `look`: what recv() does while there is no frame;
  /// asleep for 50 ms at most, so that its thread notices its end. Throws std::runtime_error.
  explicit PacketSocket(Look look = Look::kReturnsAtOnce);
  /// EtherCAT frames of this interface. Throws std::runtime_error.
  void bind_to(const std::string& interface) const;
  [[nodiscard]] int get() const noexcept { return socket_.get(); }

 private:
  port::FileDescriptor socket_;
};

}  // namespace driveline::bench
