// Touch probe of a single axis: MC_TouchProbe, and homing by the master.
#include <algorithm>
#include <chrono>
#include <cmath>

#include "driveline/motion/single_axis/single_axis.hpp"

namespace driveline::motion {
namespace {

/// Time within which a drive must arm its touch probe.
constexpr std::chrono::milliseconds kProbeReaction{500};

/// Equal ends accept every position.
bool in_window(const AxisRequest& asked, double position) noexcept {
  const auto [low, high] = std::minmax(asked.window_first_si, asked.window_last_si);
  return !(low < high) || (position >= low && position <= high);
}

}  // namespace

AxisError SingleAxis::refusal_of_probe(const AxisRequest& request) const noexcept {
  const bool finite = std::isfinite(request.window_first_si) && std::isfinite(request.window_last_si) &&
                      std::isfinite(request.distance_si);
  if (!finite) return AxisError::kNotFinite;
  for (const double position : {request.window_first_si, request.window_last_si, request.distance_si}) {
    if (!representable(axis_->config(), position)) return AxisError::kTooFar;
  }
  if (!axis_->drive().probe_possible(request.trigger)) return AxisError::kProbeObjects;
  if (request.command == AxisCommand::kTouchProbe) return AxisError::kNone;
  if (!(std::abs(request.distance_si) > 0.0)) return AxisError::kNothingToDo;
  const double end = generator_.state().position + request.distance_si;
  if (!in_range(end)) return AxisError::kOutsideRange;
  return !(override_ > 0.0) || way_to(end, request) ? AxisError::kNone : AxisError::kTooLong;
}

void SingleAxis::take_probe(std::uint64_t id, const AxisRequest& request) noexcept {
  end_probe(RequestPhase::kAborted, AxisError::kNone);
  probe_.request = id;
  probe_.asked = request;
  probe_.since = cycle_;
  axis_->drive().arm_probe(request.trigger);
  table_->set(id, {RequestPhase::kActive, AxisError::kNone});
}

void SingleAxis::take_abort_trigger(std::uint64_t id) noexcept {
  if (probe_.request == 0) return finish(id, RequestPhase::kError, AxisError::kNothingToDo);
  end_probe(RequestPhase::kAborted, AxisError::kNone);
  finish(id, RequestPhase::kDone);
}

void SingleAxis::end_probe(RequestPhase phase, AxisError error) noexcept {
  if (probe_.request == 0) return;
  axis_->drive().disarm_probe();
  finish(probe_.request, phase, error);
}

void SingleAxis::advance_probe() noexcept {
  if (probe_.request == 0) return;
  auto& drive = axis_->drive();
  if (axis_->inputs().state == snapshot::AxisState::kUnavailable)
    return end_probe(RequestPhase::kError, AxisError::kLost);
  if (drive.probe_phase() == DriveLink::ProbePhase::kLatched) {
    const double position = axis_->position_of(drive.probe_value()) + offset_;
    if (in_window(probe_.asked, position)) {
      probe_.recorded = {position, probe_.request};
      return end_probe(RequestPhase::kDone, AxisError::kNone);
    }
    probe_.since = cycle_;
    return drive.arm_probe(probe_.asked.trigger);
  }
  if (drive.probe_phase() < DriveLink::ProbePhase::kArmed && exceeded(probe_.since, kProbeReaction))
    end_probe(RequestPhase::kError, AxisError::kProbe);
}

/// The axis stays at standstill until the touch probe is armed.
void SingleAxis::take_search(std::uint64_t id, const AxisRequest& request) noexcept {
  end_probe(RequestPhase::kAborted, AxisError::kNone);
  probe_.since = cycle_;
  axis_->drive().arm_probe(request.trigger);
  active_ = Move{id, request, generator_.state().position};
  homing_.search = Search::kArming;
  state_ = PlcopenState::kHoming;
  table_->set(id, {RequestPhase::kActive, AxisError::kNone});
  replan();
}

/// Advances the search; the return to the position of the event starts from the present motion.
void SingleAxis::advance_search() noexcept {
  auto& drive = axis_->drive();
  if (homing_.search == Search::kReturning) return;
  if (drive.probe_phase() == DriveLink::ProbePhase::kLatched) {
    homing_.event = axis_->position_of(drive.probe_value());
    drive.disarm_probe();
    homing_.search = Search::kReturning;
    active_->target = homing_.event;
    return replan();
  }
  if (homing_.search == Search::kSearching) return;
  if (drive.probe_phase() == DriveLink::ProbePhase::kArmed) {
    homing_.search = Search::kSearching;
    active_->target = generator_.state().position + active_->request.distance_si;
    return replan();
  }
  if (!exceeded(probe_.since, kProbeReaction)) return;
  finish_move(RequestPhase::kError, AxisError::kProbe);
  state_ = PlcopenState::kStandstill;
}

/// Whether the motion is done.
bool SingleAxis::arrive_in_search() noexcept {
  if (homing_.search == Search::kReturning) return name_home();
  if (homing_.search == Search::kArming) return false;
  finish_move(RequestPhase::kError, AxisError::kNoEdge);
  state_ = PlcopenState::kStandstill;
  return false;
}

/// Names the home position. Returns whether the axis is there: if a compensation starts now, the backlash is still to
/// be taken up.
bool SingleAxis::name_home() noexcept {
  const auto& asked = active_->request;
  const auto homed = axis_->home({homing_.event, setpoint_.position}, asked.target_si, asked.distance_si > 0.0);
  offset_ = asked.target_si - homed.mark;
  homing_.homed = snapshot::AxisHomed::kYes;
  if (!(std::abs(homed.setpoint - setpoint_.position) > 0.0)) return true;
  watch_.forget();
  stay_at(homed.setpoint);
  active_->target = homed.mark;
  homing_.search = Search::kNone;
  replan();
  return false;
}

void SingleAxis::end_search() noexcept {
  if (homing_.search == Search::kNone) return;
  homing_.search = Search::kNone;
  axis_->drive().disarm_probe();
}

}  // namespace driveline::motion
