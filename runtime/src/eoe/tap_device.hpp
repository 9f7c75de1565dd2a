#pragma once

#include <array>
#include <memory>
#include <optional>
#include <string>

#include "driveline/port/file_descriptor.hpp"
#include "driveline/runtime/eoe/ethernet_switch.hpp"
#include "driveline/runtime/eoe/ip_network.hpp"
#include "driveline/runtime/error.hpp"

namespace driveline::runtime {

/// A TAP interface: the port of the operating system's network stack at the switch.
class TapDevice final : public SwitchedDevice {
 public:
  /// Opens the interface `name`, makes it when there is none, gives it `address` and takes it up. "fd:N" stands for a
  /// TAP whose descriptor was handed over to this process. Errors (kMachine): /dev/net/tun is missing or may not be
  /// opened, CAP_NET_ADMIN is missing for what is still to be done, or the interface is something else.
  [[nodiscard]] static Result<std::unique_ptr<TapDevice>> open(const std::string& name, const IpNetwork& address);

  /// A frame to the network stack; false: it takes none now.
  [[nodiscard]] bool send(std::span<const std::byte> frame) override;
  /// The next frame from the network stack, valid until the next call; nothing: there is none.
  [[nodiscard]] std::optional<std::span<const std::byte>> receive() noexcept;
  /// Readable while receive() has a frame.
  [[nodiscard]] int descriptor() const noexcept { return file_.get(); }
  /// Of the interface.
  [[nodiscard]] const std::string& name() const noexcept { return name_; }

 private:
  TapDevice(port::FileDescriptor file, std::string name) : file_(std::move(file)), name_(std::move(name)) {}
  [[nodiscard]] Result<void> set_up(const IpNetwork& address) const;

  port::FileDescriptor file_;
  std::string name_;
  std::array<std::byte, 2048> buffer_{};
};

}  // namespace driveline::runtime
