#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "commands/rate_limit.hpp"
#include "driveline/rt/clock.hpp"
#include "driveline/runtime/axes/axis_door.hpp"
#include "driveline/snapshot/feed/command_records.hpp"

namespace driveline::runtime {

/// The caller "dds NAME (participant GUID)", as leases and events have him.
[[nodiscard]] std::string commander_name(const snapshot::CommandParticipant& participant, std::string_view client);

/// Takes commands that come over DDS, checks everything in them, and hands what may be done to the door of the axes,
/// as a caller "dds NAME (participant GUID)". Who commands an axis acquires it first, names the number of the lease
/// with every command, and renews it; an axis whose lease runs out stops within its limits, and is free. A halt and a
/// quick stop need no lease: a stop is always allowed.
///
/// Each command has an answer, and those that were accepted another one when they are over. Each has an event, too, as
/// long as there are not too many; renewals have none. What is beyond the rates below is refused or dropped, and
/// counted. Belongs to one thread, which is not the cycle's.
class CommandDesk {
 public:
  /// Commands of one client; as many stops have room beside them.
  static constexpr double kClientRate = 200.0;
  static constexpr double kClientAtOnce = 100.0;
  /// Of all clients together: what is beyond has no answer.
  static constexpr double kTotalRate = 2000.0;
  static constexpr double kTotalAtOnce = 1000.0;
  /// Events; what is beyond is summed up once a second.
  static constexpr double kEventRate = 20.0;
  static constexpr double kEventsAtOnce = 100.0;
  /// Clients at a time; one that has nothing and is silent makes room.
  static constexpr std::size_t kMostClients = 64;
  /// Of them, of one participant: it is not to keep others out by its many names.
  static constexpr std::ptrdiff_t kMostNames = 8;
  /// Requests under way, of one client.
  static constexpr std::size_t kMostRequests = 32;

  /// `door` and `clock`, by which leases run out, must outlive it. `lease_timeout`: positive.
  CommandDesk(AxisDoor& door, const rt::Clock& clock, std::chrono::nanoseconds lease_timeout)
      : door_(door), clock_(clock), lease_timeout_(lease_timeout) {}

  /// One command, of which nothing is believed.
  void take(const snapshot::CommandRecord& record);
  /// Ends leases that were not renewed, and answers what is over. To be called every few milliseconds.
  void look();
  /// A client is there, and says so by other means than commands: his leases go on.
  void heard(const snapshot::CommandParticipant& participant, std::string_view name);
  /// All clients have lost their way here: their axes stop, and are free.
  void bridge_lost();
  /// What a bridge has written cannot be.
  void unbelieved();

  /// Answers since the last call, in order.
  [[nodiscard]] std::vector<snapshot::CommandAnswer> take_answers() { return std::exchange(answers_, {}); }

 private:
  using Key = std::pair<snapshot::CommandParticipant, std::string>;
  /// A request that the axis has not done yet.
  struct Pending {
    snapshot::CommandRecord record;
    std::size_t axis = 0;
    std::uint64_t request = 0;
  };
  struct Client {
    AxisCaller caller;
    std::uint64_t last_number = 0;
    bool begun = false;
    bool commands = false;  ///< he has had an axis
    std::chrono::nanoseconds heard{};
    RateLimit rate{kClientRate, kClientAtOnce};
    RateLimit stops{kClientRate, kClientAtOnce};
    std::vector<Pending> pending{};
  };
  /// What was wrong with a command; empty: nothing.
  using Problem = std::string;

  [[nodiscard]] Client* find_client(const snapshot::CommandRecord& record, std::string_view name);
  /// Forgets a client that has nothing and is silent; of one participant, or of all (null).
  [[nodiscard]] bool make_room(const snapshot::CommandParticipant* of);
  void judge(Client& client, const snapshot::CommandRecord& record);
  void lease(Client& client, const snapshot::CommandRecord& record, std::size_t axis);
  void request(Client& client, const snapshot::CommandRecord& record, std::size_t axis);
  void look_at(Client& client);
  void answer(const snapshot::CommandRecord& record, snapshot::CommandResult result, std::string_view text,
              std::uint64_t lease = 0);
  void refuse(const std::string& who, const snapshot::CommandRecord& record, const Problem& problem,
              std::uint64_t lease = 0);
  [[nodiscard]] std::uint64_t held(const Client& client, const snapshot::CommandRecord& record) const;
  void note(events::CommandAnswered facts);
  [[nodiscard]] bool may_tell() { return events_.take(clock_.now()); }

  AxisDoor& door_;
  const rt::Clock& clock_;
  std::chrono::nanoseconds lease_timeout_;
  std::map<Key, Client> clients_;
  std::vector<snapshot::CommandAnswer> answers_;
  RateLimit total_{kTotalRate, kTotalAtOnce};
  RateLimit total_stops_{kTotalRate, kTotalAtOnce};
  RateLimit events_{kEventRate, kEventsAtOnce};
  events::CommandsUntold untold_;
  std::chrono::nanoseconds next_sum_{};
  bool told_nonsense_ = false;  ///< since the last bridge has ended
};

}  // namespace driveline::runtime
