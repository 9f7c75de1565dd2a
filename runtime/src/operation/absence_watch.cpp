#include "operation/absence_watch.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

namespace driveline::runtime {
namespace {

using std::chrono::nanoseconds;
using Milliseconds = std::chrono::duration<double, std::milli>;

/// An absence explains a fault within this time: watchdogs of drives react with a delay, and the watch finds it later
/// still.
constexpr auto kExplains = std::chrono::milliseconds{300};

}  // namespace

AbsenceWatch::AbsenceWatch(Take take, nanoseconds begin, std::string limit)
    : take_(std::move(take)), begin_(begin), limit_(std::move(limit)) {
  ecat_master::MasterAbsence before;
  while (take_(before)) continue;
}

AbsenceWatch::Findings AbsenceWatch::look() {
  Findings findings;
  ecat_master::MasterAbsence absence;
  while (take_(absence)) {
    const auto end = absence.since + absence.duration;
    const bool old = longest_recent_ && end - longest_recent_->since - longest_recent_->duration > kExplains;
    if (!longest_recent_ || old || absence.duration >= longest_recent_->duration) longest_recent_ = absence;
    if (absence.effect == ecat_master::AbsenceEffect::kStopped) {
      findings.stopped = ecat_master::describe(absence, begin_, limit_);
    } else if (told_ < kToldSingly || absence.duration > longest_) {
      ++told_;
      findings.sentences.push_back(ecat_master::describe(absence, begin_, limit_));
    } else {
      ++untold_;
      untold_time_ += absence.duration;
      longest_untold_ = std::max(longest_untold_, absence.duration);
    }
    longest_ = std::max(longest_, absence.duration);
  }
  return findings;
}

std::string AbsenceWatch::rest(std::uint64_t dropped) const {
  const auto untold = untold_ + dropped;
  if (untold == 0) return {};
  return fmt::format("the master was away {} more times, {:.1f} ms in all, {:.1f} ms at the longest", untold,
                     Milliseconds(untold_time_).count(), Milliseconds(longest_untold_).count());
}

std::string AbsenceWatch::cause_of(nanoseconds time) const {
  if (!longest_recent_ || time < longest_recent_->since) return {};
  if (time - (longest_recent_->since + longest_recent_->duration) > kExplains) return {};
  return fmt::format("; the master had been away for {:.1f} ms at {:.3f} s",
                     Milliseconds(longest_recent_->duration).count(),
                     std::chrono::duration<double>(longest_recent_->since - begin_).count());
}

}  // namespace driveline::runtime
