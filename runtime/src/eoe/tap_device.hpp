#pragma once

#include <array>
#include <memory>
#include <optional>
#include <string>

#include "driveline/rt/file_descriptor.hpp"
#include "driveline/runtime/eoe/ethernet_switch.hpp"
#include "driveline/runtime/eoe/ip_network.hpp"
#include "driveline/runtime/error.hpp"

namespace driveline::runtime {

/// A TAP interface: connects the network stack of the operating system to the switch.
class TapDevice final : public SwitchedDevice {
 public:
  /// Opens the interface `name`, creates it if there is none, sets `address` and brings it up. "fd:N" stands for a TAP
  /// whose open descriptor was passed to this process. Errors (kMachine): /dev/net/tun is missing or cannot be opened,
  /// CAP_NET_ADMIN is missing for a remaining step, or the interface is no TAP.
  [[nodiscard]] static Result<std::unique_ptr<TapDevice>> open(const std::string& name, const IpNetwork& address);

  /// Sends a frame to the network stack; false: it accepts none now.
  [[nodiscard]] bool send(std::span<const std::byte> frame) override;
  /// Returns the next frame from the network stack, valid until the next call; none: there is no frame.
  [[nodiscard]] std::optional<std::span<const std::byte>> receive() noexcept;
  /// Readable while receive() has a frame.
  [[nodiscard]] int descriptor() const noexcept { return file_.get(); }
  /// Returns the name of the interface.
  [[nodiscard]] const std::string& name() const noexcept { return name_; }

 private:
  TapDevice(rt::FileDescriptor file, std::string name) : file_(std::move(file)), name_(std::move(name)) {}
  [[nodiscard]] Result<void> set_up(const IpNetwork& address) const;

  rt::FileDescriptor file_;
  std::string name_;
  std::array<std::byte, 2048> buffer_{};
};

}  // namespace driveline::runtime
