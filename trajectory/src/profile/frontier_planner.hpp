#pragma once

#include <algorithm>
#include <array>
#include <limits>
#include <optional>

#include "boundary.hpp"
#include "driveline/trajectory/profile.hpp"

namespace driveline::trajectory {

/// Finds motions of one axis by two frontiers: how far it can get forwards, and backwards, in a given time. Every way
/// in between can be done in this time as well, because a mixture of two motions that obey limits obeys them, too.
template <typename Frontier>
class FrontierPlanner {
 public:
  FrontierPlanner(const Boundary& boundary, double way) noexcept
      : forwards_(boundary), backwards_(boundary.mirrored()), way_(way) {}

  /// A motion along one frontier.
  struct Extreme {
    double duration_s;
    PhaseList phases;
    double sign;  ///< -1: of the phases, because it is the backward one
  };

  [[nodiscard]] Extreme fastest() const noexcept {
    if (forwards_.has_short_stretch()) {
      const auto extreme = fastest_in(forwards_.short_stretch(), [&] { return backwards_.short_stretch(); });
      if (extreme) {
        return *extreme;
      }
    }
    const auto extreme = fastest_in(forwards_.main_stretch(), [&] { return backwards_.main_stretch(); });
    return extreme ? *extreme : Extreme{kNever, {}, 1.0};
  }

  /// The first duration, not before `from_s`, that is possible.
  [[nodiscard]] double next_possible_s(double from_s) const noexcept {
    if (forwards_.has_short_stretch()) {
      const auto duration_s = next_in(forwards_.short_stretch(), backwards_.short_stretch(), from_s);
      if (duration_s) {
        return *duration_s;
      }
    }
    return next_in(forwards_.main_stretch(), backwards_.main_stretch(), from_s).value_or(kNever);
  }

  /// The first duration, not before `from_s`, from which on it is impossible. `from_s` is possible.
  [[nodiscard]] double next_impossible_s(double from_s) const noexcept {
    if (forwards_.has_short_stretch() && from_s <= forwards_.short_stretch().longest_s()) {
      return next_gap_in(forwards_.short_stretch(), backwards_.short_stretch(), from_s);
    }
    return next_gap_in(forwards_.main_stretch(), backwards_.main_stretch(), from_s);
  }

  /// Adds the motion of a possible duration to a profile, accelerations and jerks times `scale`.
  void append_mixture(Profile& profile, double duration_s, double scale) const noexcept {
    if (forwards_.has_short_stretch() && duration_s <= forwards_.short_stretch().longest_s()) {
      mix(profile, forwards_.short_stretch(), backwards_.short_stretch(), duration_s, scale);
    } else {
      mix(profile, forwards_.main_stretch(), backwards_.main_stretch(), duration_s, scale);
    }
  }

 private:
  using Stretch = typename Frontier::Stretch;
  static constexpr double kNever = std::numeric_limits<double>::infinity();
  /// Durations that differ by less are the same.
  static constexpr double kSame = 1e-12;
  /// The two frontiers have a few turns only.
  static constexpr int kMostRounds = 12;

  template <typename MakeBackward>
  [[nodiscard]] std::optional<Extreme> fastest_in(const Stretch& forward, MakeBackward make_backward) const noexcept {
    const double shortest_s = forward.shortest_s();
    if (way_ >= forward.displacement(shortest_s)) {
      return along(forward, way_, 1.0);
    }
    return along(make_backward(), -way_, -1.0);
  }

  [[nodiscard]] static std::optional<Extreme> along(const Stretch& stretch, double way, double sign) noexcept {
    const auto duration_s = stretch.next_duration_s(way, stretch.shortest_s(), true);
    if (!duration_s) {
      return std::nullopt;
    }
    return Extreme{*duration_s, stretch.phases(*duration_s), sign};
  }

  [[nodiscard]] std::optional<double> next_in(const Stretch& forward, const Stretch& backward,
                                              double from_s) const noexcept {
    double duration_s = std::max(from_s, forward.shortest_s());
    for (int i = 0; i < kMostRounds && duration_s <= forward.longest_s(); ++i) {
      const auto there_s = forward.next_duration_s(way_, duration_s, true);
      const auto here_s = there_s ? backward.next_duration_s(-way_, *there_s, true) : std::nullopt;
      if (!here_s) {
        return std::nullopt;
      }
      if (*here_s - *there_s <= kSame * *here_s) {
        return here_s;
      }
      duration_s = *here_s;
    }
    return std::nullopt;
  }

  [[nodiscard]] double next_gap_in(const Stretch& forward, const Stretch& backward, double from_s) const noexcept {
    const double there_s = forward.next_duration_s(way_, from_s, false).value_or(kNever);
    const double here_s = backward.next_duration_s(-way_, from_s, false).value_or(kNever);
    return std::min({there_s, here_s, forward.longest_s()});
  }

  void mix(Profile& profile, const Stretch& forward, const Stretch& backward, double duration_s,
           double scale) const noexcept {
    const double most = forward.displacement(duration_s);
    const double least = -backward.displacement(duration_s);
    const double share = most > least ? std::clamp((way_ - least) / (most - least), 0.0, 1.0) : 1.0;
    const double forward_scale = share * scale;
    const double backward_scale = (share - 1.0) * scale;
    const PhaseList there = forward.phases(duration_s);
    const PhaseList back = backward.phases(duration_s);
    double there_s = 0.0;  // since the begin of the phase
    double back_s = 0.0;
    for (std::size_t i = 0, k = 0; i < there.size() && k < back.size();) {
      const JerkPhase& a = there[i];
      const JerkPhase& b = back[k];
      const double there_rest_s = a.duration_s - there_s;
      const double back_rest_s = b.duration_s - back_s;
      const double step_s = std::min(there_rest_s, back_rest_s);
      profile.append(
          step_s,
          forward_scale * (a.acceleration + there_s * a.jerk) + backward_scale * (b.acceleration + back_s * b.jerk),
          forward_scale * a.jerk + backward_scale * b.jerk);
      there_s += step_s;
      back_s += step_s;
      if (there_rest_s <= back_rest_s) {
        ++i;
        there_s = 0.0;
      }
      if (back_rest_s <= there_rest_s) {
        ++k;
        back_s = 0.0;
      }
    }
  }

  Frontier forwards_;
  Frontier backwards_;
  double way_;
};

}  // namespace driveline::trajectory
