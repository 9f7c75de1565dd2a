#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <optional>

#include "boundary.hpp"
#include "driveline/trajectory/profile.hpp"

namespace driveline::trajectory {

/// Finds motions of an axis by means of two frontiers: the farthest displacement forwards, and backwards, in a given
/// time. Every displacement in between is possible in the same time, because a mixture of two motions that keep limits
/// keeps them, too.
template <typename Frontier>
class FrontierPlanner {
 public:
  /// `way`: displacement; `way_error`: its rounding error.
  FrontierPlanner(const Boundary& boundary, double way, double way_error) noexcept
      : boundary_(boundary), forwards_(boundary), backwards_(boundary.mirrored()), way_(way), way_error_(way_error) {}

  /// A motion along one of the frontiers.
  struct Extreme {
    double duration_s;
    PhaseList phases;
    double sign;  ///< -1: multiplies the phases of the backward frontier
  };

  [[nodiscard]] Extreme fastest() const noexcept {
    if (forwards_.has_short_stretch()) {
      const Stretch forward = forwards_.short_stretch();
      if (const auto extreme = fastest_in(forward, [&] { return backwards_.short_stretch(); })) {
        return *extreme;
      }
      const auto longest = forward.at(forward.longest_s());
      if (is_same_way(forward.displacement(longest), longest.duration_s)) {
        return {longest.duration_s, forward.phases(longest), 1.0};
      }
    }
    const auto extreme = fastest_in(forwards_.main_stretch(), [&] { return backwards_.main_stretch(); });
    return extreme ? *extreme : Extreme{kNever, {}, 1.0};
  }

  /// The first possible duration from `from_s` on.
  [[nodiscard]] double next_possible_s(double from_s) const noexcept {
    if (forwards_.has_short_stretch()) {
      const Stretch forward = forwards_.short_stretch();
      const auto duration_s = next_in(forward, backwards_.short_stretch(), from_s);
      if (duration_s) {
        return *duration_s;
      }
      const auto longest = forward.at(forward.longest_s());
      if (from_s <= longest.duration_s * kAlmost && is_same_way(forward.displacement(longest), longest.duration_s)) {
        return longest.duration_s;
      }
    }
    return next_in(forwards_.main_stretch(), backwards_.main_stretch(), from_s).value_or(kNever);
  }

  /// The first duration from `from_s` on that is impossible or after which durations are impossible.
  [[nodiscard]] double next_impossible_s(double from_s) const noexcept {
    if (forwards_.has_short_stretch() && from_s <= forwards_.short_stretch().longest_s()) {
      return next_gap_in(forwards_.short_stretch(), backwards_.short_stretch(), from_s);
    }
    const Stretch forward = forwards_.main_stretch();
    return from_s < forward.shortest_s() ? from_s : next_gap_in(forward, backwards_.main_stretch(), from_s);
  }

  /// Appends the motion of a possible duration to a profile, with accelerations and jerks times `scale`.
  void append_mixture(Profile& profile, double duration_s, double scale) const noexcept {
    if (forwards_.has_short_stretch() && duration_s <= forwards_.short_stretch().longest_s() * kAlmost) {
      mix(profile, part(forwards_.short_stretch(), duration_s, 1.0), part(backwards_.short_stretch(), duration_s, -1.0),
          scale);
    } else {
      mix_main(profile, duration_s, scale);
    }
  }

 private:
  using Stretch = typename Frontier::Stretch;
  static constexpr double kNever = std::numeric_limits<double>::infinity();
  /// Relative difference below which two durations are equal.
  static constexpr double kSame = 1e-12;
  static constexpr double kAlmost = 1.0 + 4.0 * kSame;
  static constexpr double kLastDigits = 1.6e-15;
  /// Iteration limit: the two frontiers have only a few turning points.
  static constexpr int kMaxRounds = 12;

  /// Whether the displacement equals that of a stretch's shortest or longest motion, up to rounding. Perhaps no motion
  /// moves slightly less or more far in about the same time, so a state on its way to the target must not be mistaken
  /// for a state that missed it.
  [[nodiscard]] bool is_same_way(double displacement, double duration_s) const noexcept {
    const double velocities = std::abs(boundary_.v0) + std::abs(boundary_.v1);
    const double ends = std::abs(boundary_.a0) + std::abs(boundary_.a1);
    const double moved =
        duration_s * (velocities + duration_s * (ends + std::min(duration_s, boundary_.rise + boundary_.fall)));
    // The last digit of the velocities shifts the duration, by more the smaller the accelerations are.
    const double slowest = Frontier::kJumps ? std::min(boundary_.rise, boundary_.fall) : ends + duration_s;
    const double moved_s = duration_s > 0.0 ? kLastDigits * velocities / slowest : 0.0;
    return std::abs(way_ - displacement) <= way_error_ + kSame * moved + velocities * moved_s;
  }

  template <typename MakeBackward>
  [[nodiscard]] std::optional<Extreme> fastest_in(const Stretch& forward, MakeBackward make_backward) const noexcept {
    if (is_same_way(forward.shortest_way(), forward.shortest_s())) {
      return Extreme{forward.shortest_s(), forward.phases(forward.shortest()), 1.0};
    }
    return way_ > forward.shortest_way() ? along(forward, way_, 1.0) : along(make_backward(), -way_, -1.0);
  }

  [[nodiscard]] static std::optional<Extreme> along(const Stretch& stretch, double way, double sign) noexcept {
    const auto point = stretch.next(way, 0.0, true);
    if (!point) {
      return std::nullopt;
    }
    return Extreme{point->duration_s, stretch.phases(*point), sign};
  }

  [[nodiscard]] std::optional<double> next_in(const Stretch& forward, const Stretch& backward,
                                              double from_s) const noexcept {
    double duration_s = std::max(from_s, forward.shortest_s());
    if (duration_s <= forward.shortest_s() * kAlmost && is_same_way(forward.shortest_way(), forward.shortest_s())) {
      return forward.shortest_s();
    }
    for (int i = 0; i < kMaxRounds && duration_s <= forward.longest_s(); ++i) {
      const auto there = forward.next(way_, duration_s, true);
      const auto here = there ? backward.next(-way_, there->duration_s, true) : std::nullopt;
      if (!here) {
        return std::nullopt;
      }
      duration_s = std::max(here->duration_s, there->duration_s);
      if (duration_s - there->duration_s <= kSame * duration_s) {
        return duration_s;
      }
    }
    return std::nullopt;
  }

  [[nodiscard]] double next_gap_in(const Stretch& forward, const Stretch& backward, double from_s) const noexcept {
    const auto there = forward.next(way_, from_s, false);
    const auto here = backward.next(-way_, from_s, false);
    return std::min({there ? there->duration_s : kNever, here ? here->duration_s : kNever, forward.longest_s()});
  }

  /// One of two motions of equal duration to be mixed.
  struct Part {
    PhaseList phases;
    double displacement;
    double sign;  ///< -1: the phases apply to the inverted axis
  };

  [[nodiscard]] static Part part(const Stretch& stretch, double duration_s, double sign) noexcept {
    const auto point = stretch.at(duration_s);
    return {stretch.phases(point), sign * stretch.displacement(point), sign};
  }

  /// Between the frontiers of the velocity limits lie those of the velocities that the end states need. Mixes the two
  /// frontiers that enclose the displacement most closely, so that an axis at rest that is to stay there does not move.
  void mix_main(Profile& profile, double duration_s, double scale) const noexcept {
    const Boundary narrow = boundary_.narrowed();
    const Part most = part(Frontier(narrow).main_stretch(), duration_s, 1.0);
    if (way_ > most.displacement) {
      mix(profile, part(forwards_.main_stretch(), duration_s, 1.0), most, scale);
      return;
    }
    const Part least = part(Frontier(narrow.mirrored()).main_stretch(), duration_s, -1.0);
    if (way_ < least.displacement) {
      mix(profile, least, part(backwards_.main_stretch(), duration_s, -1.0), scale);
      return;
    }
    mix(profile, most, least, scale);
  }

  void mix(Profile& profile, const Part& most, const Part& least, double scale) const noexcept {
    const double room = most.displacement - least.displacement;
    const double share = room > 0.0 ? std::clamp((way_ - least.displacement) / room, 0.0, 1.0) : 1.0;
    const double most_scale = share * scale * most.sign;
    const double least_scale = (1.0 - share) * scale * least.sign;
    double most_s = 0.0;  // time since the start of the phase
    double least_s = 0.0;
    for (std::size_t i = 0, k = 0; i < most.phases.size() && k < least.phases.size();) {
      const JerkPhase& a = most.phases[i];
      const JerkPhase& b = least.phases[k];
      const double most_rest_s = a.duration_s - most_s;
      const double least_rest_s = b.duration_s - least_s;
      const double step_s = std::min(most_rest_s, least_rest_s);
      profile.append(
          step_s, most_scale * (a.acceleration + most_s * a.jerk) + least_scale * (b.acceleration + least_s * b.jerk),
          most_scale * a.jerk + least_scale * b.jerk);
      most_s += step_s;
      least_s += step_s;
      if (most_rest_s <= least_rest_s) {
        ++i;
        most_s = 0.0;
      }
      if (least_rest_s <= most_rest_s) {
        ++k;
        least_s = 0.0;
      }
    }
  }

  Boundary boundary_;
  Frontier forwards_;
  Frontier backwards_;
  double way_;
  double way_error_;
};

}  // namespace driveline::trajectory
