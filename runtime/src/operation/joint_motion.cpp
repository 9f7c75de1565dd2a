#include "operation/joint_motion.hpp"

#include "driveline/runtime/event.hpp"

#include <utility>

namespace driveline::runtime {

using motion::AxisPresence;
using motion::MotionFailure;
using motion::MotionPhase;

JointMotion::JointMotion(std::unique_ptr<motion::Motion> motion, const LineConfig& config, AxisRequests& axis_requests,
                         std::string owner)
    : motion_(std::move(motion)),
      config_(config),
      axis_requests_(axis_requests),
      owner_(std::move(owner)),
      presences_(motion_->axes().size()) {}

void JointMotion::start() {
  axis_requests_.occupy(owner_);
  motion_->request_start();
}

void JointMotion::request_stop() {
  axis_requests_.close();
  motion_->request_stop();
}

/// Returns the next presence to report for an axis that changes from `before` to `now`. An axis that returns while the
/// others have power reports every step, even if several steps happened since the last poll().
AxisPresence JointMotion::next_presence(AxisPresence before, AxisPresence now) const {
  if (!had_power_) return now;
  if (before == AxisPresence::kMissing && now != AxisPresence::kEnabling) return AxisPresence::kEnabling;
  if (before == AxisPresence::kEnabling && now == AxisPresence::kPresent) return AxisPresence::kReturning;
  return now;
}

void JointMotion::poll(const Tell& tell) {
  for (std::size_t i = 0; i < presences_.size(); ++i) {
    const auto now = motion_->presence(i);
    while (presences_[i] != now) {
      presences_[i] = next_presence(presences_[i], now);
      const auto& axis = motion_->axes()[i].config();
      tell(events::AxisPresenceChanged{axis.name, presences_[i], axis.on_loss},
           presences_[i] == AxisPresence::kMissing ? Severity::kFault : Severity::kNotice);
    }
  }
  const auto phase = motion_->phase();
  had_power_ = phase != MotionPhase::kIdle && phase != MotionPhase::kEnabling;
}

std::optional<events::AxesStopped> JointMotion::failure() {
  const auto failure = motion_failure();
  if (!failure) return std::nullopt;
  // The cycle stops the axes shortly before it reports the absence, which must be reported first: wait for the next
  // poll().
  const bool away = failure->cause == MotionFailure::Cause::kMasterAway;
  if (away && !absence_awaited_) {
    absence_awaited_ = true;
    return std::nullopt;
  }
  return events::AxesStopped{events::event_axis(config_.axes[failure->axis]), *failure, lost_limit(config_), {}, {}};
}

std::optional<MotionFailure> JointMotion::motion_failure() const {
  const auto phase = motion_->phase();
  if (phase != MotionPhase::kQuickStop && phase != MotionPhase::kDisabling && phase != MotionPhase::kIdle)
    return std::nullopt;
  const auto failure = motion_->failure();
  if (failure.cause == MotionFailure::Cause::kNone) return std::nullopt;
  return failure;
}

}  // namespace driveline::runtime
