#pragma once

#include <chrono>
#include <cstdint>
#include <optional>
#include <string>
#include <variant>

#include "driveline/runtime/event/axis_events.hpp"
#include "driveline/runtime/event/command_events.hpp"
#include "driveline/runtime/event/group_events.hpp"
#include "driveline/runtime/event/operation_events.hpp"
#include "driveline/runtime/event/result_events.hpp"
#include "driveline/runtime/event/service_events.hpp"
#include "driveline/runtime/event/set_up_events.hpp"
#include "driveline/runtime/event/stream_events.hpp"
#include "driveline/runtime/event/telemetry_events.hpp"

namespace driveline::runtime {

/// The facts of an event; the alternative is its kind.
using EventFacts = std::variant<
    events::InterfaceOpened, events::SlavesFound, events::SlaveUnusable, events::AliasNotUnique, events::NoDescription,
    events::TakenOver, events::LineDiffers, events::ClocksBeingSet, events::Configured, events::ScaleDiffers,
    events::NoProcessData, events::RealtimeSetUp, events::ClocksLocked, events::StateReached, events::NoPath,
    events::Progress, events::StopRequested, events::SlaveNotConnected, events::LineChanged, events::SlaveNotBack,
    events::Emergency, events::SoeMessage, events::CommunicationLost, events::CommunicationBack,
    events::CommunicationNotBack, events::BusFailed, events::ClocksChanged, events::ExchangeGroupZeroed,
    events::ExchangeGroupReleased, events::MasterAway, events::MasterAwayOften, events::AxisPresenceChanged,
    events::AxesStopped, events::AxesNotOff, events::NotInInit, events::AxisNeverEnabled, events::AxisOffItsSetpoint,
    events::ForbiddenCalls, events::ForeignTraffic, events::FaultRecorded, events::RecordingEnded,
    events::CaptureIncomplete, events::FileNotWritten, events::EoeUp, events::EoeAddressRefused, events::GatewayUp,
    events::AxisRequested, events::AxisRequestFailed, events::AxisProbed, events::CallerRefused, events::AxisLeaseLost,
    events::AxisFailed, events::AxisNotReset, events::AxisRestored, events::GantryAskew, events::GroupRequested,
    events::GroupPathBegun, events::GroupRequestFailed, events::GroupFailed, events::GroupRestored, events::StreamUp,
    events::StreamClientCame, events::StreamClientRefused, events::StreamSetpointRefused, events::StreamStarved,
    events::StreamClientLeft, events::TelemetryOff, events::BridgeStopped, events::BridgeBack, events::BridgeRemark,
    events::InvalidBridgeCounts, events::CommandsOpen, events::CommandAnswered, events::CommandsSummary,
    events::CommanderLost, events::InvalidCommands>;

/// Severity of an event.
enum class Severity : std::uint8_t {
  kProgress,  ///< a normal step of a run; not in the run report
  kNotice,    ///< something has happened to the line or its axes
  kFault,     ///< a fault that does not end the run
  kFailure,   ///< a fault that makes the run fail
};

/// What happened to a line, with the facts. `describe()` makes the sentence.
///
///     if (const auto* changed = event.as<events::LineChanged>()) show(changed->event.slave);
///     if (event.is_fault()) warn(describe(event));
struct Event {
  EventFacts facts;                         ///< kind and facts
  Severity severity = Severity::kProgress;  ///< severity of the event
  /// Time in operation; none: before operation, or after the line was shut down.
  std::optional<std::chrono::nanoseconds> time{};

  /// Whether the event is of kind `Kind`.
  template <typename Kind>
  [[nodiscard]] bool is() const noexcept {
    return std::holds_alternative<Kind>(facts);
  }
  /// Returns the facts if the event is of kind `Kind`, else null.
  template <typename Kind>
  [[nodiscard]] const Kind* as() const noexcept {
    return std::get_if<Kind>(&facts);
  }
  /// Whether the event is a fault, no matter whether the run continues.
  [[nodiscard]] bool is_fault() const noexcept { return severity >= Severity::kFault; }
};

/// Returns the event as one sentence with its facts (several lines for a list), without its time. `increments`: adds
/// lengths in drive increments to those in the units of the axes.
[[nodiscard]] std::string describe(const Event& event, bool increments = false);

/// Returns the time in operation and the sentence: "1.250 s slave 3 (z): back in OP". Without a time, the sentence
/// alone.
[[nodiscard]] std::string describe_with_time(const Event& event, bool increments = false);

}  // namespace driveline::runtime
