#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "driveline/rt/shared_ring.hpp"
#include "driveline/snapshot/feed/feed_records.hpp"

/// Commands received over DDS, as the bridge hands them to the process that holds the line, and the answers of that
/// process. The bridge forwards data from the network: the content of a command must be checked like any other input.
namespace driveline::snapshot {

/// Most commands that may wait; the bridge refuses a command when there is no room for it.
inline constexpr std::uint64_t kCommandRoom = 1024;
/// Number of answers stored for a slow bridge.
inline constexpr std::uint64_t kAnswerRoom = 1024;

/// Sender of a message: the prefix of the GUID of its DDS participant (RTPS 2.2, 8.2.4.2), which the bridge takes from
/// DDS and not from the message, and 4 zeros.
using CommandParticipant = std::array<std::uint8_t, 16>;

/// Kind of a command, by its number in the IDL.
enum class CommandKind : std::uint32_t {
  kAcquire,       ///< acquires the lease of the axis
  kRenew,         ///< renews all leases of the client
  kRelease,       ///< stops the axis and releases its lease
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
  CommandParticipant participant{};  ///< sender of the command
  FeedText<63> client;               ///< client name as given by the client
  FeedText<31> axis;                 ///< name of the axis
  std::uint64_t number = 0;          ///< number of the command, assigned by the client
  std::uint64_t lease = 0;           ///< lease of the axis; 0: none
  std::uint32_t kind = 0;            ///< CommandKind, or any other value
  std::uint32_t reserved = 0;        ///< 0
  double target = 0;                 ///< rad, m, rad/s or m/s
  double velocity = 0;               ///< AxisRequest::velocity_si
  double acceleration = 0;           ///< AxisRequest::acceleration_si
  double deceleration = 0;           ///< AxisRequest::deceleration_si
  double jerk = 0;                   ///< AxisRequest::jerk_si
};

/// Outcome of a command, by its number in the IDL.
enum class CommandResult : std::uint32_t {
  kAccepted,  ///< the command is in progress; another answer follows
  kDone,      ///< the command has been completed
  kRefused,   ///< the command was refused and had no effect
  kAborted,   ///< the command was accepted but not completed
};

/// An answer.
struct CommandAnswer {
  CommandParticipant participant{};  ///< CommandRecord::participant
  FeedText<63> client;               ///< CommandRecord::client
  FeedText<31> axis;                 ///< CommandRecord::axis
  std::uint64_t number = 0;          ///< CommandRecord::number
  std::uint64_t lease = 0;           ///< lease of the axis if the client holds it; else 0
  std::uint32_t result = 0;          ///< CommandResult
  std::uint32_t reserved = 0;        ///< 0
  FeedText<255> text;                ///< one sentence, or empty
};

/// Content numbers of the regions, and the version of both.
inline constexpr std::uint32_t kCommandVersion = 1;
inline constexpr std::uint32_t kCommandContent = 0x434D'4E44;        ///< CommandRecord
inline constexpr std::uint32_t kCommandAnswerContent = 0x434D'414E;  ///< CommandAnswer

/// Layout of the region of the commands, which the bridge writes.
[[nodiscard]] constexpr rt::SharedLayout command_layout(std::uint64_t capacity = 0) noexcept {
  return rt::shared_ring<CommandRecord>(kCommandContent, kCommandVersion, capacity);
}
/// Layout of the region of the answers, which the bridge reads.
[[nodiscard]] constexpr rt::SharedLayout command_answer_layout(std::uint64_t capacity = 0) noexcept {
  return rt::shared_blocks(kCommandAnswerContent, kCommandVersion, sizeof(CommandAnswer), capacity);
}

}  // namespace driveline::snapshot
