#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "driveline/rt/shared_ring.hpp"
#include "driveline/snapshot/feed/command_records.hpp"

/// Setpoints received over DDS, as the bridge hands them to the process that holds the line, and reports on their
/// streams. The content of a setpoint must be checked like any other input.
namespace driveline::snapshot {

/// Most axes in a stream.
inline constexpr std::size_t kStreamedAxes = 16;
/// Most setpoints that may wait; setpoints without room are lost, which their numbers reveal.
inline constexpr std::uint64_t kSetpointRoom = 512;
/// Number of reports stored for a slow bridge.
inline constexpr std::uint64_t kStreamReportRoom = 128;

/// Kind of a record, by its number in the IDL.
enum class SetpointKind : std::uint32_t {
  kGo,      ///< carries the setpoint, if there is one, and shows that the client is alive
  kFollow,  ///< makes axes follow the stream again that do not follow it
  kEnd,     ///< stops the axes and ends the stream
};

/// A setpoint of a client, or another request about its stream.
struct StreamedSetpoint {
  /// An axis of the stream.
  struct Axis {
    FeedText<31> name;        ///< name of the axis
    std::uint64_t lease = 0;  ///< CommandRecord::lease
  };
  /// Setpoint of an axis.
  struct Target {
    double position = 0;      ///< rad or m
    double velocity = 0;      ///< rad/s or m/s
    double acceleration = 0;  ///< rad/s^2 or m/s^2
  };
  CommandParticipant participant{};             ///< sender of the setpoint
  FeedText<63> client;                          ///< client name as given by the client
  std::uint64_t number = 0;                     ///< number of the setpoint; 0 in other records
  std::int64_t time_ns = 0;                     ///< time on the client's time axis
  std::uint32_t kind = 0;                       ///< SetpointKind, or any other value
  std::uint32_t axis_count = 0;                 ///< number of valid `axes`
  std::uint32_t target_count = 0;               ///< number of valid `targets`; 0: no setpoint
  std::uint32_t reserved = 0;                   ///< 0
  std::array<Axis, kStreamedAxes> axes{};       ///< axes of the stream
  std::array<Target, kStreamedAxes> targets{};  ///< setpoints, in the order of `axes`
};

/// State of a stream, by its number in the IDL.
enum class StreamReportState : std::uint32_t {
  kWaiting,    ///< stream::SessionState::kWaiting
  kStreaming,  ///< stream::SessionState::kStreaming
  kStarved,    ///< stream::SessionState::kStarved
  kEnding,     ///< stream::SessionState::kEnding
  kOver,       ///< stream::SessionState::kOver
  kRefused,    ///< there is no stream
};

/// Progress of a stream.
struct StreamReport {
  /// An axis of the stream.
  struct Axis {
    FeedText<31> name;            ///< name of the axis
    std::uint32_t following = 0;  ///< 1: follows the stream
    std::uint32_t leased = 0;     ///< 1: leased by the client
    double setpoint = 0;          ///< setpoint; rad or m
    double position = 0;          ///< actual position; rad or m
  };
  CommandParticipant participant{};        ///< owner of the stream
  FeedText<63> client;                     ///< client name as given by the client
  std::uint32_t state = 0;                 ///< StreamReportState
  std::uint32_t axis_count = 0;            ///< number of valid `axes`
  std::int64_t stream_ns = 0;              ///< current time of the line on the client's time axis
  std::int64_t newest_ns = 0;              ///< time of the newest accepted setpoint
  std::uint64_t taken = 0;                 ///< accepted setpoints
  std::uint64_t refused = 0;               ///< refused setpoints
  std::uint64_t starved = 0;               ///< number of times that the setpoints ran out during motion
  FeedText<255> text;                      ///< last refusal, or why the stream ended
  std::array<Axis, kStreamedAxes> axes{};  ///< axes of the stream
};

/// Content numbers of the regions.
inline constexpr std::uint32_t kSetpointContent = 0x434D'5350;      ///< StreamedSetpoint
inline constexpr std::uint32_t kStreamReportContent = 0x434D'5352;  ///< StreamReport

/// Layout of the region of the setpoints, which the bridge writes.
[[nodiscard]] constexpr rt::SharedLayout setpoint_layout(std::uint64_t capacity = 0) noexcept {
  return rt::shared_ring<StreamedSetpoint>(kSetpointContent, kCommandVersion, capacity);
}
/// Layout of the region of the reports, which the bridge reads.
[[nodiscard]] constexpr rt::SharedLayout stream_report_layout(std::uint64_t capacity = 0) noexcept {
  return rt::shared_blocks(kStreamReportContent, kCommandVersion, sizeof(StreamReport), capacity);
}

}  // namespace driveline::snapshot
