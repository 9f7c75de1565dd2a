#pragma once

#include <chrono>
#include <cstdint>
#include <memory>
#include <string>
#include <tl/expected.hpp>
#include <vector>

#include "driveline/port/port.hpp"
#include "driveline/port/port_error.hpp"
#include "driveline/rt/clock.hpp"
#include "driveline/wire/ethernet.hpp"

namespace driveline::port {

/// A port on a network interface of this machine.
class InterfacePort : public Port {
 public:
  /// Hardware address of the interface when it was opened. \rtsafe
  [[nodiscard]] virtual const wire::MacAddress& mac() const noexcept = 0;
  /// Whether the interface still exists, is up and has a carrier. Asks the kernel: not for the cycle. Any thread.
  [[nodiscard]] virtual bool link_up() const noexcept = 0;
  /// How frames pass between this process and the interface, in a few words: "packet socket with a receive ring".
  [[nodiscard]] virtual std::string access_method() const = 0;
};

/// Which kernel interface a network interface is opened with.
enum class PortChoice : std::uint8_t {
  kAuto,  ///< AF_XDP where the driver supports zero copy, else a packet socket
  kRaw,   ///< a packet socket (RawSocketPort)
  kXdp,   ///< AF_XDP (XdpPort), in the fastest mode that the driver supports
};

/// A network interface that is open.
struct OpenInterface {
  std::unique_ptr<InterfacePort> port;
  /// Why a faster mode is not used: one sentence for each mode that was skipped; empty when none was.
  std::vector<std::string> steps_down;
  bool launches = false;  ///< the port holds frames back until their launch time (Port::hold_until())
};

/// Opens `interface` as `choice` says. `may_fall_back`: where AF_XDP is not available at all, PortChoice::kXdp falls
/// back to a packet socket and reports why; else that is an error. `clock` must outlive the port. Needs CAP_NET_RAW,
/// for AF_XDP also CAP_BPF and CAP_NET_ADMIN. Errors: those of RawSocketPort::open() and XdpPort::open().
[[nodiscard]] tl::expected<OpenInterface, PortError> open_interface(const std::string& interface, PortChoice choice,
                                                                    bool may_fall_back, rt::Clock& clock);

/// Opens a packet socket whose frames leave at launch times (RawSocketConfig::launch_times); the caller hands each
/// frame over by `early` before its launch time. `may_fall_back`: where there are no launch times, or `etf` needs
/// frames earlier than that, it opens PortChoice::kRaw and reports why; else that is an error. Errors: also those of
/// find_launch_times().
[[nodiscard]] tl::expected<OpenInterface, PortError> open_launching_interface(const std::string& interface,
                                                                              std::chrono::nanoseconds early,
                                                                              bool may_fall_back, rt::Clock& clock);

}  // namespace driveline::port
