#include "bus/absence_watch.hpp"

#include <algorithm>
#include <utility>

namespace driveline::runtime {
namespace {

using std::chrono::nanoseconds;

/// An absence explains a fault within this time: watchdogs of drives react with a delay, and this watch detects the
/// fault later still.
constexpr auto kExplains = std::chrono::milliseconds{300};

}  // namespace

AbsenceWatch::AbsenceWatch(Take take, nanoseconds begin) : take_(std::move(take)), begin_(begin) {
  motion::MasterAbsence before;
  while (take_(before)) continue;
}

motion::MasterAbsence AbsenceWatch::in_operation(motion::MasterAbsence absence) const noexcept {
  absence.since -= begin_;
  return absence;
}

AbsenceWatch::Findings AbsenceWatch::poll() {
  Findings findings;
  motion::MasterAbsence absence;
  while (take_(absence)) {
    const auto end = absence.since + absence.duration;
    const bool old = longest_recent_ && end - longest_recent_->since - longest_recent_->duration > kExplains;
    if (!longest_recent_ || old || absence.duration >= longest_recent_->duration) longest_recent_ = absence;
    if (absence.effect == motion::AbsenceEffect::kStopped) {
      findings.stopped = in_operation(absence);
    } else if (reported_ < kReportedSingly || absence.duration > longest_) {
      ++reported_;
      findings.bridged.push_back(in_operation(absence));
    } else {
      ++unreported_;
      unreported_time_ += absence.duration;
      longest_unreported_ = std::max(longest_unreported_, absence.duration);
    }
    longest_ = std::max(longest_, absence.duration);
  }
  return findings;
}

std::optional<events::MasterAwayOften> AbsenceWatch::rest(std::uint64_t dropped) const {
  const auto unreported = unreported_ + dropped;
  if (unreported == 0) return std::nullopt;
  return events::MasterAwayOften{unreported, unreported_time_, longest_unreported_};
}

std::optional<motion::MasterAbsence> AbsenceWatch::cause_of(nanoseconds time) const {
  if (!longest_recent_ || time < longest_recent_->since) return std::nullopt;
  if (time - (longest_recent_->since + longest_recent_->duration) > kExplains) return std::nullopt;
  return in_operation(*longest_recent_);
}

}  // namespace driveline::runtime
