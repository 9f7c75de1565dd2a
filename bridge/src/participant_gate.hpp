#pragma once

#include <algorithm>
#include <chrono>
#include <cstddef>
#include <map>

#include "driveline/snapshot/feed/command_records.hpp"

namespace driveline::bridge {

/// Lets so many commands of each participant through in a second, so that none takes the room of the others.
class ParticipantGate {
 public:
  using Time = std::chrono::steady_clock::time_point;

  /// All positive. `most`: participants that are remembered; what is there beyond shares the room of one.
  ParticipantGate(double per_second, double at_once, std::size_t most) noexcept
      : per_second_(per_second), at_once_(at_once), most_(most) {}

  /// One more of that participant. False: it is too much.
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
      // Those who have all of their room again have nothing that must be remembered.
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
