#include "driveline/motion/single_axis/single_axes.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <utility>

#include "single_axis/axis_stops.hpp"

namespace driveline::motion {
namespace {

/// Capacity of the request queue to the cycle.
constexpr std::size_t kRequests = 512;
/// Part of it that is reserved for requests that end a stop, so that other requests cannot block them.
constexpr std::size_t kRoomForReleases = 256;
/// Motions planned per cycle, at some microseconds each: those of requests, and motions that waited for the end of
/// other motions. Those of the lane of stops come in addition, one per axis at most.
constexpr std::size_t kPlansPerCycle = 4;
/// Part of them that is reserved for requests, however many motions wait.
constexpr std::size_t kPlansForRequests = 2;

void check(const Axis& axis) {
  const auto& limits = axis.config().limits;
  const double most_torque = axis.config().max_torque.value_or(1.0);
  const bool usable = std::isfinite(limits.max_velocity) && limits.max_velocity > 0.0 &&
                      std::isfinite(limits.max_acceleration) && limits.max_acceleration > 0.0 &&
                      std::isfinite(most_torque) && most_torque > 0.0;
  if (!usable) throw std::invalid_argument("single axes: the limits of an axis must be positive and finite");
  if (!axis.complete())
    throw std::invalid_argument("single axes: the process data of an axis lack what its mode needs");
}

}  // namespace

struct SingleAxes::Shared {
  std::atomic<PlcopenState> state{PlcopenState::kDisabled};
  std::atomic<AxisError> error{AxisError::kNone};
  std::atomic<std::uint16_t> error_code{0};
  std::atomic<std::int8_t> mode{0};
  std::atomic<double> setpoint{0.0};
  std::atomic<double> position{0.0};
  std::atomic<double> velocity{0.0};
  std::atomic<double> torque{0.0};
  std::atomic<double> override_factor{1.0};
  std::atomic<double> recorded_position{0.0};
  std::atomic<std::uint64_t> recorded_request{0};
  std::atomic<double> position_offset{0.0};
};

struct SingleAxes::Stops {
  explicit Stops(std::size_t axes) : lane(axes) {}
  AxisStopLane lane;
};

SingleAxes::SingleAxes(std::vector<Axis> axes, Settings settings)
    : axes_(std::move(axes)),
      period_s_(std::chrono::duration<double>(settings.period).count()),
      setpoints_(axes_.size()),
      led_(axes_.size()),
      requests_(kRequests),
      stops_(std::make_unique<Stops>(axes_.size())),
      shared_(std::make_unique<Shared[]>(axes_.size())),
      feed_of_(axes_.size()) {
  for (auto& axis : axes_) {
    check(axis);
    single_.emplace_back(axis, table_, settings);
  }
}

SingleAxes::~SingleAxes() = default;

void SingleAxes::add_feed(SetpointFeed& feed, std::vector<std::size_t> axes) {
  if (axes.size() != feed.axis_count())
    throw std::invalid_argument("single axes: the number of axes differs from that of the feed");
  for (std::size_t place = 0; place < axes.size(); ++place) {
    const auto axis = axes[place];
    if (axis >= axes_.size()) throw std::invalid_argument("single axes: a feed for an axis that does not exist");
    if (single_[axis].fed()) throw std::invalid_argument("single axes: an axis has a feed already");
    single_[axis].set_fed(feed.keeps_ranges());
    feed_of_[axis] = {&feed, place};
  }
  std::vector<trajectory::AxisSetpoint> setpoints(axes.size());
  feeds_.push_back({&feed, std::move(axes), std::move(setpoints), std::vector<char>(feed.axis_count())});
}

void SingleAxes::add_gantry(const GantrySettings& settings) {
  const auto [leader, follower] = std::pair{settings.leader, settings.follower};
  if (leader >= axes_.size() || follower >= axes_.size() || leader == follower)
    throw std::invalid_argument("single axes: a gantry needs two existing axes");
  if (gantry_of(leader) || gantry_of(follower) || single_[follower].fed())
    throw std::invalid_argument("single axes: an axis is in a gantry, or has a feed, already");
  gantries_.push_back(std::make_unique<Gantry>(single_[leader], single_[follower], table_, settings, period_s_));
}

std::optional<std::size_t> SingleAxes::gantry_of(std::size_t axis) const noexcept {
  for (std::size_t i = 0; i < gantries_.size(); ++i) {
    if (gantries_[i]->has(axis)) return i;
  }
  return std::nullopt;
}

/// The axis that takes the motions of this one: the leader of its gantry, or itself.
std::size_t SingleAxes::leader_of(std::size_t axis) const noexcept {
  const auto gantry = gantry_of(axis);
  return gantry ? gantries_[*gantry]->settings().leader : axis;
}

/// Hands a request to the axis itself, or to the gantry that it belongs to.
void SingleAxes::hand_on(std::size_t axis, std::uint64_t id, const AxisRequest& request) noexcept {
  const auto gantry = gantry_of(axis);
  gantry ? gantries_[*gantry]->take(axis, id, request) : single_[axis].take(id, request);
}

std::uint64_t SingleAxes::submit(std::size_t axis, const AxisRequest& request) noexcept {
  const std::lock_guard lock(submit_mutex_);
  if (axis >= axes_.size()) return 0;
  if (axis_stop(request)) return submit_stop(axis, request);
  const auto reserved = request.command == AxisCommand::kReleaseStop ? 0 : kRoomForReleases;
  if (requests_.size() >= kRequests - reserved) return 0;
  const auto id = table_.add();
  requests_.try_push({id, static_cast<std::uint32_t>(axis), request});
  return id;
}

/// A stop of the follower of a gantry is one of its leader, so that it overtakes the motions of the pair.
std::uint64_t SingleAxes::submit_stop(std::size_t axis, const AxisRequest& request) noexcept {
  const auto id = table_.add();
  const auto kind = *axis_stop(request);
  const auto replaced = stops_->lane.put(kind == AxisStop::kPowerOff ? axis : leader_of(axis), kind, {id, request});
  table_.set_if_waiting(replaced, {RequestPhase::kAborted, AxisError::kNone});
  return id;
}

std::uint64_t SingleAxes::submit_in_cycle(std::size_t axis, const AxisRequest& request) noexcept {
  if (axis >= axes_.size()) return 0;
  const auto id = table_.add();
  take(axis, id, request);
  return id;
}

void SingleAxes::take(std::size_t axis, std::uint64_t request, const AxisRequest& asked) noexcept {
  const auto& [feed, place] = feed_of_[axis];
  if (feed == nullptr || !feed->take(place, request, asked)) hand_on(axis, request, asked);
}

void SingleAxes::take_stops() noexcept {
  stops_->lane.take_all([this](std::size_t axis, const auto& stop, bool superseded) noexcept {
    if (superseded) return table_.set(stop.id, {RequestPhase::kAborted, AxisError::kNone});
    take(axis, stop.id, stop.request);
  });
}

/// Ends a queued request that a later stop has overtaken, and would have ended in the order of the requests.
bool SingleAxes::overtaken(const NumberedRequest& request) noexcept {
  const auto command = request.request.command;
  const auto weakest = ended_by(command);
  if (!weakest || request.id > stops_->lane.taken_from(request.axis, *weakest)) return false;
  // The release of an earlier stop must not release this one; it has been done all the same.
  const bool release = command == AxisCommand::kReleaseStop;
  table_.set(request.id, {release ? RequestPhase::kDone : RequestPhase::kAborted, AxisError::kNone});
  return true;
}

std::uint64_t SingleAxes::follow_in_cycle(std::size_t axis) noexcept {
  const auto id = table_.add();
  hand_on(axis, id, {.command = AxisCommand::kFollow});
  return id;
}

void SingleAxes::pass_on_in_cycle(std::size_t axis, std::uint64_t request, const AxisRequest& asked) noexcept {
  hand_on(axis, request, asked);
}

AxisReport SingleAxes::axis_report(std::size_t axis) const noexcept {
  const auto& shared = shared_[axis];
  AxisReport report;
  report.state = shared.state.load(std::memory_order_acquire);
  report.error = shared.error.load(std::memory_order_relaxed);
  report.error_code = shared.error_code.load(std::memory_order_relaxed);
  report.mode = shared.mode.load(std::memory_order_relaxed);
  report.setpoint = shared.setpoint.load(std::memory_order_relaxed);
  report.position = shared.position.load(std::memory_order_relaxed);
  report.velocity = shared.velocity.load(std::memory_order_relaxed);
  report.torque = shared.torque.load(std::memory_order_relaxed);
  report.override_factor = shared.override_factor.load(std::memory_order_relaxed);
  report.recorded_request = shared.recorded_request.load(std::memory_order_acquire);
  report.recorded_position = shared.recorded_position.load(std::memory_order_relaxed);
  report.position_offset = shared.position_offset.load(std::memory_order_relaxed);
  return report;
}

// snapshot::SampledPlcopenState has one more value, at the front, for axes that are moved together.
static_assert(static_cast<int>(snapshot::SampledPlcopenState::kDisabled) ==
              static_cast<int>(PlcopenState::kDisabled) + 1);
static_assert(static_cast<int>(snapshot::SampledPlcopenState::kErrorStop) ==
              static_cast<int>(PlcopenState::kErrorStop) + 1);

void SingleAxes::fill(std::size_t axis, snapshot::AxisSample& sample) const noexcept {
  axes_[axis].fill(sample);
  const auto& one = single_[axis];
  sample.plcopen_state = static_cast<snapshot::SampledPlcopenState>(static_cast<std::uint8_t>(one.state()) + 1);
  sample.homed = one.homed();
}

void SingleAxes::publish(std::size_t axis) noexcept {
  const auto& one = single_[axis];
  const auto& inputs = axes_[axis].inputs();
  auto& shared = shared_[axis];
  shared.error.store(one.error(), std::memory_order_relaxed);
  shared.error_code.store(one.error_code(), std::memory_order_relaxed);
  shared.mode.store(inputs.mode, std::memory_order_relaxed);
  shared.setpoint.store(one.setpoint().position + one.position_offset(), std::memory_order_relaxed);
  shared.position.store(inputs.position + one.position_offset(), std::memory_order_relaxed);
  shared.velocity.store(inputs.velocity, std::memory_order_relaxed);
  shared.torque.store(inputs.torque, std::memory_order_relaxed);
  shared.override_factor.store(one.override_factor(), std::memory_order_relaxed);
  shared.recorded_position.store(one.recorded().position, std::memory_order_relaxed);
  shared.recorded_request.store(one.recorded().request, std::memory_order_release);
  shared.position_offset.store(one.position_offset(), std::memory_order_relaxed);
  // Publish the state last, so that a reader of ErrorStop finds its reason.
  shared.state.store(one.state(), std::memory_order_release);
}

void SingleAxes::read_inputs(std::span<const std::byte> image, std::span<const bool> valid,
                             std::span<const bool> operational, std::span<const bool> fresh,
                             std::chrono::nanoseconds took, std::chrono::nanoseconds late) noexcept {
  took_ = took;
  for (std::size_t i = 0; i < axes_.size(); ++i) {
    const auto slave = axes_[i].config().slave;
    // A virtual axis misses no frames.
    if (axes_[i].config().is_virtual()) {
      single_[i].read_inputs(image, true, true, true);
      continue;
    }
    single_[i].read_inputs(image, valid[slave], operational[slave], fresh.empty() || fresh[slave], late);
  }
  for (auto* const signal : signals_) signal->read_inputs(image, valid, fresh);
}

void SingleAxes::update(std::int64_t cycle, std::span<std::byte> image) noexcept {
  for (auto& one : single_) one.begin_cycle(cycle, took_);
  for (auto& gantry : gantries_) gantry->watch();
  take_stops();
  const auto planned = plan_waiting(kPlansPerCycle - std::min(requests_.size(), kPlansForRequests));
  NumberedRequest request;
  for (auto i = planned; i < kPlansPerCycle && requests_.try_pop(request); ++i) {
    if (!overtaken(request)) take(request.axis, request.id, request.request);
    // After the report of the request, so that a reader who finds it taken finds its refusal as well.
    taken_.store(request.id, std::memory_order_release);
  }
  for (auto& each : feeds_) each.feed->begin_cycle();
  advance();
  for (std::size_t i = 0; i < axes_.size(); ++i) {
    setpoints_[i] = single_[i].setpoint();
    single_[i].write_outputs(image);
    publish(i);
  }
}

/// Plans motions that are due, in turn, so that no axis is passed over; returns their number.
std::size_t SingleAxes::plan_waiting(std::size_t most) noexcept {
  std::size_t planned = 0;
  for (std::size_t i = 0; i < single_.size() && planned < most; ++i) {
    auto& one = single_[turn_];
    turn_ = (turn_ + 1) % single_.size();
    if (!one.due()) continue;
    one.plan_in_turn();
    ++planned;
  }
  return planned;
}

/// Advances each axis once: first the axes that follow nothing, then the feeds in the order in which they were added,
/// so that a feed finds the setpoints that its leading axes have in this cycle. The followers of gantries come last.
void SingleAxes::advance() noexcept {
  std::fill(led_.begin(), led_.end(), char{0});
  const auto join = [this](Feed& feed) {
    for (std::size_t i = 0; i < feed.axes.size(); ++i) {
      const auto& one = single_[feed.axes[i]];
      const bool follows = one.follows() && !one.in_formation();
      led_[feed.axes[i]] = static_cast<char>(follows);
      if (follows == (feed.joined[i] != 0)) continue;
      feed.joined[i] = static_cast<char>(follows);
      if (follows) {
        auto from = one.setpoint();
        from.position += one.position_offset();
        feed.feed->join(i, from);
      } else {
        feed.feed->leave(i);
      }
    }
  };
  for (auto& feed : feeds_) join(feed);
  for (const auto& gantry : gantries_) led_[gantry->settings().follower] = 1;
  for (std::size_t i = 0; i < single_.size(); ++i) {
    if (led_[i] == 0) single_[i].advance(nullptr);
  }
  for (auto& feed : feeds_) advance(feed);
  for (auto& gantry : gantries_) gantry->advance();
}

bool SingleAxes::followed(const Feed& feed) noexcept {
  return std::any_of(feed.joined.begin(), feed.joined.end(), [](char joined) { return joined != 0; });
}

void SingleAxes::advance(Feed& feed) noexcept {
  if (!followed(feed)) return;
  const bool waits = feed.feed->waits() && !all_reached(feed);
  const bool goes_on = waits || feed.feed->next(period_s_, feed.setpoints);
  for (std::size_t i = 0; i < feed.axes.size(); ++i) {
    if (feed.joined[i] == 0) continue;
    single_[feed.axes[i]].advance(goes_on ? &feed.setpoints[i] : nullptr, waits);
  }
}

/// Whether all axes that follow the feed got their last setpoints.
bool SingleAxes::all_reached(const Feed& feed) const noexcept {
  for (std::size_t i = 0; i < feed.axes.size(); ++i) {
    if (feed.joined[i] != 0 && !single_[feed.axes[i]].reached()) return false;
  }
  return true;
}

AbsenceEffect SingleAxes::resume(std::int64_t cycle, std::int64_t missed, std::span<std::byte> image) noexcept {
  auto effect = AbsenceEffect::kNone;
  for (auto* const signal : signals_) signal->skip(missed);
  for (std::size_t i = 0; i < axes_.size(); ++i) {
    effect = std::max(effect, single_[i].resume(cycle, missed));
    setpoints_[i] = single_[i].setpoint();
    single_[i].write_outputs(image);
  }
  return effect;
}

bool SingleAxes::failed() const noexcept {
  return std::any_of(single_.begin(), single_.end(),
                     [](const SingleAxis& one) { return one.state() == PlcopenState::kErrorStop; });
}

}  // namespace driveline::motion
