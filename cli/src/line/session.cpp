#include "line/session.hpp"

#include <fmt/format.h>
#include <algorithm>

#include "console.hpp"

namespace driveline::cli {

namespace {

std::string holder_text(const port::InterfaceHolder& holder) {
  if (holder.pid == 0) return "another process of this program";
  return fmt::format("process {}{}", holder.pid, holder.command.empty() ? "" : fmt::format(" ({})", holder.command));
}

std::vector<std::string> interfaces_of(const LineConfig& config) {
  std::vector<std::string> interfaces;
  if (config.interface) interfaces.push_back(*config.interface);
  if (config.interface2) interfaces.push_back(*config.interface2);
  return interfaces;
}

}  // namespace

Outcome<std::vector<port::InterfaceLock>> take_locks(std::span<const std::string> interfaces, bool force,
                                                     std::string_view would) {
  std::vector<port::InterfaceLock> locks;
  for (const auto& interface : interfaces) {
    auto lock = port::InterfaceLock::take(interface);
    if (lock) {
      locks.push_back(std::move(*lock));
    } else if (!force) {
      return failed(fmt::format("{} has interface {}, and this would {}; --force does it all the same",
                                holder_text(lock.error()), interface, would));
    }
  }
  return locks;
}

Outcome<void> Session::claim(bool force, std::string_view would) {
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

Outcome<std::unique_ptr<Session>> Session::open(const BusOptions& options, const Adjust& adjust) {
  std::unique_ptr<Session> session(new Session);
  if (options.config.empty() && options.interface.empty()) {
    return misused(
        "which bus? Give --config FILE for the line described there, or --iface NAME for a network interface");
  }
  if (!options.config.empty()) {
    auto config = load_line_config(options.config);
    if (!config) return misused(config.error());
    session->config_ = std::move(*config);
    session->has_config_ = true;
  }
  auto& config = session->config_;
  if (!options.interface.empty()) config.interface = options.interface;
  if (!options.interface2.empty()) config.interface2 = options.interface2;
  if (config.interface2 && !config.interface) {
    return misused("--iface2 is the other end of a ring: it needs --iface NAME as well");
  }
  if (config.interface2 && *config.interface2 == *config.interface) {
    return misused(fmt::format("--iface2 {}: is the first interface, too; a ring has two ends", *config.interface2));
  }
  // A simulated line in this process may run anywhere; where drives may hang on the wire, it must be said.
  config.realtime.policy =
      config.policy.value_or(config.interface ? rt::RealtimePolicy::kEnforce : rt::RealtimePolicy::kDegrade);
  // Whatever comes to the ports of DDS, from whomever, is read in the process that holds the drives.
  config.telemetry.enabled = config.telemetry.asked.value_or(!config.interface);
  session->virtual_time_ = options.virtual_time;
  if (options.virtual_time && config.interface) {
    return misused("--virtual runs the simulated line in this process; a network interface has no virtual time");
  }
  if (adjust) {
    if (auto adjusted = adjust(config); !adjusted) return tl::unexpected(adjusted.error());
  }
  if (options.virtual_time) {
    session->clock_ = std::make_unique<rt::VirtualClock>();
  } else {
    session->clock_ = std::make_unique<rt::MonotonicClock>();
  }
  if (config.interface) {
    if (auto opened = session->open_interfaces(); !opened) return tl::unexpected(opened.error());
  } else {
    session->line_ = make_simulated_line(config, *session->clock_, true);
    session->wire_ = session->line_.get();
    if (session->line_->wiring().master(slaves::MasterPort::kSecondary)) {
      session->join_ends(*session->line_, session->line_->secondary());
    }
  }
  if (config.output.capture) {
    auto capture =
        port::CapturePort::open(*session->wire_, *session->clock_,
                                {*config.output.capture, config.interface.value_or("line"), 4096, std::nullopt});
    if (!capture) return failed(capture.error().message);
    session->capture_ = std::move(*capture);
  }
  return session;
}

Outcome<void> Session::open_interfaces() {
  auto port = port::RawSocketPort::open({*config_.interface, true, 6}, *clock_);
  if (!port) return failed(port.error().message);
  raw_ = std::move(*port);
  wire_ = raw_.get();
  if (!config_.interface2) return must_have_link();
  auto second = port::RawSocketPort::open({*config_.interface2, true, 6}, *clock_);
  if (!second) return failed(second.error().message);
  raw2_ = std::move(*second);
  join_ends(*raw_, *raw2_);
  return must_have_link();
}

Outcome<void> Session::must_have_link() const {
  if (raw_->link_up() || (raw2_ && raw2_->link_up())) return {};
  const auto names = raw2_ ? fmt::format("{} and {}", *config_.interface, *config_.interface2) : *config_.interface;
  return failed(
      fmt::format("{}: no link: no cable, nothing switched on at its other end, or the interface is down "
                  "(ip link set {} up)",
                  names, *config_.interface));
}

void Session::join_ends(port::Port& primary, port::Port& secondary) {
  // Half of an answer waits for the other half for half of the cycle at most: the cycle itself waits three quarters.
  port::RedundantPort::Settings settings;
  settings.half_wait = std::max(settings.half_wait, config_.period / 2);
  ring_ = std::make_unique<port::RedundantPort>(primary, secondary, *clock_, settings);
  wire_ = ring_.get();
}

void Session::tell_what_ends() const {
  if (config_.interface) return;
  progress(
      "the line is simulated in this process and ends with it: every command starts a new one, as its description "
      "says; "
      "`driveline simulate` serves one that stays");
}

Outcome<std::optional<std::filesystem::path>> Session::close_capture() {
  if (!capture_) return std::optional<std::filesystem::path>{};
  const auto closed = capture_->close();
  if (!closed) return failed(closed.error().message);
  if (closed->frames == 0) {
    std::error_code ignored;
    std::filesystem::remove(*config_.output.capture, ignored);
    return std::optional<std::filesystem::path>{};
  }
  if (closed->dropped > 0) {
    progress("capture: {} frames are missing in {}", closed->dropped, config_.output.capture->string());
  }
  return config_.output.capture;
}

}  // namespace driveline::cli
