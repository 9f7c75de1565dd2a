#include "diagnostics.hpp"

#include <algorithm>
#include <array>

#include "joint_states.hpp"

namespace driveline::bridge {
namespace {

using diagnostic_msgs::msg::dds_::DiagnosticStatus_;
using snapshot::AxisState;
using snapshot::LineState;
using snapshot::SampledPlcopenState;

constexpr std::uint8_t kAlOp = 8;

constexpr std::array kLineWords{"down", "INIT", "PREOP", "SAFEOP", "OP"};
constexpr std::array kAxisWords{"not ready to switch on",
                                "switch on disabled",
                                "ready to switch on",
                                "switched on",
                                "operation enabled",
                                "quick stop active",
                                "fault reaction active",
                                "fault",
                                "unavailable"};
constexpr std::array kPlcopenWords{"",         "Disabled",       "Standstill",       "Homing",
                                   "Stopping", "DiscreteMotion", "ContinuousMotion", "SynchronizedMotion",
                                   "ErrorStop"};

template <std::size_t kCount>
std::string word(const std::array<const char*, kCount>& words, std::size_t number) {
  return number < kCount ? words[number] : "?";
}

std::string al_state_word(std::uint8_t state) {
  switch (state) {
    case 1:
      return "INIT";
    case 2:
      return "PREOP";
    case 3:
      return "BOOT";
    case 4:
      return "SAFEOP";
    case kAlOp:
      return "OP";
    default:
      return "in an unknown state";
  }
}

void add_value(DiagnosticStatus_& status, const char* key, const std::string& value) {
  diagnostic_msgs::msg::dds_::KeyValue_ pair;
  pair.key_(key);
  pair.value_(value);
  status.values_().push_back(pair);
}

template <std::size_t kBytes>
std::string text(const snapshot::FeedText<kBytes>& from) {
  return std::string{from.view().substr(0, kBytes)};
}

unsigned errors_of(const snapshot::FeedSlave& slave) {
  unsigned sum = slave.processing_unit_errors + slave.pdi_errors;
  for (const auto& port : slave.port) sum += port.invalid_frames + port.receive_errors + port.lost_links;
  return sum;
}

/// Describes what is wrong with a slave; empty: nothing.
std::string trouble_of(const snapshot::FeedSlave& slave) {
  if (slave.answers == 0) return slave.hot_connect != 0 ? "is not connected" : "does not answer";
  if (slave.al_error != 0) return al_state_word(slave.al_state) + " with an error: " + text(slave.al_text);
  if (slave.al_state != kAlOp) return al_state_word(slave.al_state);
  if (errors_of(slave) > 0) return "has counted errors";
  return {};
}

DiagnosticLevel level_of(const snapshot::FeedSlave& slave) {
  if (slave.answers == 0) return slave.hot_connect != 0 ? DiagnosticLevel::kWarn : DiagnosticLevel::kError;
  if (slave.al_error != 0) return DiagnosticLevel::kError;
  return trouble_of(slave).empty() ? DiagnosticLevel::kOk : DiagnosticLevel::kWarn;
}

DiagnosticLevel level_of(const snapshot::AxisSample& sample) {
  const bool fault = sample.state == AxisState::kFault || sample.state == AxisState::kFaultReactionActive;
  if (fault || sample.plcopen_state == SampledPlcopenState::kErrorStop) return DiagnosticLevel::kError;
  if (sample.state == AxisState::kUnavailable) return DiagnosticLevel::kStale;
  return sample.state == AxisState::kQuickStopActive ? DiagnosticLevel::kWarn : DiagnosticLevel::kOk;
}

}  // namespace

Diagnostics::Diagnostics(const DdsConfig& config) : line_(config.line_name), axes_(config.axes.size()) {
  for (const auto& axis : config.axes) names_.push_back(axis.name);
}

DiagnosticStatus_ Diagnostics::begin(const std::string& what, DiagnosticLevel level, const std::string& text) const {
  DiagnosticStatus_ status;
  status.name_("driveline " + line_ + ": " + what);
  status.level_(static_cast<std::uint8_t>(level));
  status.message_(text);
  return status;
}

DiagnosticStatus_ Diagnostics::of_line(const snapshot::LineStatus& line) const {
  const auto state = word(kLineWords, static_cast<std::size_t>(line.state));
  const bool up = line.state == LineState::kOp;
  const auto level = !up                   ? DiagnosticLevel::kError
                     : line.faults.empty() ? DiagnosticLevel::kOk
                                           : DiagnosticLevel::kWarn;
  auto status = begin("line", level, line.faults.empty() ? state : state + "; " + line.faults.back());
  status.hardware_id_(line_);
  add_value(status, "state", state);
  add_value(status, "cycles", std::to_string(line.cycles));
  add_value(status, "missed_periods", std::to_string(line.missed_periods));
  add_value(status, "wkc_errors", std::to_string(line.wkc_errors));
  add_value(status, "lost_frames", std::to_string(line.lost_frames));
  add_value(status, "wake_latency_p99_ns", std::to_string(line.wake_latency.p99.count()));
  add_value(status, "cycle_cost_p99_ns", std::to_string(line.cycle_cost.p99.count()));
  return status;
}

DiagnosticStatus_ Diagnostics::of_slave(std::size_t position) const {
  const auto& slave = condition_.slaves[position];
  const auto trouble = trouble_of(slave);
  auto status = begin("slave " + std::to_string(position) + " " + text(slave.name), level_of(slave),
                      trouble.empty() ? "OP" : trouble);
  status.hardware_id_(text(slave.device) + " " + std::to_string(slave.serial_number));
  add_value(status, "state", al_state_word(slave.al_state));
  add_value(status, "al_status_code", std::to_string(slave.al_status_code));
  add_value(status, "errors", std::to_string(errors_of(slave)));
  add_value(status, "alias", std::to_string(slave.alias));
  return status;
}

DiagnosticStatus_ Diagnostics::of_axis(std::size_t axis) const {
  const auto& sample = axes_[axis];
  const auto state = word(kAxisWords, static_cast<std::size_t>(sample.state));
  const auto plcopen = word(kPlcopenWords, static_cast<std::size_t>(sample.plcopen_state));
  auto status = begin("axis " + names_[axis], level_of(sample), plcopen.empty() ? state : plcopen + ", " + state);
  status.hardware_id_(names_[axis]);
  add_value(status, "state", state);
  add_value(status, "plcopen_state", plcopen);
  add_value(status, "mode", std::to_string(sample.mode));
  add_value(status, "error_code", std::to_string(sample.error_code));
  add_value(status, "owner", axis < condition_.owners.size() ? text(condition_.owners[axis].name) : std::string{});
  return status;
}

diagnostic_msgs::msg::dds_::DiagnosticArray_* Diagnostics::message(const snapshot::LineStatus& line,
                                                                   std::int64_t wall_time_ns) {
  message_.header_().stamp_(stamp_of(wall_time_ns));
  auto& all = message_.status_();
  all.clear();
  all.push_back(of_line(line));
  for (std::size_t i = 0; i < condition_.slaves.size(); ++i) all.push_back(of_slave(i));
  for (std::size_t i = 0; i < axes_.size(); ++i) all.push_back(of_axis(i));
  return &message_;
}

}  // namespace driveline::bridge
