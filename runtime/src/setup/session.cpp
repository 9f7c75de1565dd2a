#include "driveline/runtime/setup/session.hpp"

#include <fmt/format.h>
#include <algorithm>
#include <utility>

#include "driveline/port/interface_check.hpp"
#include "driveline/port/xdp_port.hpp"
#include "setup/ordered_port.hpp"

namespace driveline::runtime {

namespace {

std::string holder_text(const port::InterfaceHolder& holder) {
  if (holder.pid == 0) return "another driveline process";
  return fmt::format("process {}{}", holder.pid, holder.command.empty() ? "" : fmt::format(" ({})", holder.command));
}

std::vector<std::string> interfaces_of(const LineConfig& config) {
  std::vector<std::string> interfaces;
  if (config.interface) interfaces.push_back(*config.interface);
  if (config.interface2) interfaces.push_back(*config.interface2);
  return interfaces;
}

/// Returns why long frames do not pass an interface; empty: they do.
std::string too_short_for_frames(const std::string& interface) {
  constexpr std::uint32_t kWholeFrame = 1500;
  const auto facts = port::read_interface_facts(interface);
  if (!facts || facts->mtu >= kWholeFrame) return {};
  return fmt::format(
      "{}: the interface takes no frames of more than {} bytes, and those of EtherCAT have up to {} (ip link set dev "
      "{} "
      "mtu {})",
      interface, facts->mtu, kWholeFrame, interface, kWholeFrame);
}

}  // namespace

Result<std::vector<port::InterfaceLock>> take_locks(std::span<const std::string> interfaces, bool force,
                                                    std::string_view would) {
  std::vector<port::InterfaceLock> locks;
  for (const auto& interface : interfaces) {
    auto lock = port::InterfaceLock::take(interface);
    if (lock) {
      locks.push_back(std::move(*lock));
    } else if (!force) {
      return fail(ErrorKind::kInterfaceBusy, fmt::format("{} uses interface {}; this command would {}",
                                                         holder_text(lock.error()), interface, would));
    }
  }
  return locks;
}

Result<void> Session::claim(bool force, std::string_view would) {
  if (!locks_.empty()) return {};
  auto locks = take_locks(interfaces_of(config_), force, would);
  if (!locks) return tl::unexpected(locks.error());
  locks_ = std::move(*locks);
  return {};
}

bool Session::claimed_by_another() const {
  const auto interfaces = interfaces_of(config_);
  return locks_.empty() && std::any_of(interfaces.begin(), interfaces.end(), [](const std::string& interface) {
           return port::InterfaceLock::holder(interface).has_value();
         });
}

Result<std::unique_ptr<Session>> Session::open(const BusOptions& options, const Adjust& adjust) {
  if (!options.config.empty()) {
    auto config = load_line_config(options.config, options.devices);
    if (!config) return tl::unexpected(config.error());
    if (config->can) {
      return fail_file(options.config, "[bus] type is \"can\", a line of EtherCAT is expected here");
    }
    return open(std::move(*config), options, adjust);
  }
  if (options.interface.empty())
    return fail(ErrorKind::kCall, "a bus is a line description, a network interface, or both");
  std::unique_ptr<Session> session(new Session);
  auto opened = session->take_options(options, adjust);
  if (opened) opened = session->open_bus();
  if (!opened) return tl::unexpected(opened.error());
  return session;
}

Result<std::unique_ptr<Session>> Session::open(LineConfig config, const BusOptions& options, const Adjust& adjust) {
  std::unique_ptr<Session> session(new Session);
  session->config_ = std::move(config);
  session->has_config_ = true;
  auto opened = session->take_options(options, adjust);
  if (opened) opened = session->open_bus();
  if (!opened) return tl::unexpected(opened.error());
  return session;
}

Result<void> Session::take_options(const BusOptions& options, const Adjust& adjust) {
  auto& config = config_;
  if (!options.interface.empty()) config.interface = options.interface;
  if (!options.interface2.empty()) config.interface2 = options.interface2;
  if (config.interface2 && !config.interface) {
    return fail(ErrorKind::kSetting, "is the second interface of a ring: the first interface is needed as well",
                "interface2");
  }
  if (config.interface2 && *config.interface2 == *config.interface) {
    return fail(ErrorKind::kSetting,
                fmt::format("{} is also the first interface; a ring needs two interfaces", *config.interface2),
                "interface2");
  }
  if (config.interface2 && config.launch_ahead) {
    return fail(ErrorKind::kSetting,
                "cannot be used with [bus] launch_ahead_us: both ends of a ring send at the same time", "interface2");
  }
  // A simulated line in this process needs no real-time settings; with drives on the wire, running without them must be
  // permitted explicitly.
  config.realtime.policy =
      config.policy.value_or(config.interface ? rt::RealtimePolicy::kEnforce : rt::RealtimePolicy::kDegrade);
  virtual_time_ = options.virtual_time;
  cycle_ = options.cycle;
  if (options.virtual_time && config.interface) {
    return fail(ErrorKind::kSetting,
                "a simulated line in this process runs on virtual time; a network interface has no virtual time");
  }
  return adjust ? adjust(config) : Result<void>{};
}

Result<void> Session::open_bus() {
  if (virtual_time_) {
    clock_ = std::make_unique<rt::VirtualClock>();
  } else {
    clock_ = std::make_unique<rt::MonotonicClock>();
  }
  if (config_.interface) {
    if (auto opened = open_interfaces(); !opened) return opened;
  } else {
    line_ = make_simulated_line(config_, *clock_, true);
    orders_ = std::make_unique<LineOrders>(*line_);
    ordered_ = std::make_unique<OrderedPort>(*line_, *orders_, *clock_);
    wire_ = ordered_.get();
    if (line_->wiring().master(slaves::MasterPort::kSecondary)) join_ends(*ordered_, line_->secondary());
  }
  if (!config_.output.capture) return {};
  auto capture = port::CapturePort::open(
      *wire_, *clock_, {*config_.output.capture, config_.interface.value_or("line"), 4096, std::nullopt});
  if (!capture) return fail(ErrorKind::kMachine, capture.error().message);
  capture_ = std::move(*capture);
  return {};
}

Result<std::unique_ptr<port::InterfacePort>> Session::open_interface(const std::string& interface) {
  if (!cycle_ && port::has_xdp_program(interface)) {
    if (const auto holder = port::InterfaceLock::holder(interface)) {
      return fail(ErrorKind::kInterfaceBusy,
                  fmt::format("{} has interface {} with port = \"xdp\", and takes all EtherCAT frames "
                              "that arrive: with port = \"raw\" other programs can also receive them",
                              holder_text(*holder), interface));
    }
  }
  const bool may_fall_back = config_.realtime.policy == rt::RealtimePolicy::kDegrade;
  const auto early = cycle_ ? config_.launch_ahead : std::nullopt;
  auto opened =
      early ? port::open_launching_interface(interface, *early, may_fall_back, *clock_)
            : port::open_interface(interface, cycle_ ? config_.port : port::PortChoice::kRaw, may_fall_back, *clock_);
  if (!opened) return fail(ErrorKind::kMachine, opened.error().message);
  // Even the scan for slaves uses frames of the maximum length.
  if (auto trouble = too_short_for_frames(interface); !trouble.empty()) {
    return fail(ErrorKind::kMachine, std::move(trouble));
  }
  wires_.push_back({interface, opened->port->access_method(), std::move(opened->steps_down)});
  if (opened->launches) launch_ahead_ = *early;
  return std::move(opened->port);
}

Result<void> Session::open_interfaces() {
  auto first = open_interface(*config_.interface);
  if (!first) return tl::unexpected(first.error());
  end_ = std::move(*first);
  wire_ = end_.get();
  if (!config_.interface2) return must_have_link();
  auto second = open_interface(*config_.interface2);
  if (!second) return tl::unexpected(second.error());
  end2_ = std::move(*second);
  join_ends(*end_, *end2_);
  return must_have_link();
}

Result<void> Session::must_have_link() const {
  auto trouble = no_link();
  return trouble.empty() ? Result<void>{} : fail(ErrorKind::kMachine, std::move(trouble));
}

std::string Session::no_link() const {
  if (!end_ || end_->link_up() || (end2_ && end2_->link_up())) return {};
  const auto names = end2_ ? fmt::format("{} and {}", *config_.interface, *config_.interface2) : *config_.interface;
  if (!port::read_interface_facts(*config_.interface)) {
    return fmt::format("{}: the interface no longer exists", *config_.interface);
  }
  return fmt::format(
      "{}: no link: no cable, no powered device at the other end, or the interface is down (ip link set {} up)", names,
      *config_.interface);
}

void Session::join_ends(port::Port& primary, port::Port& secondary) {
  // Wait for half of an answer at most half of the cycle: the cycle itself waits three quarters.
  port::RedundantPort::Settings settings;
  settings.half_wait = std::max(settings.half_wait, config_.period / 2);
  ring_ = std::make_unique<port::RedundantPort>(primary, secondary, *clock_, settings);
  wire_ = ring_.get();
}

Session::~Session() {
  static_cast<void>(close_capture());
}

Result<Session::Capture> Session::close_capture() {
  Capture result;
  if (!capture_ || std::exchange(capture_closed_, true)) return result;
  const auto closed = capture_->close();
  if (!closed) return fail(ErrorKind::kMachine, closed.error().message);
  result.dropped = closed->dropped;
  if (closed->frames > 0) {
    result.file = config_.output.capture;
    return result;
  }
  std::error_code ignored;
  std::filesystem::remove(*config_.output.capture, ignored);
  return result;
}

}  // namespace driveline::runtime
