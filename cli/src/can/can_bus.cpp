#include "can/can_bus.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <fstream>

#include "console.hpp"
#include "driveline/rt/stop_signals.hpp"
#include "driveline/runtime/can_line/simulated_can_port.hpp"

namespace driveline::cli {
namespace {

constexpr std::array<std::string_view, 4> kProtocols = {"slcan:", "socketcan:", "socketcand:", "cannelloni:"};
constexpr std::string_view kPcapng = ".pcapng";
constexpr int kCanHardware = 280;                            ///< ARPHRD_CAN (linux/if_arp.h)
constexpr auto kLeaveTime = std::chrono::milliseconds{100};  ///< for frames on their way to the bus
/// Drives have booted by then; a drive that has not is searched like any other.
constexpr auto kBootUpTime = std::chrono::seconds{30};

bool is_kernel_can_interface(std::string_view interface) {
  if (interface.empty() || interface.find('/') != std::string_view::npos) return false;
  std::ifstream file(fmt::format("/sys/class/net/{}/type", interface));
  int type = 0;
  return file >> type && type == kCanHardware;
}

/// Name of the bus in a log: that of the interface, where the text has one.
std::string log_name(const std::string& interface) {
  if (interface.starts_with("socketcan:")) return interface.substr(std::string_view("socketcan:").size());
  if (interface.find(':') == std::string::npos) return interface;
  const auto slash = interface.find('/');
  return interface.starts_with("socketcand:") && slash != std::string::npos ? interface.substr(slash + 1) : "can0";
}

/// What the description says of the bus; nothing without one.
Outcome<std::optional<runtime::CanLineConfig>> read_description_of_bus(const CanBusOptions& options) {
  if (options.config.empty()) return std::optional<runtime::CanLineConfig>();
  auto config = runtime::load_can_line_config(options.config);
  if (!config) return tl::unexpected(config.error());
  return std::optional(std::move(*config));
}

Outcome<std::unique_ptr<canopen::CanPort>> open_port(const CanBusOptions& options,
                                                     const std::optional<runtime::CanLineConfig>& config,
                                                     const canopen::CanPortOptions& settings, rt::Clock& clock) {
  if (options.interface.empty()) return runtime::open_simulated_can_port(*config, settings, clock);
  auto port = canopen::open_can_port(options.interface, settings, clock);
  if (port) return std::move(*port);
  const bool wrong = port.error().code == canopen::CanPortErrorCode::kUsage;
  return tl::unexpected(Failure(wrong ? 2 : 1, fmt::format("--iface {}: {}", options.interface, port.error().message)));
}

/// The format of a capture is told by the name of its file.
Outcome<void> check_capture_names(const CanBusOptions& options) {
  if (options.log.ends_with(kPcapng)) {
    return misused(fmt::format("--log {}: a file whose name ends in .pcapng is written by --pcap", options.log));
  }
  if (!options.pcap.empty() && !options.pcap.ends_with(kPcapng)) {
    return misused(fmt::format("--pcap {}: a name that ends in .pcapng is expected", options.pcap));
  }
  return {};
}

}  // namespace

bool names_can_interface(std::string_view interface) {
  const bool protocol = std::any_of(kProtocols.begin(), kProtocols.end(),
                                    [&](std::string_view prefix) { return interface.starts_with(prefix); });
  return protocol || is_kernel_can_interface(interface);
}

bool selects_can(const std::string& config, const std::string& interface) {
  if (!interface.empty()) return names_can_interface(interface);
  return !config.empty() && runtime::describes_can_line(config);
}

Outcome<void> CanBus::Parts::capture(const std::string& file, const std::string& interface) {
  if (file.empty()) return {};
  canopen::CanCaptureConfig config;
  config.file = file;
  config.interface_name = interface;
  auto opened = canopen::CanCapture::open(outermost(), *clock, config);
  if (!opened) return failed(opened.error().message);
  captures.push_back(std::move(*opened));
  return {};
}

CanBus::CanBus(Parts parts) : parts_(std::move(parts)), link_(parts_.outermost(), *parts_.clock) {
  link_.set_listener([this](const canopen::ReceivedFrame& frame) { states_.receive(frame); });
  link_.set_stop(rt::stop_requested);
}

Outcome<std::unique_ptr<CanBus>> CanBus::open(const CanBusOptions& options) {
  rt::catch_stop_signals();
  if (options.config.empty() && options.interface.empty()) {
    return misused(
        "no bus is selected: give --config FILE for the CAN line described there, or --iface NAME for a CAN bus, such "
        "as "
        "can0 or slcan:tcp:HOST:PORT");
  }
  if (const auto names = check_capture_names(options); !names) return tl::unexpected(names.error());
  const auto config = read_description_of_bus(options);
  if (!config) return tl::unexpected(config.error());
  const auto bit_rate = options.bit_rate.value_or(*config ? (*config)->bit_rate : canopen::CanPortOptions().bit_rate);
  const bool simulated = options.interface.empty();
  const auto name = simulated ? (*config)->interface : options.interface;
  Parts parts;
  if (simulated && !options.real_time) {
    parts.clock = std::make_unique<rt::VirtualClock>();
  } else {
    parts.clock = std::make_unique<rt::MonotonicClock>();
  }
  auto port = open_port(options, *config, {bit_rate, options.listen_only, options.error_frames}, *parts.clock);
  if (!port) return tl::unexpected(port.error());
  parts.port = std::move(*port);
  for (const auto& file : {options.log, options.pcap}) {
    if (const auto done = parts.capture(file, log_name(name)); !done) return tl::unexpected(done.error());
  }
  std::unique_ptr<CanBus> bus(new CanBus(std::move(parts)));
  bus->bit_rate_ = bit_rate;
  bus->simulated_ = simulated;
  bus->name_ = name;
  if (*config) {
    for (const auto& node : (*config)->nodes) bus->described_.push_back({node.node_id, node.name});
  }
  if (simulated && !options.real_time) bus->wait_for_boot_up();
  return bus;
}

void CanBus::wait_for_boot_up() {
  const auto deadline = link_.now() + kBootUpTime;
  const auto all_are_up = [&] {
    return std::all_of(described_.begin(), described_.end(),
                       [&](const DescribedNode& node) { return states_.of(node.node).state.has_value(); });
  };
  while (!all_are_up() && link_.receive(deadline)) {
  }
}

std::string_view CanBus::name_of(std::uint8_t node) const noexcept {
  const auto found =
      std::find_if(described_.begin(), described_.end(), [&](const DescribedNode& each) { return each.node == node; });
  return found == described_.end() ? std::string_view() : std::string_view(found->name);
}

void CanBus::let_frames_leave(std::size_t count) {
  constexpr std::int64_t kFrameBits = 135;  ///< of a base frame of eight bytes with its stuff bits, at most
  const std::chrono::nanoseconds on_the_bus{std::chrono::nanoseconds{std::chrono::seconds{1}}.count() * kFrameBits *
                                            static_cast<std::int64_t>(count) / bit_rate_};
  const auto deadline = link_.now() + kLeaveTime + on_the_bus;
  while (link_.now() < deadline && !link_.stopped() && !link_.down()) static_cast<void>(link_.receive(deadline));
}

Outcome<void> CanBus::finish_captures() {
  for (const auto& capture : parts_.captures) {
    const auto closed = capture->close();
    if (!closed) return failed(closed.error().message);
    if (closed->dropped != 0)
      progress("{} frames are missing in a capture: the file could not keep up", closed->dropped);
  }
  return {};
}

void CanBus::tell_what_ends() const {
  if (!simulated_) return;
  progress(
      "the line is simulated in this process and ends with it: every command starts a new one according to its "
      "description; `driveline simulate` serves one that persists");
}

}  // namespace driveline::cli
