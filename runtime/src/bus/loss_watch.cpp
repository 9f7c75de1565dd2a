#include "bus/loss_watch.hpp"

#include <utility>

#include "driveline/runtime/event.hpp"

namespace driveline::runtime {

using motion::LossPolicy;
using std::chrono::nanoseconds;

LossWatch::LossWatch(Parts parts, std::vector<Losable> slaves, LineMotion::Tell tell)
    : parts_(std::move(parts)),
      slaves_(std::move(slaves)),
      tell_(std::move(tell)),
      absences_(parts_.take_absence, parts_.clock->now()),
      away_since_(slaves_.size()) {}

bool LossWatch::expendable(std::size_t slave) const {
  return parts_.config->recovery.axes != LossPolicy::kStop || slaves_[slave].hot_connect;
}

bool LossWatch::master_was_there() {
  const auto limit = lost_limit(*parts_.config);
  const auto found = absences_.poll();
  for (const auto& absence : found.bridged) tell_(events::MasterAway{absence, limit}, Severity::kNotice);
  if (!found.stopped) return true;
  const bool over = parts_.config->recovery.axes == LossPolicy::kStop;
  tell_(events::MasterAway{*found.stopped, limit}, over ? Severity::kFailure : Severity::kFault);
  return !over;
}

bool LossWatch::motion_goes_on() {
  if (parts_.motion == nullptr) return true;
  auto stopped = parts_.motion->failure();
  if (!stopped) return true;
  if (stopped->failure.cause == motion::MotionFailure::Cause::kAxisFault) {
    stopped->after = absences_.cause_of(parts_.clock->now());
  }
  tell_(std::move(*stopped), Severity::kFailure);
  return false;
}

std::optional<std::size_t> LossWatch::missed_too_long() const {
  const auto timeout = parts_.config->recovery.give_up;
  if (timeout.count() == 0) return std::nullopt;
  const auto now = parts_.clock->now();
  for (std::size_t i = 0; i < away_since_.size(); ++i) {
    if (is_missed(i) && now - away_since_[i] >= timeout) return i;
  }
  return std::nullopt;
}

std::optional<std::size_t> LossWatch::first_missed() const {
  for (std::size_t i = 0; i < away_since_.size(); ++i) {
    if (is_missed(i)) return i;
  }
  return std::nullopt;
}

void LossWatch::tell_rest(std::uint64_t dropped) {
  if (const auto rest = absences_.rest(dropped)) tell_(*rest, Severity::kNotice);
}

}  // namespace driveline::runtime
