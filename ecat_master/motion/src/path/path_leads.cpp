#include "driveline/motion/path/path_leads.hpp"

#include <algorithm>
#include <cmath>

namespace driveline::motion {

PathLeads::PathLeads(std::span<const double> dead_times) {
  for (const double dead_time : dead_times) longest_ = std::max(longest_, dead_time);
  for (const double dead_time : dead_times) delays_.push_back(longest_ - std::max(dead_time, 0.0));
  const auto of_axes = delays_;
  std::sort(delays_.begin(), delays_.end());
  delays_.erase(std::unique(delays_.begin(), delays_.end()), delays_.end());
  for (const double delay : of_axes) {
    const auto found = std::lower_bound(delays_.begin(), delays_.end(), delay);
    delay_of_.push_back(static_cast<std::size_t>(found - delays_.begin()));
  }
  moments_.resize(static_cast<std::size_t>(longest_) + 2);
}

void PathLeads::rewind() noexcept {
  std::fill(moments_.begin(), moments_.end(), trajectory::PathMoment{0.0, 0.0, 0.0});
}

void PathLeads::push(const trajectory::PathMoment& moment) noexcept {
  newest_ = newest_ + 1 == moments_.size() ? 0 : newest_ + 1;
  moments_[newest_] = moment;
}

trajectory::PathMoment PathLeads::at(double behind_cycles) const noexcept {
  const double whole = std::floor(behind_cycles);
  const double part = behind_cycles - whole;
  const auto ago = [this](std::size_t cycles) -> const trajectory::PathMoment& {
    return moments_[newest_ >= cycles ? newest_ - cycles : newest_ + moments_.size() - cycles];
  };
  const auto& later = ago(static_cast<std::size_t>(whole));
  if (part <= 0.0) return later;
  const auto& earlier = ago(static_cast<std::size_t>(whole) + 1);
  const auto between = [part](double newer, double older) { return newer + part * (older - newer); };
  return {between(later.path_s, earlier.path_s), between(later.rate, earlier.rate),
          between(later.slope, earlier.slope)};
}

}  // namespace driveline::motion
