#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "driveline/rt/shared_ring.hpp"
#include "driveline/snapshot/feed/feed_records.hpp"

/// Commands that come over DDS, as the bridge hands them to the process that holds the line, and its answers. The
/// bridge reads what a network sends: whatever stands in a command is to be checked like any other input.
namespace driveline::snapshot {

/// Commands that wait at most; those that find no room are refused by the bridge.
inline constexpr std::uint64_t kCommandRoom = 1024;
/// Answers that are kept for a bridge that is slow.
inline constexpr std::uint64_t kAnswerRoom = 1024;

/// Who has sent something: the prefix of the GUID of his DDS participant (RTPS 2.2, 8.2.4.2), which the bridge takes
/// from DDS and not from the message, and 4 zeros.
using CommandParticipant = std::array<std::uint8_t, 16>;

/// What is asked, by its number in the IDL.
enum class CommandKind : std::uint32_t {
  kAcquire,       ///< the lease of the axis
  kRenew,         ///< all leases of the client go on
  kRelease,       ///< the axis stops, and is free
  kEnable,        ///< AxisCommand::kPower, on
  kDisable,       ///< AxisCommand::kPower, off
  kReset,         ///< AxisCommand::kReset
  kHalt,          ///< AxisCommand::kHalt; needs no lease
  kQuickStop,     ///< AxisCommand::kStop; needs no lease
  kReleaseStop,   ///< AxisCommand::kReleaseStop
  kJog,           ///< AxisCommand::kMoveVelocity
  kMoveAbsolute,  ///< AxisCommand::kMoveAbsolute
  kMoveRelative,  ///< AxisCommand::kMoveRelative
};

/// A command.
struct CommandRecord {
  CommandParticipant participant{};  ///< whose it is
  FeedText<63> client;               ///< as he calls himself
  FeedText<31> axis;                 ///< name of the axis
  std::uint64_t number = 0;          ///< of the command, by the client
  std::uint64_t lease = 0;           ///< of the axis; 0: none
  std::uint32_t kind = 0;            ///< CommandKind, or anything else
  std::uint32_t reserved = 0;        ///< 0
  double target = 0;                 ///< rad, m, rad/s or m/s
  double velocity = 0;               ///< AxisRequest::velocity
  double acceleration = 0;           ///< AxisRequest::acceleration
  double deceleration = 0;           ///< AxisRequest::deceleration
  double jerk = 0;                   ///< AxisRequest::jerk
};

/// What has become of a command, by its number in the IDL.
enum class CommandResult : std::uint32_t {
  kAccepted,  ///< it is under way; another answer follows
  kDone,      ///< it is done
  kRefused,   ///< nothing was done
  kAborted,   ///< it was accepted, and has not come to its end
};

/// An answer.
struct CommandAnswer {
  CommandParticipant participant{};  ///< CommandRecord::participant
  FeedText<63> client;               ///< CommandRecord::client
  FeedText<31> axis;                 ///< CommandRecord::axis
  std::uint64_t number = 0;          ///< CommandRecord::number
  std::uint64_t lease = 0;           ///< of the axis, if it is the client's; 0: it is not
  std::uint32_t result = 0;          ///< CommandResult
  std::uint32_t reserved = 0;        ///< 0
  FeedText<255> text;                ///< one sentence; empty where there is nothing to say
};

/// Numbers of the regions' contents, and the version of both.
inline constexpr std::uint32_t kCommandVersion = 1;
inline constexpr std::uint32_t kCommandContent = 0x434D'4E44;        ///< CommandRecord
inline constexpr std::uint32_t kCommandAnswerContent = 0x434D'414E;  ///< CommandAnswer

/// Of the commands, which the bridge writes.
[[nodiscard]] constexpr rt::SharedLayout command_layout(std::uint64_t capacity = 0) noexcept {
  return rt::shared_ring<CommandRecord>(kCommandContent, kCommandVersion, capacity);
}
/// Of the answers, which it reads.
[[nodiscard]] constexpr rt::SharedLayout command_answer_layout(std::uint64_t capacity = 0) noexcept {
  return rt::shared_blocks(kCommandAnswerContent, kCommandVersion, sizeof(CommandAnswer), capacity);
}

}  // namespace driveline::snapshot
