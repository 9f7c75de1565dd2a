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
/// Name of the DDS topic of their answers.
inline constexpr const char* kCommandAnswerTopic = "driveline/v1/command_answer";

/// Commands to the axes of a line over DDS, and their answers (bridge/idl/commands.idl). Nothing is checked here but
/// that no client takes the room of others: everything else is up to the process of the line.
///
/// Belongs to one thread.
class DdsCommands {
 public:
  /// Commands of one participant that are handed on in a second, and at once after a pause: twice of what the process
  /// of the line takes, which tells him that it is too much. What is beyond is dropped.
  static constexpr double kParticipantRate = 400.0;
  static constexpr double kParticipantAtOnce = 200.0;
  /// Participants whose commands are counted.
  static constexpr std::size_t kMostParticipants = 256;

  /// Reads and answers in the domain and the partition of `publisher`, which must outlive it.
  [[nodiscard]] static tl::expected<std::unique_ptr<DdsCommands>, DdsError> create(DdsPublisher& publisher);
  ~DdsCommands();
  DdsCommands(const DdsCommands&) = delete;
  DdsCommands& operator=(const DdsCommands&) = delete;

  /// The next command, with the participant whose it is. False: there is none just now. Looks at so many at most that
  /// it comes back soon, however many there are.
  [[nodiscard]] bool take(snapshot::CommandRecord& record);
  /// Publishes an answer.
  void answer(const snapshot::CommandAnswer& answer);
  /// Refuses a command for which the process of the line has no room; not more often than a hundred times a second.
  void refuse(const snapshot::CommandRecord& record);

 private:
  struct State;
  explicit DdsCommands(std::unique_ptr<State> state);

  std::unique_ptr<State> state_;
};

}  // namespace driveline::bridge
