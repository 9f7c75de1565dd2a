#pragma once

#include <string>

#include "driveline/runtime/event.hpp"

namespace driveline::runtime {

/// Makes the sentence of an event; for std::visit.
class EventSentence {
 public:
  /// `increments`: shows drive increments in addition to the units of the axes.
  EventSentence(const Event& event, bool increments) noexcept : event_(event), increments_(increments) {}

  // set_up_sentences.cpp
  std::string operator()(const events::InterfaceOpened& facts) const;
  std::string operator()(const events::SlavesFound& facts) const;
  std::string operator()(const events::SlaveUnusable& facts) const;
  std::string operator()(const events::AliasNotUnique& facts) const;
  std::string operator()(const events::NoDescription& facts) const;
  std::string operator()(const events::TakenOver& facts) const;
  std::string operator()(const events::LineDiffers& facts) const;
  std::string operator()(const events::ClocksBeingSet& facts) const;
  std::string operator()(const events::Configured& facts) const;
  std::string operator()(const events::ScaleDiffers& facts) const;
  std::string operator()(const events::StartupNoted& facts) const;
  std::string operator()(const events::NoProcessData& facts) const;
  std::string operator()(const events::RealtimeSetUp& facts) const;
  std::string operator()(const events::ClocksLocked& facts) const;
  std::string operator()(const events::StateReached& facts) const;
  std::string operator()(const events::NoPath& facts) const;

  // line_sentences.cpp
  std::string operator()(const events::Progress& facts) const;
  std::string operator()(const events::StopRequested& facts) const;
  std::string operator()(const events::SlaveNotConnected& facts) const;
  std::string operator()(const events::LineChanged& facts) const;
  std::string operator()(const events::SlaveNotBack& facts) const;
  std::string operator()(const events::Emergency& facts) const;
  std::string operator()(const events::SoeMessage& facts) const;
  std::string operator()(const events::CommunicationLost& facts) const;
  std::string operator()(const events::CommunicationBack& facts) const;
  std::string operator()(const events::CommunicationNotBack& facts) const;
  std::string operator()(const events::BusFailed& facts) const;
  std::string operator()(const events::ClocksChanged& facts) const;
  std::string operator()(const events::ExchangeGroupZeroed& facts) const;
  std::string operator()(const events::ExchangeGroupReleased& facts) const;
  std::string operator()(const events::MasterAway& facts) const;
  std::string operator()(const events::MasterAwayOften& facts) const;

  // can_sentences.cpp
  std::string operator()(const events::CanPortOpened& facts) const;
  std::string operator()(const events::NodesConfigured& facts) const;
  std::string operator()(const events::NodeNoted& facts) const;
  std::string operator()(const events::NodeChanged& facts) const;
  std::string operator()(const events::CanStateChanged& facts) const;
  std::string operator()(const events::NodeNotReleased& facts) const;

  // axis_sentences.cpp
  std::string operator()(const events::AxisPresenceChanged& facts) const;
  std::string operator()(const events::AxesStopped& facts) const;
  std::string operator()(const events::AxesNotOff& facts) const;
  std::string operator()(const events::AxisNeverEnabled& facts) const;
  std::string operator()(const events::AxisOffItsSetpoint& facts) const;

  // axis_request_sentences.cpp
  std::string operator()(const events::AxisRequested& facts) const;
  std::string operator()(const events::AxisRequestFailed& facts) const;
  std::string operator()(const events::AxisProbed& facts) const;
  std::string operator()(const events::CallerRefused& facts) const;
  std::string operator()(const events::AxisLeaseLost& facts) const;
  std::string operator()(const events::AxisFailed& facts) const;
  std::string operator()(const events::AxisNotReset& facts) const;
  std::string operator()(const events::AxisRestored& facts) const;
  std::string operator()(const events::GantryAskew& facts) const;

  // group_sentences.cpp
  std::string operator()(const events::GroupRequested& facts) const;
  std::string operator()(const events::GroupPathBegun& facts) const;
  std::string operator()(const events::GroupRequestFailed& facts) const;
  std::string operator()(const events::GroupFailed& facts) const;
  std::string operator()(const events::GroupRestored& facts) const;

  // result_sentences.cpp
  std::string operator()(const events::NotInInit& facts) const;
  std::string operator()(const events::ForbiddenCalls& facts) const;
  std::string operator()(const events::ForeignTraffic& facts) const;
  std::string operator()(const events::FaultRecorded& facts) const;
  std::string operator()(const events::RecordingShortened& facts) const;
  std::string operator()(const events::CaptureIncomplete& facts) const;
  std::string operator()(const events::FileNotWritten& facts) const;

  // service_sentences.cpp
  std::string operator()(const events::EoeUp& facts) const;
  std::string operator()(const events::EoeAddressRefused& facts) const;
  std::string operator()(const events::GatewayUp& facts) const;
  std::string operator()(const events::GatewayWritten& facts) const;
  std::string operator()(const events::GatewayWriteRefused& facts) const;

  // stream_sentences.cpp
  std::string operator()(const events::StreamUp& facts) const;
  std::string operator()(const events::StreamClientCame& facts) const;
  std::string operator()(const events::StreamClientRefused& facts) const;
  std::string operator()(const events::StreamSetpointRefused& facts) const;
  std::string operator()(const events::StreamStarved& facts) const;
  std::string operator()(const events::StreamClientLeft& facts) const;

  // telemetry_sentences.cpp
  std::string operator()(const events::TelemetryOff& facts) const;
  std::string operator()(const events::BridgeStill& facts) const;
  std::string operator()(const events::BridgeStopped& facts) const;
  std::string operator()(const events::BridgeBack& facts) const;
  std::string operator()(const events::BridgeRemark& facts) const;
  std::string operator()(const events::InvalidBridgeCounts& facts) const;

  // command_sentences.cpp
  std::string operator()(const events::CommandsOpen& facts) const;
  std::string operator()(const events::CommandAnswered& facts) const;
  std::string operator()(const events::CommandsSummary& facts) const;
  std::string operator()(const events::CommanderLost& facts) const;
  std::string operator()(const events::InvalidCommands& facts) const;

 private:
  /// Formats a length (rad or m) as "1.25 mm", or "1.25 mm (1311 increments)".
  [[nodiscard]] std::string length_text(const events::EventAxis& axis, double length) const;
  /// Describes a motion that leaves the software limits.
  [[nodiscard]] std::string range_text(const events::AxesStopped& facts) const;
  /// Describes an actual position that is implausible.
  [[nodiscard]] std::string position_text(const events::AxesStopped& facts) const;

  const Event& event_;
  bool increments_;
};

/// Returns "; the master had been away for 54.0 ms at 0.850 s"; empty without an absence.
[[nodiscard]] std::string cause_text(const std::optional<motion::MasterAbsence>& absence);

/// Returns "slave 3 (z)".
[[nodiscard]] std::string slave_text(std::size_t slave, const std::string& name);

}  // namespace driveline::runtime
