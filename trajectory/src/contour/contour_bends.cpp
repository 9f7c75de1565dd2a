#include <algorithm>
#include <cmath>

#include "driveline/trajectory/contour_planner.hpp"

namespace driveline::trajectory {
namespace {

/// Maximum number of stretches that wait for following ones.
constexpr std::size_t kMaxCurved = 256;
/// Maximum number of pieces that wait, as a divisor of the capacity.
constexpr std::uint64_t kCurvedInRoom = 16;

double length_of(PathTicks begin, PathTicks end) noexcept {
  return static_cast<double>(end - begin) * kPathTick;
}

}  // namespace

// Where the path is bent, a lower speed leaves more of the acceleration for speeding up and braking. So the highest
// speed of a stretch is limited to what can be reached there from the slower stretches before and after it.
void ContourPlanner::append_curved(const Curved& gathered) {
  curved_.push_back(gathered);
  auto& next = curved_.back();
  const auto& stretch = next.stretch;
  const double length = length_of(stretch.begin, stretch.end);
  if (stretch.stops) lower_to_reachable(next, 0.0);
  lower_to_reachable(next, reached2_);
  const double top2 = stretch.top * stretch.top;
  const double braked2 = 2.0 * stretch.acceleration * length;
  reached2_ = stretch.stops ? 0.0 : std::min(top2, reached2_ + braked2);
  next.begin2 = stretch.stops ? std::min(top2, braked2) : top2;
  curved_brakes2_ += braked2;
  double from2 = next.begin2;
  for (std::size_t k = curved_.size() - 1; k-- > first_curved_;) {
    auto& before = curved_[k];
    lower_to_reachable(before, from2);
    const double begin2 =
        std::min(before.stretch.top * before.stretch.top,
                 from2 + 2.0 * before.stretch.acceleration * length_of(before.stretch.begin, before.stretch.end));
    if (begin2 >= before.begin2) break;
    before.begin2 = begin2;
    from2 = begin2;
  }
  hand_on_curved(gathered.stretch.stops);
}

/// Passes on the stretches that following ones cannot lower any more, or all.
void ContourPlanner::hand_on_curved(bool all) {
  while (first_curved_ < curved_.size()) {
    const auto& [stretch, bend, begin2] = curved_[first_curved_];
    const double braked2 = 2.0 * stretch.acceleration * length_of(stretch.begin, stretch.end);
    const bool is_full = curved_.size() - first_curved_ > kMaxCurved ||
                         curved_.back().stretch.last_piece - stretch.first_piece >= settings_.capacity / kCurvedInRoom;
    if (!all && !is_full && bend.is_bent && curved_brakes2_ - braked2 < stretch.top * stretch.top) break;
    curved_brakes2_ -= braked2;
    append_shaped(stretch);
    ++first_curved_;
  }
  if (first_curved_ == curved_.size()) {
    curved_.clear();
    first_curved_ = 0;
    curved_brakes2_ = 0.0;
  } else if (first_curved_ >= kMaxCurved) {
    curved_.erase(curved_.begin(), curved_.begin() + static_cast<std::ptrdiff_t>(first_curved_));
    first_curved_ = 0;
  }
}

/// Lowers the top speed to what can be reached from the squared speed `from2` at one end of the stretch.
void ContourPlanner::lower_to_reachable(Curved& curved, double from2) const noexcept {
  auto& stretch = curved.stretch;
  const auto& bend = curved.bend;
  if (!bend.is_bent) return;
  const double length = length_of(stretch.begin, stretch.end);
  double high2 = stretch.top * stretch.top;
  if (high2 <= from2 + 2.0 * stretch.acceleration * length) return;
  const double at_top = stretch.acceleration;
  const auto acceleration_of = [&](double square) {
    return std::max(at_top, acceleration_at(bend, std::sqrt(square)));
  };
  // The acceleration falls with the square of the speed, nearly linearly, so use the method of false position. Every
  // intermediate speed is stored with a matching acceleration.
  double low2 = from2;
  double low = acceleration_of(low2);
  double high = at_top;
  constexpr int kSteps = 3;
  for (int k = 0; k < kSteps; ++k) {
    const double fall = (low - high) / (high2 - low2);
    const double between2 =
        std::clamp((from2 + 2.0 * length * (low + fall * low2)) / (1.0 + 2.0 * length * fall), low2, high2);
    const double there = acceleration_of(between2);
    const double excess2 = between2 - from2 - 2.0 * length * there;
    constexpr double kNear = 1e-3;
    stretch.top = std::sqrt(between2);
    stretch.acceleration = there;
    if (std::abs(excess2) <= kNear * between2) return;
    (excess2 < 0.0 ? low2 : high2) = between2;
    (excess2 < 0.0 ? low : high) = there;
  }
}

}  // namespace driveline::trajectory
