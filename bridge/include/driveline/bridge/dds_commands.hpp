#pragma once

#include <cstddef>
#include <memory>
#include <tl/expected.hpp>

#include "driveline/bridge/dds_error.hpp"
#include "driveline/snapshot/feed/command_records.hpp"

namespace driveline::bridge {

class DdsPublisher;

/// Name of the DDS topic of commands.
inline constexpr const char* kCommandTopic = "driveline/v1/command";
/// Name of the DDS topic of answers to commands.
inline constexpr const char* kCommandAnswerTopic = "driveline/v1/command_answer";

/// Receives commands to the axes of a line over DDS and sends their answers (bridge/idl/commands.idl). Only the rate
/// per participant is limited, so that no client uses up the capacity of others; all other checks are up to the process
/// of the line.
///
/// Belongs to one thread.
class DdsCommands {
 public:
  /// Commands of a participant that are passed on per second, and at once after a pause: twice the number that the
  /// process of the line accepts, so that it can report the overload to the client. Further commands are dropped.
  static constexpr double kParticipantRate = 400.0;
  static constexpr double kParticipantAtOnce = 200.0;
  /// Number of participants whose commands are counted separately.
  static constexpr std::size_t kMaxParticipants = 256;

  /// Joins the domain and the partition of `publisher`, which must outlive it.
  [[nodiscard]] static tl::expected<std::unique_ptr<DdsCommands>, DdsError> create(DdsPublisher& publisher);
  ~DdsCommands();
  DdsCommands(const DdsCommands&) = delete;
  DdsCommands& operator=(const DdsCommands&) = delete;

  /// Takes the next command, with its participant. Returns false if there is none at present. Checks a limited number
  /// of commands, so that it returns soon however many there are.
  [[nodiscard]] bool take(snapshot::CommandRecord& record);
  /// Publishes an answer.
  void answer(const snapshot::CommandAnswer& answer);
  /// Refuses a command for which the process of the line has no room; sends at most a hundred such answers per second.
  void refuse(const snapshot::CommandRecord& record);

 private:
  struct State;
  explicit DdsCommands(std::unique_ptr<State> state);

  std::unique_ptr<State> state_;
};

}  // namespace driveline::bridge
