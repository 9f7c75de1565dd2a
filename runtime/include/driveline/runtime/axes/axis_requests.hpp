#pragma once

#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <functional>
#include <limits>
#include <mutex>
#include <optional>
#include <string>
#include <string_view>
#include <tl/expected.hpp>
#include <vector>

#include "driveline/motion/single_axis/single_axes.hpp"
#include "driveline/rt/clock.hpp"
#include "driveline/runtime/axes/axis_authority.hpp"
#include "driveline/runtime/axes/coupling_order.hpp"
#include "driveline/runtime/event/axis_events.hpp"
#include "driveline/runtime/event/event.hpp"

namespace driveline::runtime {

class LineCouplings;

/// Name of the caller that enables the axes when a line goes into operation.
inline constexpr std::string_view kStartOfRun = "the start of the run";

/// A client that sends requests to axes.
struct AxisCaller {
  std::string name;  ///< name in leases and events: "control socket (process 123, user 1000)"
  /// Its leases end, and its axes stop, when it is silent for longer than this; none: they last until they are
  /// released.
  std::optional<std::chrono::nanoseconds> keep_alive{};
  bool take_over = false;  ///< takes axes over from other owners
  /// Number of the lease, from acquire(), that its requests need; none: the first request takes the lease.
  std::optional<std::uint64_t> lease{};
  bool quiet = false;  ///< its requests cause no events
};

/// Progress of a request.
struct AxisProgress {
  motion::RequestReport report;               ///< phase and reason
  std::optional<AxisRefusal> refusal{};       ///< reason with its facts; none: the request has not failed
  std::optional<double> recorded_position{};  ///< recorded by AxisCommand::kTouchProbe, rad or m, as requests count
  bool accepted = false;  ///< the axis has accepted the request, which may still wait for its turn, or be over
};

/// Whether there is nothing more to wait for: the request is over, has reached its velocity or torque, or is unknown.
[[nodiscard]] constexpr bool has_settled(motion::RequestPhase phase) noexcept {
  return motion::is_over(phase) || phase == motion::RequestPhase::kReached || phase == motion::RequestPhase::kUnknown;
}

/// State of an axis, and its owner.
struct AxisStatus {
  events::EventAxis axis;                      ///< name and unit
  std::string owner;                           ///< owner; empty: none
  std::optional<motion::AxisReport> report{};  ///< none: the axes are moved together, or the line is not running
  std::optional<CouplingStatus> coupling{};    ///< none: no coupling, or the line is not running
};

/// What AxisRequests needs to know about the axis groups of its line. Called with the lock of the AxisRequests held.
class GroupGuard {
 public:
  virtual ~GroupGuard() = default;
  /// Brings the enabled group of the axis to rest on its path. Returns false if the axis is in no enabled group.
  virtual bool bring_to_rest(std::size_t axis) = 0;
  /// Whether requests of this caller to groups are still in progress.
  [[nodiscard]] virtual bool waits_for(const std::string& caller) = 0;

 protected:
  GroupGuard() = default;
  /// Copying is for implementations only.
  GroupGuard(const GroupGuard&) = default;
  GroupGuard& operator=(const GroupGuard&) = default;
};

/// Interface for requests to the single axes of a running line. Checks whatever needs no cycle, gets the lease of the
/// axis from AxisAuthority, forwards the request to the axis, and collects the events. A stop or a halt needs no lease;
/// while a path, a task or a program moves all axes together it ends the run in an orderly way. A touch probe moves
/// nothing and needs no lease either: one caller at a time may use it, and any caller may switch it off.
///
/// The first request takes a lease and leave() releases it. An axis of another owner is taken over once it has accepted
/// the request; after a refusal the axis and its motion stay with that owner. Any thread except the cycle's; uses a
/// lock, which is never held while a path is checked or planned, so that a stop does not wait for that.
class AxisRequests {
 public:
  /// Number of a request that has ended the run of all axes. Its progress is done: there is nothing to follow up.
  static constexpr std::uint64_t kRunEnded = std::numeric_limits<std::uint64_t>::max();
  /// Receives the progress of a request that has settled.
  using Settled = std::function<void(const AxisProgress&)>;

  /// `stop_all` ends the run in an orderly way. `axes` and `clock`, which measures keep-alive times, must outlive it.
  AxisRequests(const std::vector<motion::AxisConfig>& axes, const rt::Clock& clock, std::function<void()> stop_all);

  // Called by the line.
  /// Accepts requests from now on, until close(). `axes` must live until then.
  void open(motion::SingleAxes& axes);
  /// Adds gears and cams; `couplings` must live until close(), too. Call before open().
  void attach(LineCouplings& couplings);
  /// Lets `owner` move all axes, until close().
  void occupy(const std::string& owner);
  /// Ends the acceptance of requests: the line goes out of operation.
  void close();
  /// Sets the guard of the axis groups; null: there are none. It must outlive the AxisRequests, or be reset to null
  /// before.
  void guard(GroupGuard* groups);
  /// Adds an event about a client.
  void note(EventFacts facts);
  /// Returns the events since the last call, oldest first.
  [[nodiscard]] std::vector<EventFacts> take_events();

  // Called by clients.
  /// Returns the number of the axis with this name; none: there is no such axis.
  [[nodiscard]] std::optional<std::size_t> find(std::string_view name) const noexcept;
  /// Returns the configuration of the axes, in the order of the line description.
  [[nodiscard]] const std::vector<motion::AxisConfig>& axes() const noexcept { return axes_; }
  /// Forwards a request to the axis. Returns its number for progress(), wait() and when_settled(), never 0; kRunEnded:
  /// all axes are moved together, and the request has ended the run.
  [[nodiscard]] tl::expected<std::uint64_t, AxisRefusal> submit(const AxisCaller& caller, std::size_t axis,
                                                                const motion::AxisRequest& request);
  /// Same for an order about the gear or cam of an axis; needs the lease of the slave axis.
  [[nodiscard]] tl::expected<std::uint64_t, AxisRefusal> submit(const AxisCaller& caller, std::size_t axis,
                                                                const CouplingOrder& order);
  /// Takes the axis for a caller that names its lease with every request. Returns the number of the lease.
  [[nodiscard]] tl::expected<std::uint64_t, AxisRefusal> acquire(const AxisCaller& caller, std::size_t axis);
  /// Whether the caller owns the axis by the lease that it names.
  [[nodiscard]] bool holds(const AxisCaller& caller, std::size_t axis) const;
  /// Returns the progress of a request to this axis.
  [[nodiscard]] AxisProgress progress(std::size_t axis, std::uint64_t request) const;
  /// Waits until a request has settled (has_settled()), the line goes out of operation, or `limit` has passed, measured
  /// in real time, also if the line is on virtual time. Returns the progress as of then. Blocks its thread, which must
  /// not be that of the line: the line would wait for itself.
  [[nodiscard]] AxisProgress wait(std::size_t axis, std::uint64_t request, std::chrono::nanoseconds limit) const;
  /// Calls `settled` once: when the request has settled, or when the line goes out of operation. The call is made on
  /// the thread of the line, within some milliseconds and without a lock, so `settled` may submit requests; it must not
  /// block. It must stay callable until then.
  void when_settled(std::size_t axis, std::uint64_t request, Settled settled);
  /// Returns the present state of the axis.
  [[nodiscard]] AxisStatus status(std::size_t axis) const;
  /// Prolongs the leases of a caller that is alive.
  void keep_alive(const AxisCaller& caller);
  /// Ends the session of a caller. `stop`: axes that its requests move stop, and its leases end; otherwise its leases
  /// last until its requests are over.
  void leave(const std::string& caller, bool stop);
  /// Stops one axis and releases it; does nothing if the caller does not own it.
  void give_back(const std::string& caller, std::size_t axis);
  /// Releases one axis without stopping it.
  void release(const std::string& caller, std::size_t axis) { authority_.release(axis, caller); }
  /// Ends the leases of silent callers, and reports requests that have failed. Call every few milliseconds.
  void watch();
  /// Returns the terms of a lease for this caller, starting now.
  [[nodiscard]] LeaseTerms terms_of(const AxisCaller& caller) const;
  /// Returns the leases.
  [[nodiscard]] AxisAuthority& authority() noexcept { return authority_; }

 private:
  /// A request that was forwarded and not over at the last watch().
  struct Pending {
    std::uint64_t number = 0;
    std::size_t axis = 0;
    AxisCaller caller;
    motion::AxisRequest request;
    bool takes_over = false;   ///< takes the axis from another owner as soon as the axis has accepted the request
    bool caller_left = false;  ///< the caller left before the axis accepted the request
    std::string coupling{};    ///< text of a CouplingOrder, for events
  };
  /// A call that is due when its request has settled.
  struct Call {
    std::size_t axis = 0;
    std::uint64_t request = 0;
    Settled settled;
    AxisProgress progress{};
  };
  /// How a request obtains its axis.
  enum class Access : std::uint8_t {
    kOpen,       ///< the caller already owns the axis, or the request needs no lease
    kNewLease,   ///< the axis had no owner; the request took a new lease
    kTakesOver,  ///< another caller owns the axis until it has accepted the request
  };
  using Submitted = tl::expected<std::uint64_t, AxisRefusal>;
  using Permission = tl::expected<Access, AxisRefusal>;

  [[nodiscard]] Submitted try_to_submit(const AxisCaller& caller, std::size_t axis, const motion::AxisRequest& request);
  [[nodiscard]] Submitted try_to_couple(const AxisCaller& caller, std::size_t axis, const CouplingOrder& order);
  [[nodiscard]] Permission permission(const AxisCaller& caller, std::size_t axis, motion::AxisCommand command);
  [[nodiscard]] Permission probe_permission(const AxisCaller& caller, std::size_t axis,
                                            motion::AxisCommand command) const;
  [[nodiscard]] bool takes_over(const AxisCaller& caller, std::size_t axis) const;
  [[nodiscard]] AxisProgress progress_of(std::size_t axis, std::uint64_t request) const;
  [[nodiscard]] bool accepted(std::size_t axis, std::uint64_t request, motion::RequestPhase phase, bool taken) const;
  [[nodiscard]] bool is_probe(std::uint64_t request) const;
  void stop_axis(std::size_t axis);
  void drop(Pending& pending);
  void settle_take_overs();
  void watch_leases();
  void watch_requests();
  void watch_leaving();
  [[nodiscard]] std::vector<Call> take_due_calls(bool all);
  void call_back(std::vector<Call> calls);

  const std::vector<motion::AxisConfig>& axes_;
  const rt::Clock& clock_;
  std::function<void()> stop_all_;
  AxisAuthority authority_;
  mutable std::mutex lock_;
  mutable std::condition_variable watched_;  ///< notified after each watch(), and when the line goes out of operation
  motion::SingleAxes* single_ = nullptr;
  GroupGuard* groups_ = nullptr;
  LineCouplings* couplings_ = nullptr;
  bool together_ = false;
  std::vector<Pending> pending_;
  std::vector<std::string> leaving_;  ///< callers whose leases last until their requests are over
  std::vector<EventFacts> events_;
  std::vector<Call> calls_;
};

}  // namespace driveline::runtime
