#pragma once

#include <array>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <type_traits>
#include <utility>

namespace driveline::runtime {

/// The kinds of events. driveline/runtime/event.hpp defines them all, the headers beside this one a few each.
namespace events {
struct AliasNotUnique;
struct AxesNotOff;
struct AxesStopped;
struct AxisFailed;
struct AxisLeaseLost;
struct AxisNeverEnabled;
struct AxisNotReset;
struct AxisOffItsSetpoint;
struct AxisPresenceChanged;
struct AxisProbed;
struct AxisRequestFailed;
struct AxisRequested;
struct AxisRestored;
struct BridgeBack;
struct BridgeRemark;
struct BridgeStill;
struct BridgeStopped;
struct BusFailed;
struct CallerRefused;
struct CanPortOpened;
struct CanStateChanged;
struct CaptureIncomplete;
struct ClocksBeingSet;
struct ClocksChanged;
struct ClocksLocked;
struct CommandAnswered;
struct CommanderLost;
struct CommandsOpen;
struct CommandsSummary;
struct CommunicationBack;
struct CommunicationLost;
struct CommunicationNotBack;
struct Configured;
struct Emergency;
struct EoeAddressRefused;
struct EoeUp;
struct ExchangeGroupReleased;
struct ExchangeGroupZeroed;
struct FaultRecorded;
struct FileNotWritten;
struct ForbiddenCalls;
struct ForeignTraffic;
struct GantryAskew;
struct GatewayUp;
struct GatewayWriteRefused;
struct GatewayWritten;
struct GroupFailed;
struct GroupPathBegun;
struct GroupRequestFailed;
struct GroupRequested;
struct GroupRestored;
struct InterfaceOpened;
struct InvalidBridgeCounts;
struct InvalidCommands;
struct LineChanged;
struct LineDiffers;
struct MasterAway;
struct MasterAwayOften;
struct NoDescription;
struct NoPath;
struct NoProcessData;
struct NodeChanged;
struct NodeNotReleased;
struct NodeNoted;
struct NodesConfigured;
struct NotInInit;
struct Progress;
struct RealtimeSetUp;
struct RecordingShortened;
struct ScaleDiffers;
struct SlaveNotBack;
struct SlaveNotConnected;
struct SlaveUnusable;
struct SlavesFound;
struct SoeMessage;
struct StartupNoted;
struct StateReached;
struct StopRequested;
struct StreamClientCame;
struct StreamClientLeft;
struct StreamClientRefused;
struct StreamSetpointRefused;
struct StreamStarved;
struct StreamUp;
struct TakenOver;
struct TelemetryOff;
}  // namespace events

/// A list of types that need not be complete.
template <typename... Kinds>
struct EventKindList {
  static constexpr std::size_t kSize = sizeof...(Kinds);

  /// Position of `Kind` in the list; kSize: not in it.
  template <typename Kind>
  [[nodiscard]] static constexpr std::size_t number_of() noexcept {
    constexpr std::array<bool, kSize> kSame{std::is_same_v<Kind, Kinds>...};
    std::size_t number = 0;
    while (number < kSize && !kSame[number]) ++number;
    return number;
  }
};

/// All kinds of events.
using EventKinds = EventKindList<
    events::InterfaceOpened, events::SlavesFound, events::SlaveUnusable, events::AliasNotUnique, events::NoDescription,
    events::TakenOver, events::LineDiffers, events::ClocksBeingSet, events::Configured, events::ScaleDiffers,
    events::NoProcessData, events::RealtimeSetUp, events::ClocksLocked, events::StateReached, events::NoPath,
    events::StartupNoted, events::Progress, events::StopRequested, events::SlaveNotConnected, events::LineChanged,
    events::SlaveNotBack, events::Emergency, events::SoeMessage, events::CommunicationLost, events::CommunicationBack,
    events::CommunicationNotBack, events::BusFailed, events::ClocksChanged, events::ExchangeGroupZeroed,
    events::ExchangeGroupReleased, events::MasterAway, events::MasterAwayOften, events::AxisPresenceChanged,
    events::AxesStopped, events::AxesNotOff, events::NotInInit, events::AxisNeverEnabled, events::AxisOffItsSetpoint,
    events::ForbiddenCalls, events::ForeignTraffic, events::FaultRecorded, events::RecordingShortened,
    events::CaptureIncomplete, events::FileNotWritten, events::EoeUp, events::EoeAddressRefused, events::GatewayUp,
    events::GatewayWritten, events::GatewayWriteRefused, events::AxisRequested, events::AxisRequestFailed,
    events::AxisProbed, events::CallerRefused, events::AxisLeaseLost, events::AxisFailed, events::AxisNotReset,
    events::AxisRestored, events::GantryAskew, events::GroupRequested, events::GroupPathBegun,
    events::GroupRequestFailed, events::GroupFailed, events::GroupRestored, events::StreamUp, events::StreamClientCame,
    events::StreamClientRefused, events::StreamSetpointRefused, events::StreamStarved, events::StreamClientLeft,
    events::TelemetryOff, events::BridgeStill, events::BridgeStopped, events::BridgeBack, events::BridgeRemark,
    events::InvalidBridgeCounts, events::CommandsOpen, events::CommandAnswered, events::CommandsSummary,
    events::CommanderLost, events::InvalidCommands, events::CanPortOpened, events::NodesConfigured, events::NodeNoted,
    events::NodeChanged, events::CanStateChanged, events::NodeNotReleased>;

/// A type that is a kind of event.
template <typename Kind>
concept EventKind = EventKinds::number_of<Kind>()
< EventKinds::kSize;

/// The facts of an event: a value of one of the EventKinds, which does not change any more. Copies share it.
///
/// Not a std::variant: each source that moves or destroys one of 90 kinds would compile the code for all of them.
class EventFacts {
 public:
  /// Allocates: not for the cycle.
  template <EventKind Kind>
  EventFacts(Kind facts)  // NOLINT(google-explicit-constructor): the facts of an event stand for it
      : kind_(EventKinds::number_of<Kind>()), facts_(std::make_shared<const Kind>(std::move(facts))) {}

  /// Whether the facts are of kind `Kind`.
  template <EventKind Kind>
  [[nodiscard]] bool is() const noexcept {
    return kind_ == EventKinds::number_of<Kind>();
  }
  /// Returns the facts if they are of kind `Kind`, else null. Valid as long as a copy of the facts exists.
  template <EventKind Kind>
  [[nodiscard]] const Kind* as() const noexcept {
    return is<Kind>() ? static_cast<const Kind*>(facts_.get()) : nullptr;
  }

 private:
  std::size_t kind_;
  std::shared_ptr<const void> facts_;
};

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
    return facts.is<Kind>();
  }
  /// Returns the facts if the event is of kind `Kind`, else null.
  template <typename Kind>
  [[nodiscard]] const Kind* as() const noexcept {
    return facts.as<Kind>();
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
