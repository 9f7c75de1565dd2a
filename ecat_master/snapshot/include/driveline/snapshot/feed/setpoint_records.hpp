#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "driveline/rt/shared_ring.hpp"
#include "driveline/snapshot/feed/command_records.hpp"

/// Setpoints that come over DDS, as the bridge hands them to the process that holds the line, and what becomes of
/// them. Whatever stands in a setpoint is to be checked like any other input.
namespace driveline::snapshot {

/// Axes of one stream.
inline constexpr std::size_t kStreamedAxes = 16;
/// Setpoints that wait at most; those that find no room are lost, and missing by their numbers.
inline constexpr std::uint64_t kSetpointRoom = 512;
/// Reports that are kept for a bridge that is slow.
inline constexpr std::uint64_t kStreamReportRoom = 128;

/// What is asked, by its number in the IDL.
enum class SetpointKind : std::uint32_t {
  kGo,      ///< the setpoint, if there is one; the client is there
  kFollow,  ///< axes that do not follow are to do so again
  kEnd,     ///< the axes come to rest, and the stream is over
};

/// A setpoint of a client, or what he says beside them.
struct StreamedSetpoint {
  /// An axis that is his.
  struct Axis {
    FeedText<31> name;        ///< of the axis
    std::uint64_t lease = 0;  ///< CommandRecord::lease
  };
  /// Where it shall be.
  struct Target {
    double position = 0;      ///< rad or m
    double velocity = 0;      ///< rad/s or m/s
    double acceleration = 0;  ///< rad/s^2 or m/s^2
  };
  CommandParticipant participant{};             ///< whose it is
  FeedText<63> client;                          ///< as he calls himself
  std::uint64_t number = 0;                     ///< of the setpoint; of other records 0
  std::int64_t time_ns = 0;                     ///< on the time axis of the client
  std::uint32_t kind = 0;                       ///< SetpointKind, or anything else
  std::uint32_t axis_count = 0;                 ///< of `axes`
  std::uint32_t target_count = 0;               ///< of `targets`; 0: it is no setpoint
  std::uint32_t reserved = 0;                   ///< 0
  std::array<Axis, kStreamedAxes> axes{};       ///< of the stream
  std::array<Target, kStreamedAxes> targets{};  ///< of the axes
};

/// What a stream is doing, by its number in the IDL.
enum class StreamReportState : std::uint32_t {
  kWaiting,    ///< stream::SessionState::kWaiting
  kStreaming,  ///< stream::SessionState::kStreaming
  kStarved,    ///< stream::SessionState::kStarved
  kEnding,     ///< stream::SessionState::kEnding
  kOver,       ///< stream::SessionState::kOver
  kRefused,    ///< there is none
};

/// How a stream goes on.
struct StreamReport {
  /// An axis of it.
  struct Axis {
    FeedText<31> name;            ///< of the axis
    std::uint32_t following = 0;  ///< 1: the stream
    std::uint32_t leased = 0;     ///< 1: by the client
    double setpoint = 0;          ///< rad or m
    double position = 0;          ///< actual one
  };
  CommandParticipant participant{};        ///< whose it is
  FeedText<63> client;                     ///< as he calls himself
  std::uint32_t state = 0;                 ///< StreamReportState
  std::uint32_t axis_count = 0;            ///< of `axes`
  std::int64_t stream_ns = 0;              ///< where the line is on the time axis of the client
  std::int64_t newest_ns = 0;              ///< of the setpoints that were taken
  std::uint64_t taken = 0;                 ///< setpoints
  std::uint64_t refused = 0;               ///< setpoints that were not taken
  std::uint64_t starved = 0;               ///< how often they were used up in motion
  FeedText<255> text;                      ///< what was refused last, or why it ended
  std::array<Axis, kStreamedAxes> axes{};  ///< of the stream
};

/// Numbers of the regions' contents.
inline constexpr std::uint32_t kSetpointContent = 0x434D'5350;      ///< StreamedSetpoint
inline constexpr std::uint32_t kStreamReportContent = 0x434D'5352;  ///< StreamReport

/// Of the setpoints, which the bridge writes.
[[nodiscard]] constexpr rt::SharedLayout setpoint_layout(std::uint64_t capacity = 0) noexcept {
  return rt::shared_ring<StreamedSetpoint>(kSetpointContent, kCommandVersion, capacity);
}
/// Of the reports, which it reads.
[[nodiscard]] constexpr rt::SharedLayout stream_report_layout(std::uint64_t capacity = 0) noexcept {
  return rt::shared_blocks(kStreamReportContent, kCommandVersion, sizeof(StreamReport), capacity);
}

}  // namespace driveline::snapshot
