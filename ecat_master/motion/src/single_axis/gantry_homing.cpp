// Common homing of a gantry: one motion finds the marks of both axes, and the follower is squared by their difference.
#include <cmath>

#include "driveline/motion/single_axis/gantry.hpp"

namespace driveline::motion {

AxisError Gantry::refusal_of_homing(const AxisRequest& request) const noexcept {
  if (phase_ != Phase::kFormed) return AxisError::kNotEnabled;
  if (leader_.state() != PlcopenState::kStandstill || !offset_.finished()) return AxisError::kNotAtRest;
  if (!std::isfinite(request.distance_si) || !std::isfinite(request.target_si)) return AxisError::kNotFinite;
  const auto& config = leader_.axis().config();
  if (!representable(config, request.distance_si) || !representable(config, request.target_si))
    return AxisError::kTooFar;
  if (!(std::abs(request.distance_si) > 0.0)) return AxisError::kNothingToDo;
  for (const auto* const axis : {&leader_, &follower_}) {
    if (!axis->axis().drive().probe_possible(request.trigger)) return AxisError::kProbeObjects;
  }
  return AxisError::kNone;
}

void Gantry::take_homing(std::uint64_t id, const AxisRequest& request) noexcept {
  if (const auto error = refusal_of_homing(request); error != AxisError::kNone)
    return finish(id, RequestPhase::kError, error);
  home_request_ = id;
  homing_request_ = request;
  table_.set(id, {RequestPhase::kActive, AxisError::kNone});
  AxisRequest probe;
  probe.command = AxisCommand::kTouchProbe;
  probe.trigger = request.trigger;
  ask_both(probes_, probe);
  homing_ = Homing::kArming;
}

void Gantry::end_homing(RequestPhase phase, AxisError error) noexcept {
  if (homing_ == Homing::kNone) return;
  if (homing_ < Homing::kReturning) {
    AxisRequest abort;
    abort.command = AxisCommand::kAbortTrigger;
    static_cast<void>(ask(leader_, abort));
    static_cast<void>(ask(follower_, abort));
  }
  homing_ = Homing::kNone;
  finish(home_request_, phase, error);
}

/// Sends requests to both axes as to any axis, so that their own limits and failure reactions apply.
void Gantry::advance_homing() noexcept {
  const auto lost = [this] { return over(probes_) && error_of(probes_) != AxisError::kNone; };
  switch (homing_) {
    case Homing::kNone:
      return;
    case Homing::kArming: {
      if (lost()) return end_homing(RequestPhase::kError, error_of(probes_));
      const auto armed = DriveLink::ProbePhase::kArmed;
      if (leader_.axis().drive().probe_phase() < armed || follower_.axis().drive().probe_phase() < armed) return;
      auto way = homing_request_;
      way.command = AxisCommand::kMoveRelative;
      way.target_si = way.distance_si;
      search_ = ask(leader_, way);
      homing_ = Homing::kSearching;
      return;
    }
    case Homing::kSearching: {
      const auto report = table_.report(search_);
      if (over(probes_) && error_of(probes_) == AxisError::kNone) {
        auto back = homing_request_;
        back.command = AxisCommand::kMoveAbsolute;
        back.target_si = leader_.recorded().position;
        search_ = ask(leader_, back);
        homing_ = Homing::kReturning;
        return;
      }
      if (!report.over() && !lost()) return;
      const bool arrived = report.phase == RequestPhase::kDone && !lost();
      const auto error = arrived ? AxisError::kNoEdge : lost() ? error_of(probes_) : report.error;
      AxisRequest halt;
      halt.command = AxisCommand::kHalt;
      if (!report.over()) static_cast<void>(ask(leader_, halt));
      return end_homing(RequestPhase::kError, error);
    }
    case Homing::kReturning: {
      const auto report = table_.report(search_);
      if (!report.over()) return;
      if (report.phase != RequestPhase::kDone) return end_homing(RequestPhase::kError, report.error);
      name_marks();
      homing_ = Homing::kSquaring;
      return square();
    }
    case Homing::kSquaring:
      if (offset_.finished() && follower_.led_exactly()) end_homing(RequestPhase::kDone);
      return;
  }
}

/// The square offset is the distance between the marks plus the offset of the machine.
void Gantry::name_marks() noexcept {
  const double mark = leader_.recorded().position - leader_.position_offset();
  const double other = follower_.recorded().position - follower_.position_offset();
  square_at_ = other - mark + settings_.offset;
  leader_.set_home(homing_request_.target_si - mark);
  follower_.set_home(homing_request_.target_si - mark - *square_at_);
}

}  // namespace driveline::motion
