#include "driveline/motion/group/axis_groups.hpp"

#include <algorithm>
#include <atomic>
#include <condition_variable>
#include <deque>
#include <optional>
#include <stdexcept>
#include <thread>
#include <utility>

#include "axis_group.hpp"
#include "contour_path.hpp"
#include "driveline/trajectory/contour_settings.hpp"
#include "group_planning.hpp"
#include "group_request_table.hpp"
#include "line_path.hpp"
#include "range_check.hpp"

namespace driveline::motion {
namespace {

/// Refusal texts remembered.
constexpr std::size_t kSentences = 64;
/// Time that a path waits at its end for an announced move, s.
constexpr double kGraceSeconds = 0.02;

[[noreturn]] void refuse(const AxisGroupSettings& group, const std::string& reason) {
  throw std::invalid_argument("group '" + group.name + "': " + reason);
}

std::string quoted(const SingleAxes& axes, std::size_t axis) {
  return "axis '" + axes.axes()[axis].config().name + "'";
}

/// Limits of an axis that paths may use.
trajectory::GroupAxisLimits limits_of(const AxisConfig& axis, double jerk_time_s) {
  const double acceleration = AxisGroups::kShareOfAcceleration * axis.limits.max_acceleration;
  return {AxisGroups::kShareOfVelocity * axis.limits.max_velocity, acceleration,
          axis.max_jerk.value_or(acceleration / jerk_time_s)};
}

void check(const SingleAxes& axes, const std::vector<AxisGroupSettings>& groups, std::size_t number) {
  const auto& group = groups[number];
  if (group.name.empty()) throw std::invalid_argument("a group needs a name");
  const auto before = groups.begin() + static_cast<std::ptrdiff_t>(number);
  if (std::any_of(groups.begin(), before, [&group](const auto& other) { return other.name == group.name; }))
    refuse(group, "another group has this name");
  if (group.axes.empty()) refuse(group, "it has no axes");
  if (group.axes.size() > AxisGroups::kMaxAxes)
    refuse(group, "it has " + std::to_string(group.axes.size()) + " axes; " + std::to_string(AxisGroups::kMaxAxes) +
                      " are possible");
  if (!(group.jerk_time_s > 0.0)) refuse(group, "its jerk_time_s must be above 0");
  for (std::size_t i = 0; i < group.axes.size(); ++i) {
    const auto axis = group.axes[i];
    if (axis >= axes.axes().size()) refuse(group, "there is no axis with number " + std::to_string(axis));
    if (std::count(group.axes.begin(), group.axes.begin() + static_cast<std::ptrdiff_t>(i), axis) > 0)
      refuse(group, quoted(axes, axis) + " is listed twice");
    const auto other = std::find_if(groups.begin(), before, [axis](const auto& each) {
      return std::find(each.axes.begin(), each.axes.end(), axis) != each.axes.end();
    });
    if (other != before) refuse(group, quoted(axes, axis) + " is in group '" + other->name + "' already");
    // Check the limits as those along a path, which works for any number of axes.
    trajectory::ContourSettings alone;
    alone.limits[0] = limits_of(axes.axes()[axis].config(), group.jerk_time_s);
    if (const auto wrong = trajectory::check_settings(alone); !wrong.empty())
      refuse(group, quoted(axes, axis) + " has limits with which no path can be planned: " + wrong);
    if (axes.axis(axis).fed()) refuse(group, quoted(axes, axis) + " follows a gear, a cam or a stream already");
  }
}

std::vector<trajectory::GroupAxisLimits> limits_of(const SingleAxes& axes, const AxisGroupSettings& group) {
  std::vector<trajectory::GroupAxisLimits> made;
  for (const auto axis : group.axes) made.push_back(limits_of(axes.axes()[axis].config(), group.jerk_time_s));
  return made;
}

/// Software limits in move positions, which are drive positions plus an offset.
RangeCheck ranges_of(const SingleAxes& axes, const AxisGroupSettings& group, std::span<const double> offsets) {
  std::vector<RangeCheck::Range> ranges;
  for (std::size_t i = 0; i < group.axes.size(); ++i) {
    const auto& axis = axes.axes()[group.axes[i]].config();
    ranges.push_back({axis.name, axis.software_limits});
    if (auto& range = ranges.back().range) *range = {range->min + offsets[i], range->max + offsets[i]};
  }
  return RangeCheck(std::move(ranges));
}

trajectory::ContourSettings contour_settings(const SingleAxes& axes, const AxisGroupSettings& group,
                                             std::chrono::nanoseconds period) {
  trajectory::ContourSettings settings;
  settings.axes = group.axes.size();
  const auto limits = limits_of(axes, group);
  std::copy(limits.begin(), limits.end(), settings.limits.begin());
  settings.period_s = std::chrono::duration<double>(period).count();
  settings.capacity = group.capacity;
  settings.kinematics = group.kinematics;
  settings.tool = group.tool;
  return settings;
}

/// Moves the ranges to the limits of the joints; the returned ranges, for the moves, are unlimited.
RangeCheck limit_joints(trajectory::ContourSettings& settings, const RangeCheck& ranges) {
  std::vector<RangeCheck::Range> none(settings.axes);
  for (std::size_t i = 0; i < settings.axes; ++i) {
    const auto& range = ranges.ranges()[i].range;
    if (!range) continue;
    settings.limits[i].min_position = range->min;
    settings.limits[i].max_position = range->max;
  }
  return RangeCheck(std::move(none));
}

}  // namespace

/// Data shared by all groups. Planning never holds `queue_mutex`, so no submitting thread waits for it; the cycle locks
/// neither.
struct AxisGroups::Shared {
  GroupRequestTable table;
  mutable std::mutex queue_mutex;  ///< serialises submitting threads, for the time of a copy
  std::mutex plan_mutex;           ///< serialises planning threads
  std::deque<std::pair<std::uint64_t, std::string>> sentences;  ///< with queue_mutex

  void keep(std::uint64_t request, std::string reason) {
    const std::lock_guard lock(queue_mutex);
    if (sentences.size() == kSentences) sentences.pop_front();
    sentences.emplace_back(request, std::move(reason));
  }
};

/// Cycle side and planning side of a group.
class AxisGroups::Group {
 public:
  Group(SingleAxes& axes, const AxisGroupSettings& config, std::chrono::nanoseconds period, Shared& shared)
      : cycle(axes, config.axes, shared.table),
        shared_(shared),
        planning_(cycle, shared.table,
                  static_cast<std::uint64_t>(kGraceSeconds / std::chrono::duration<double>(period).count()),
                  make_path(axes, config, period),
                  [&shared](std::uint64_t request, std::string reason) { shared.keep(request, std::move(reason)); }) {
    axes.add_feed(cycle, config.axes);
  }

  /// Number of moves that can be queued.
  [[nodiscard]] std::size_t room() const noexcept {
    return kMaxMoves - std::min(kMaxMoves, moves_.load(std::memory_order_acquire));
  }
  /// Queues all moves and returns the number of the first; 0: there is no room.
  [[nodiscard]] std::uint64_t queue(std::vector<GroupMove> moves) {
    const std::lock_guard lock(shared_.queue_mutex);
    if (room() < moves.size()) return 0;
    const auto first = shared_.table.add(moves.size());
    const auto behind = cycle.submitted();
    for (std::size_t i = 0; i < moves.size(); ++i) queue_.push_back({first + i, behind, std::move(moves[i])});
    moves_.fetch_add(moves.size(), std::memory_order_relaxed);
    return first;
  }
  /// Called by planning, one thread at a time.
  void plan() {
    {
      const std::lock_guard lock(shared_.queue_mutex);
      planning_.add(queue_);
    }
    const auto before = planning_.waiting();
    planning_.plan();
    // After the reports of the moves, so that a reader who finds no waiting move finds all refusals.
    moves_.fetch_sub(before - planning_.waiting(), std::memory_order_release);
  }

  AxisGroup cycle;

 private:
  static GroupPlanning::MakePath make_path(const SingleAxes& axes, const AxisGroupSettings& config,
                                           std::chrono::nanoseconds period) {
    const auto count = config.axes.size();
    const auto ranges_at = [&axes, config](const AxisGroup::Standing& standing) {
      return ranges_of(axes, config, standing.offsets);
    };
    if (count > trajectory::kMaxGroupAxes && (config.kinematics != nullptr || config.outputs != nullptr))
      refuse(config,
             "kinematics and outputs are for groups of up to " + std::to_string(trajectory::kMaxGroupAxes) + " axes");
    if (count > trajectory::kMaxGroupAxes) {
      const double period_s = std::chrono::duration<double>(period).count();
      return [limits = limits_of(axes, config), period_s, count,
              ranges_at](const AxisGroup::Standing& from) -> std::unique_ptr<GroupPath> {
        return std::make_unique<LinePath>(limits, ranges_at(from), period_s, std::span(from.at).first(count),
                                          from.epoch);
      };
    }
    const auto settings = contour_settings(axes, config, period);
    if (const auto wrong = trajectory::check_settings(settings); !wrong.empty()) refuse(config, wrong);
    return [settings, count, ranges_at,
            outputs = config.outputs](const AxisGroup::Standing& from) -> std::unique_ptr<GroupPath> {
      auto ranges = ranges_at(from);
      auto here = settings;
      // Software limits apply to joints, which moves do not contain.
      if (settings.kinematics != nullptr) ranges = limit_joints(here, ranges);
      return std::make_unique<ContourPath>(here, std::move(ranges), std::span(from.at).first(count), from.epoch,
                                           outputs);
    };
  }

  Shared& shared_;
  GroupPlanning planning_;
  std::deque<QueuedMove> queue_{};     ///< moves on their way to planning, with Shared::queue_mutex
  std::atomic<std::size_t> moves_{0};  ///< moves in queue_ and in planning_
};

/// Thread that calls plan() periodically.
class AxisGroups::Worker {
 public:
  Worker(AxisGroups& groups, std::chrono::milliseconds interval)
      : thread_([this, &groups, interval] {
          std::unique_lock lock(mutex_);
          while (!ended_) {
            lock.unlock();
            groups.plan();
            lock.lock();
            wake_.wait_for(lock, interval, [this] { return ended_; });
          }
        }) {}
  ~Worker() {
    {
      const std::lock_guard lock(mutex_);
      ended_ = true;
    }
    wake_.notify_one();
    thread_.join();
  }
  Worker(const Worker&) = delete;
  Worker& operator=(const Worker&) = delete;

 private:
  std::mutex mutex_;
  std::condition_variable wake_;
  bool ended_ = false;
  std::thread thread_;  // last, because the thread uses the other members
};

AxisGroups::AxisGroups(SingleAxes& axes, std::vector<AxisGroupSettings> groups, std::chrono::nanoseconds period)
    : configs_(std::move(groups)), shared_(std::make_unique<Shared>()) {
  for (std::size_t i = 0; i < configs_.size(); ++i) check(axes, configs_, i);
  for (const auto& config : configs_) groups_.push_back(std::make_unique<Group>(axes, config, period, *shared_));
}

AxisGroups::~AxisGroups() = default;

std::uint64_t AxisGroups::submit(std::size_t group, const GroupRequest& request) {
  if (group >= groups_.size()) return 0;
  const std::lock_guard lock(shared_->queue_mutex);
  return groups_[group]->cycle.submit(request);
}

std::uint64_t AxisGroups::move(std::size_t group, const GroupMove& move) {
  return group < groups_.size() ? groups_[group]->queue({move}) : 0;
}

std::uint64_t AxisGroups::move_path(std::size_t group, std::span<const GroupMove> moves) {
  if (group >= groups_.size() || moves.empty()) return 0;
  std::vector<GroupMove> path(moves.begin(), moves.end());
  for (std::size_t i = 0; i < path.size(); ++i) {
    if (i + 1 < path.size()) path[i].continues = true;
    if (i > 0 && path[i].buffer == GroupBuffer::kAborting) path[i].buffer = GroupBuffer::kBlending;
  }
  return groups_[group]->queue(std::move(path));
}

std::size_t AxisGroups::room(std::size_t group) const {
  return group < groups_.size() ? groups_[group]->room() : 0;
}

GroupRequestReport AxisGroups::report(std::uint64_t request) const noexcept {
  return shared_->table.report(request);
}

std::string AxisGroups::refusal(std::uint64_t request) const {
  const std::lock_guard lock(shared_->queue_mutex);
  const auto found = std::find_if(shared_->sentences.begin(), shared_->sentences.end(),
                                  [request](const auto& each) { return each.first == request; });
  return found == shared_->sentences.end() ? std::string{} : found->second;
}

GroupReport AxisGroups::group_report(std::size_t group) const noexcept {
  return group < groups_.size() ? groups_[group]->cycle.report() : GroupReport{};
}

void AxisGroups::plan() {
  const std::lock_guard lock(shared_->plan_mutex);
  for (auto& group : groups_) group->plan();
}

void AxisGroups::start_planning(std::chrono::milliseconds interval) {
  worker_ = std::make_unique<Worker>(*this, interval);
}

void AxisGroups::stop_planning() {
  worker_.reset();
}

}  // namespace driveline::motion
