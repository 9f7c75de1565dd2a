#pragma once

#include <chrono>
#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "driveline/port/file_descriptor.hpp"

namespace driveline::port {

using Bytes = std::vector<std::byte>;

/// Moves the calling thread into a network namespace of its own, once per process, so that tests make and break
/// interfaces without touching the machine's. Works as root, and without where the kernel allows user namespaces.
/// Returns why it does not work, or an empty string.
const std::string& enter_private_network();

/// Lets the calling thread run without any capability. Other threads keep theirs.
void drop_capabilities();

/// Lets the calling thread keep CAP_NET_RAW alone, as the unit of the packages nearly does.
void keep_only_net_raw();

/// Runs a shell command quietly; whether it succeeded.
bool run_quietly(const std::string& command);

/// A network interface whose cable ends in this program: what the kernel transmits on it, take() returns; what
/// inject() gets, the kernel receives. Deleted with the object.
class TapInterface {
 public:
  /// @param ethernet false for a TUN interface, which carries IP packets without Ethernet headers
  explicit TapInterface(const std::string& name, bool ethernet = true);

  /// Why it could not be created; empty if it was.
  [[nodiscard]] const std::string& error() const { return error_; }

  void set_up(bool up);
  void set_carrier(bool carrier);
  void set_mtu(int mtu);
  void set_mac(std::span<const std::byte, 6> mac);

  /// The next EtherCAT frame that was transmitted; nothing if there is none within `patience`. The kernel's own
  /// traffic (IPv6 neighbour discovery and such) is skipped.
  [[nodiscard]] std::optional<Bytes> take(std::chrono::milliseconds patience = std::chrono::seconds{5});

  /// Lets the interface receive a frame; whether the kernel took it.
  bool inject(const Bytes& frame);

  /// Deletes the interface.
  void remove() { device_ = FileDescriptor{}; }

 private:
  template <typename Change>
  void configure(unsigned long request, Change change);

  std::string name_;
  std::string error_;
  FileDescriptor device_;
};

}  // namespace driveline::port
