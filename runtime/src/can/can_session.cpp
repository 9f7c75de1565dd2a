#include "driveline/runtime/can/can_session.hpp"

#include <fmt/format.h>

#include <filesystem>
#include <utility>

#include "driveline/canopen_port/open_can_port.hpp"
#include "driveline/runtime/setup/session.hpp"

namespace driveline::runtime {
namespace {

/// Frames that a capture keeps until they are written.
constexpr std::size_t kCaptureFrames = 4096;

/// Name of the bus in a capture: that of the interface, where the text has one.
std::string capture_name(const LineConfig& config) {
  auto text = config.interface.value_or("can0");
  const auto slash = text.rfind('/');
  if (text.find(':') == std::string::npos) return text;
  return text.starts_with("socketcand:") && slash != std::string::npos ? text.substr(slash + 1) : "can0";
}

}  // namespace

Result<std::unique_ptr<CanSession>> CanSession::open(LineConfig config, const Options& options, const Adjust& adjust) {
  std::unique_ptr<CanSession> session(new CanSession);
  session->config_ = std::move(config);
  auto opened = session->take_options(options, adjust);
  if (opened) opened = session->open_port();
  if (opened) opened = session->open_capture();
  if (!opened) return tl::unexpected(opened.error());
  return session;
}

CanSession::~CanSession() {
  static_cast<void>(close_capture());
}

Result<void> CanSession::take_options(const Options& options, const Adjust& adjust) {
  if (!options.interface.empty()) config_.interface = options.interface;
  // As on EtherCAT: with drives on the wire, running without real-time settings must be permitted explicitly.
  config_.realtime.policy =
      config_.policy.value_or(config_.interface ? rt::RealtimePolicy::kEnforce : rt::RealtimePolicy::kDegrade);
  virtual_time_ = options.virtual_time;
  if (virtual_time_ && config_.interface) {
    return fail(ErrorKind::kSetting,
                fmt::format("a simulated line in this process runs on virtual time; {} has no virtual time",
                            *config_.interface));
  }
  return adjust ? adjust(config_) : Result<void>{};
}

Result<void> CanSession::open_port() {
  if (virtual_time_) {
    clock_ = std::make_unique<rt::VirtualClock>();
  } else {
    clock_ = std::make_unique<rt::MonotonicClock>();
  }
  canopen::CanPortOptions options;
  options.bit_rate = config_.can->bit_rate;
  options.automatic_recovery = true;
  if (!config_.interface) {
    auto simulated = std::make_unique<SimulatedCanPort>(can_line_of(config_), options, *clock_);
    simulated_ = simulated.get();
    port_ = std::move(simulated);
    return {};
  }
  auto opened = canopen::open_can_port(*config_.interface, options, *clock_);
  if (!opened) {
    const bool wrong = opened.error().code == canopen::CanPortErrorCode::kUsage;
    return fail(wrong ? ErrorKind::kSetting : ErrorKind::kMachine, opened.error().message, *config_.interface);
  }
  port_ = std::move(*opened);
  return {};
}

Result<void> CanSession::open_capture() {
  if (!config_.output.capture) return {};
  // On virtual time two runs write the same log.
  const auto unix_time_of_zero = virtual_time_ ? std::optional(std::chrono::nanoseconds{0}) : std::nullopt;
  auto opened = canopen::CanCapture::open(
      *port_, *clock_, {*config_.output.capture, capture_name(config_), kCaptureFrames, unix_time_of_zero});
  if (!opened) return fail(ErrorKind::kMachine, opened.error().message);
  capture_ = std::move(*opened);
  return {};
}

canopen::CanPort& CanSession::port() noexcept {
  return capture_ ? static_cast<canopen::CanPort&>(*capture_) : *port_;
}

std::string CanSession::bus_name() const {
  return config_.interface.value_or("the simulated bus");
}

Result<void> CanSession::claim(bool force, std::string_view would) {
  if (!locks_.empty() || !config_.interface) return {};
  auto locks = take_locks(std::span(&*config_.interface, 1), force, would);
  if (!locks) return tl::unexpected(locks.error());
  locks_ = std::move(*locks);
  return {};
}

Result<LineSession::Capture> CanSession::close_capture() {
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
