#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <mutex>
#include <optional>
#include <string>
#include <string_view>
#include <tl/expected.hpp>
#include <vector>

#include "driveline/ecat_master/single_axis/single_axes.hpp"
#include "driveline/rt/clock.hpp"
#include "driveline/runtime/axes/axis_authority.hpp"
#include "driveline/runtime/axes/coupling_order.hpp"
#include "driveline/runtime/event.hpp"

namespace driveline::runtime {

class LineCouplings;

/// The caller that enables the axes when a line goes into operation.
inline constexpr std::string_view kStartOfRun = "the start of the run";

/// One who asks something of axes.
struct AxisCaller {
  std::string name;  ///< as leases and events have it: "control socket (process 123, user 1000)"
  /// His leases end, and his axes stop, when he has not been heard for so long; none: when he gives them back.
  std::optional<std::chrono::nanoseconds> keep_alive{};
  bool take_over = false;  ///< axes of others, too
  /// His requests need the lease of that number, of acquire(); none: the first one takes the lease.
  std::optional<std::uint64_t> lease{};
  bool quiet = false;  ///< there is no event for each of his requests
};

/// How far a request is.
struct AxisProgress {
  ecat_master::RequestReport report;          ///< phase and reason
  std::optional<AxisRefusal> refusal{};       ///< the reason with its facts; none: it has not failed
  std::optional<double> recorded_position{};  ///< by AxisCommand::kTouchProbe, rad or m as requests count
};

/// What an axis does, and who commands it.
struct AxisStatus {
  events::EventAxis axis;                           ///< name and unit
  std::string owner;                                ///< empty: nobody
  std::optional<ecat_master::AxisReport> report{};  ///< none: the axes are moved together, or the line does not run
  std::optional<CouplingStatus> coupling{};         ///< none: it has no master, or the line does not run
};

/// What an AxisDoor must know of the groups of axes of its line. Called with the door's lock held.
class GroupGuard {
 public:
  virtual ~GroupGuard() = default;
  /// False: the axis is in no enabled group. Otherwise its group comes to rest on its path.
  virtual bool bring_to_rest(std::size_t axis) = 0;
  /// Requests of that caller to groups are not over.
  [[nodiscard]] virtual bool waits_for(const std::string& caller) = 0;

 protected:
  GroupGuard() = default;
  /// Copying is for implementations only.
  GroupGuard(const GroupGuard&) = default;
  GroupGuard& operator=(const GroupGuard&) = default;
};

/// The way of requests to the single axes of a running line: checks what needs no cycle, asks AxisAuthority for the
/// axis, hands the request on, and keeps the events of it all. A stop or a halt needs no lease; while a path, a task or
/// a program moves all axes together it ends the run in order. Nor does a touch probe need one, which moves nothing:
/// one caller at a time has it, and everybody may switch it off.
///
/// A lease is had by the first request and given back by leave(). An axis of another owner is taken over when it has
/// taken the request: what is refused leaves the axis, and its motion, to that owner. Any thread but the cycle's; a
/// lock inside.
class AxisDoor {
 public:
  /// `stop_all` ends the run in order. `axes` and `clock`, which measures keep-alive times, must outlive it.
  AxisDoor(const std::vector<ecat_master::AxisConfig>& axes, const rt::Clock& clock, std::function<void()> stop_all);

  // The side of the line.
  /// Requests are taken from now on, until close(). `axes` must outlive that.
  void open(ecat_master::SingleAxes& axes);
  /// The same with gears and cams; `couplings` must outlive that, too. Before open().
  void attach(LineCouplings& couplings);
  /// `owner` moves all axes, until close().
  void occupy(const std::string& owner);
  /// The line goes out of operation.
  void close();
  /// What is known of groups; null: there are none. It must outlive the door, or take itself back.
  void guard(GroupGuard* groups);
  /// Adds an event of those who ask.
  void note(EventFacts facts);
  /// Events since the last call, in order.
  [[nodiscard]] std::vector<EventFacts> take_events();

  // The side of who asks.
  /// Number of the axis with that name.
  [[nodiscard]] std::optional<std::size_t> find(std::string_view name) const noexcept;
  /// Configuration of the axes, in the order of the line description.
  [[nodiscard]] const std::vector<ecat_master::AxisConfig>& axes() const noexcept { return axes_; }
  /// Hands on a request: the number to ask progress() with, 0 where it has stopped all axes and nothing remains to ask.
  [[nodiscard]] tl::expected<std::uint64_t, AxisRefusal> submit(const AxisCaller& caller, std::size_t axis,
                                                                const ecat_master::AxisRequest& request);
  /// The same for an order about the gear or cam of an axis: the lease of the slave is what it needs.
  [[nodiscard]] tl::expected<std::uint64_t, AxisRefusal> submit(const AxisCaller& caller, std::size_t axis,
                                                                const CouplingOrder& order);
  /// Takes the axis for a caller who names its lease with every request. The number of the lease.
  [[nodiscard]] tl::expected<std::uint64_t, AxisRefusal> acquire(const AxisCaller& caller, std::size_t axis);
  /// Whether the axis is the caller's, by the lease that he names.
  [[nodiscard]] bool holds(const AxisCaller& caller, std::size_t axis) const;
  /// How far a request to that axis is.
  [[nodiscard]] AxisProgress progress(std::size_t axis, std::uint64_t request) const;
  /// The axis as of now.
  [[nodiscard]] AxisStatus status(std::size_t axis) const;
  /// The caller is there.
  void keep_alive(const AxisCaller& caller);
  /// The caller goes. `stop`: axes that his requests move stop, and he has no lease any more; otherwise his leases last
  /// as long as his requests.
  void leave(const std::string& caller, bool stop);
  /// Gives one axis back, after it has been told to stop; nothing happens if it is another's.
  void give_back(const std::string& caller, std::size_t axis);
  /// Gives one axis back.
  void release(const std::string& caller, std::size_t axis) { authority_.release(axis, caller); }
  /// Ends leases of who is not heard any more; notes requests that have failed. To be called every few milliseconds.
  void watch();
  /// The terms of a lease as this caller wants it, beginning now.
  [[nodiscard]] LeaseTerms terms_of(const AxisCaller& caller) const;
  /// The leases.
  [[nodiscard]] AxisAuthority& authority() noexcept { return authority_; }

 private:
  /// A request that has been handed on and was not over at the last watch().
  struct Pending {
    std::uint64_t number = 0;
    std::size_t axis = 0;
    AxisCaller caller;
    ecat_master::AxisRequest request;
    bool takes_over = false;  ///< the axis from another owner, as soon as the axis has taken the request
    bool gone = false;        ///< the caller has left before that
    std::string coupling{};   ///< what, of a CouplingOrder
  };
  /// How a request comes to its axis.
  enum class Way : std::uint8_t {
    kOpen,       ///< the caller commands the axis already, or the request asks for no lease
    kNewLease,   ///< nobody commanded the axis before
    kTakesOver,  ///< another one does until the axis has taken the request
  };
  using Submitted = tl::expected<std::uint64_t, AxisRefusal>;
  using Permission = tl::expected<Way, AxisRefusal>;

  [[nodiscard]] Submitted try_to_submit(const AxisCaller& caller, std::size_t axis,
                                        const ecat_master::AxisRequest& request);
  [[nodiscard]] Submitted try_to_couple(const AxisCaller& caller, std::size_t axis, const CouplingOrder& order);
  [[nodiscard]] Permission permission(const AxisCaller& caller, std::size_t axis, ecat_master::AxisCommand command);
  [[nodiscard]] Permission probe_permission(const AxisCaller& caller, std::size_t axis,
                                            ecat_master::AxisCommand command) const;
  [[nodiscard]] bool takes_over(const AxisCaller& caller, std::size_t axis) const;
  [[nodiscard]] AxisProgress progress_of(std::size_t axis, std::uint64_t request) const;
  [[nodiscard]] bool is_probe(std::uint64_t request) const;
  void stop_axis(std::size_t axis);
  void drop(Pending& pending);
  void settle_take_overs();
  void watch_leases();
  void watch_requests();
  void watch_leaving();

  const std::vector<ecat_master::AxisConfig>& axes_;
  const rt::Clock& clock_;
  std::function<void()> stop_all_;
  AxisAuthority authority_;
  mutable std::mutex lock_;
  ecat_master::SingleAxes* single_ = nullptr;
  GroupGuard* groups_ = nullptr;
  LineCouplings* couplings_ = nullptr;
  bool together_ = false;
  std::vector<Pending> pending_;
  std::vector<std::string> leaving_;  ///< callers whose leases last as long as their requests
  std::vector<EventFacts> events_;
};

}  // namespace driveline::runtime
