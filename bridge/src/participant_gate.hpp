#pragma once

#include <algorithm>
#include <chrono>
#include <cstddef>
#include <map>

#include "driveline/snapshot/feed/command_records.hpp"

namespace driveline::bridge {

/// Rate limiter per participant, so that no participant uses up the capacity of others.
class ParticipantGate {
 public:
  using Time = std::chrono::steady_clock::time_point;

  /// All values are positive. `most`: number of participants counted separately; further ones share one allowance.
  ParticipantGate(double per_second, double at_once, std::size_t most) noexcept
      : per_second_(per_second), at_once_(at_once), most_(most) {}

  /// Counts a command of that participant. Returns false if it exceeds the rate.
  [[nodiscard]] bool take(const snapshot::CommandParticipant& participant, Time now) {
    auto& place = place_of(participant, now);
    const double seconds = std::max(0.0, std::chrono::duration<double>(now - place.last).count());
    place.left = std::min(at_once_, place.left + seconds * per_second_);
    place.last = now;
    if (place.left < 1.0) return false;
    place.left -= 1.0;
    return true;
  }

 private:
  struct Place {
    double left = 0;
    Time last;
  };

  Place& place_of(const snapshot::CommandParticipant& participant, Time now) {
    if (const auto found = places_.find(participant); found != places_.end()) return found->second;
    if (places_.size() >= most_) {
      // Participants whose allowance is full again need not be stored.
      std::erase_if(places_, [&](const auto& entry) {
        return std::chrono::duration<double>(now - entry.second.last).count() * per_second_ >= at_once_;
      });
    }
    return places_
        .try_emplace(places_.size() < most_ ? participant : snapshot::CommandParticipant{}, Place{at_once_, now})
        .first->second;
  }

  double per_second_;
  double at_once_;
  std::size_t most_;
  std::map<snapshot::CommandParticipant, Place> places_;
};

}  // namespace driveline::bridge
