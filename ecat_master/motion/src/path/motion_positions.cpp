// Reaction to implausible actual positions.
#include "driveline/motion/path/motion.hpp"

namespace driveline::motion {

/// Checks the actual positions of all axes before the inputs of this cycle are used. An axis with an implausible
/// position continues without the position loop of the master, from this cycle on.
void Motion::judge_positions(std::int64_t cycle) noexcept {
  for (std::size_t i = 0; i < axes_.size(); ++i) {
    auto& watch = each_[i].position_watch;
    if (unavailable(i)) {
      forget_place(i);
      continue;
    }
    if (!each_[i].exchanged) {
      axes_[i].coast_on(seconds(1));
      continue;
    }
    const bool driven = axes_[i].enabled() && (powered() || phase_ == MotionPhase::kEnabling);
    const auto finding = watch.judge(cycle, axes_[i].inputs().position, setpoints_[i], driven, exchange_took_);
    each_[i].coast_watch.update(watch.held(), axes_[i].inputs().velocity);
    axes_[i].hold_at(watch.held(), each_[i].coast_watch.velocity());
    if (finding.kind == PositionFinding::Kind::kNewPlace) {
      setpoints_[i] = {watch.held(), 0.0, 0.0};
      supply_from_rest(i);
      each_[i].arrest = {};
    }
    // During a stop the finding is already known, or does not matter any more.
    if (finding && phase_ != MotionPhase::kStopping) stop_for(finding, i, cycle);
  }
}

/// The actual position is unknown from now on.
void Motion::forget_place(std::size_t axis) noexcept {
  each_[axis].position_watch.forget();
  each_[axis].coast_watch.forget();
}

void Motion::stop_for(const PositionFinding& finding, std::size_t axis, std::int64_t cycle) noexcept {
  using Cause = MotionFailure::Cause;
  // The velocity that the loop added is braked together with that of the setpoint.
  setpoints_[axis].velocity += axes_[axis].disable_position_loop();
  const auto& inputs = axes_[axis].inputs();
  const auto cause = finding.kind == PositionFinding::Kind::kLeap ? Cause::kPositionLeap : Cause::kPositionFrozen;
  set_failure({cause, static_cast<std::uint16_t>(axis), inputs.status_word, inputs.error_code, finding});
  if (phase_ == MotionPhase::kEnabling) return abandon_enabling(cycle);
  plan_stop();
  enter(MotionPhase::kStopping, cycle);
}

}  // namespace driveline::motion
