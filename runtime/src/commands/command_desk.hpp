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
#include "driveline/runtime/axes/axis_requests.hpp"
#include "driveline/runtime/event/command_events.hpp"
#include "driveline/snapshot/feed/command_records.hpp"

namespace driveline::runtime {

/// Returns the name "dds NAME (participant GUID)" of a client in leases and events.
[[nodiscard]] std::string commander_name(const snapshot::CommandParticipant& participant, std::string_view client);

/// Receives commands over DDS, checks every field, and forwards permitted ones to the AxisRequests as caller "dds NAME
/// (participant GUID)". A client acquires an axis first, names the number of the lease in every command, and renews it.
/// When a lease expires, its axis stops within its limits and is free. A halt and a quick stop need no lease: a stop is
/// always permitted.
///
/// Each command is answered; an accepted one is answered again when it is over. Each command except a renewal also
/// causes an event, as long as there are not too many. Commands beyond the rates below are refused or dropped, and
/// counted. Belongs to one thread, which is not the cycle's.
class CommandDesk {
 public:
  /// Commands per second and client; stops have an equal rate of their own.
  static constexpr double kClientRate = 200.0;
  static constexpr double kClientAtOnce = 100.0;
  /// Commands per second of all clients together; commands beyond it are not answered.
  static constexpr double kTotalRate = 2000.0;
  static constexpr double kTotalAtOnce = 1000.0;
  /// Events per second; those beyond it are summed up once a second.
  static constexpr double kEventRate = 20.0;
  static constexpr double kEventsAtOnce = 100.0;
  /// Most clients at a time; a silent client without pending requests is forgotten when a new one needs its place.
  static constexpr std::size_t kMaxClients = 64;
  /// Most clients per participant, so that it cannot keep others out with many names.
  static constexpr std::ptrdiff_t kMaxNames = 8;
  /// Most pending requests per client.
  static constexpr std::size_t kMaxRequests = 32;

  /// `axis_requests` and `clock`, which measures leases, must outlive it. `lease_timeout`: positive.
  CommandDesk(AxisRequests& axis_requests, const rt::Clock& clock, std::chrono::nanoseconds lease_timeout)
      : axis_requests_(axis_requests), clock_(clock), lease_timeout_(lease_timeout) {}

  /// Processes one command, which is not trusted.
  void take(const snapshot::CommandRecord& record);
  /// Ends leases that were not renewed, and answers requests that are over. Call every few milliseconds.
  void poll();
  /// Renews the leases of a client that is alive by other means than commands.
  void heard(const snapshot::CommandParticipant& participant, std::string_view name);
  /// Reports that all clients have lost their connection: their axes stop, and are free.
  void bridge_lost();
  /// Reports that a bridge has written invalid data.
  void report_invalid_data();

  /// Returns the answers since the last call, oldest first.
  [[nodiscard]] std::vector<snapshot::CommandAnswer> take_answers() { return std::exchange(answers_, {}); }

 private:
  using Key = std::pair<snapshot::CommandParticipant, std::string>;
  /// A request that is not over yet.
  struct Pending {
    snapshot::CommandRecord record;
    std::size_t axis = 0;
    std::uint64_t request = 0;
  };
  struct Client {
    AxisCaller caller;
    std::uint64_t last_number = 0;
    bool begun = false;
    bool commands = false;  ///< has acquired an axis
    std::chrono::nanoseconds heard{};
    RateLimit rate{kClientRate, kClientAtOnce};
    RateLimit stops{kClientRate, kClientAtOnce};
    std::vector<Pending> pending{};
  };
  /// Why a command is refused; empty: it is not.
  using Problem = std::string;

  [[nodiscard]] Client* find_client(const snapshot::CommandRecord& record, std::string_view name);
  /// Forgets a silent client without pending requests: of this participant, or of any (null).
  [[nodiscard]] bool make_room(const snapshot::CommandParticipant* of);
  void judge(Client& client, const snapshot::CommandRecord& record);
  void lease(Client& client, const snapshot::CommandRecord& record, std::size_t axis);
  void request(Client& client, const snapshot::CommandRecord& record, std::size_t axis);
  void poll_client(Client& client);
  void answer(const snapshot::CommandRecord& record, snapshot::CommandResult result, std::string_view text,
              std::uint64_t lease = 0);
  void refuse(const std::string& who, const snapshot::CommandRecord& record, const Problem& problem,
              std::uint64_t lease = 0);
  [[nodiscard]] std::uint64_t held(const Client& client, const snapshot::CommandRecord& record) const;
  void note(events::CommandAnswered facts);
  [[nodiscard]] bool may_tell() { return events_.take(clock_.now()); }

  AxisRequests& axis_requests_;
  const rt::Clock& clock_;
  std::chrono::nanoseconds lease_timeout_;
  std::map<Key, Client> clients_;
  std::vector<snapshot::CommandAnswer> answers_;
  RateLimit total_{kTotalRate, kTotalAtOnce};
  RateLimit total_stops_{kTotalRate, kTotalAtOnce};
  RateLimit events_{kEventRate, kEventsAtOnce};
  events::CommandsSummary summary_;
  std::chrono::nanoseconds next_sum_{};
  bool invalid_data_reported_ = false;  ///< invalid data was reported since the last bridge ended
};

}  // namespace driveline::runtime
