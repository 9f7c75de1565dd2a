#pragma once

#include <chrono>
#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "driveline/rt/file_descriptor.hpp"

namespace driveline::port {

using Bytes = std::vector<std::byte>;

/// Moves the calling thread into a private network namespace, once per process, so that tests can create and remove
/// interfaces without touching those of the machine. Works for root, and for other users if the kernel allows user
/// namespaces. Returns why it failed, or an empty string.
const std::string& enter_private_network();

/// Drops all capabilities of the calling thread. Other threads keep theirs.
void drop_capabilities();

/// Reduces the capabilities of the calling thread to CAP_NET_RAW, similar to the unit of the packages.
void keep_only_net_raw();

/// Runs a shell command without output; returns whether it succeeded.
bool run_quietly(const std::string& command);

/// A network interface whose cable ends in this program: take() returns the frames that the kernel transmits on it,
/// inject() lets the kernel receive a frame. The destructor deletes the interface.
class TapInterface {
 public:
  /// @param ethernet false for a TUN interface, which carries IP packets without Ethernet headers
  explicit TapInterface(const std::string& name, bool ethernet = true);

  /// Why the interface could not be created; empty: it was created.
  [[nodiscard]] const std::string& error() const { return error_; }

  void set_up(bool up);
  void set_carrier(bool carrier);
  void set_mtu(int mtu);
  void set_mac(std::span<const std::byte, 6> mac);

  /// The next transmitted EtherCAT frame; nothing: there was none within `patience`. Skips traffic of the kernel itself
  /// (IPv6 neighbour discovery and the like).
  [[nodiscard]] std::optional<Bytes> take(std::chrono::milliseconds patience = std::chrono::seconds{5});

  /// Lets the interface receive a frame; returns whether the kernel accepted it.
  bool inject(const Bytes& frame);

  /// Deletes the interface.
  void remove() { device_ = rt::FileDescriptor{}; }

 private:
  template <typename Change>
  void configure(unsigned long request, Change change);

  std::string name_;
  std::string error_;
  rt::FileDescriptor device_;
};

}  // namespace driveline::port
