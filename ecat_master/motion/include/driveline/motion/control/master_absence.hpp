#pragma once

#include <chrono>
#include <cstdint>
#include <string>
#include <string_view>
#include <type_traits>

namespace driveline::motion {

/// Behaviour of a path that is late because drives got no setpoints.
enum class LatePolicy : std::uint8_t {
  kStay,     ///< the path stays late
  kCatchUp,  ///< the path runs faster, within the limits of all axes, until it is on time
};

/// Effect of an absence of the master on the motion.
enum class AbsenceEffect : std::uint8_t {
  kNone,     ///< setpoints moved no axis
  kBridged,  ///< the axes continue from where they were
  kStopped,  ///< the absence was too long: the axes are stopped
};

/// The master was late by a period or more: its thread was not woken, or the previous cycle took too long.
struct MasterAbsence {
  std::chrono::nanoseconds since{};             ///< first grid instant missed
  std::chrono::nanoseconds duration{};          ///< until the next cycle started
  std::chrono::nanoseconds path_late{};         ///< resulting delay of the path
  std::uint64_t cycle = 0;                      ///< number of the cycle that ended the absence
  AbsenceEffect effect = AbsenceEffect::kNone;  ///< effect on the motion
};
static_assert(std::is_trivially_copyable_v<MasterAbsence>);

/// Message text, such as "the master was away for 54.0 ms at 0.850 s; the path is 54.0 ms late". `begin`: origin of the
/// time; `limit`: the absence that the motion bridges, as text: "8 cycles".
[[nodiscard]] std::string describe(const MasterAbsence& absence, std::chrono::nanoseconds begin,
                                   std::string_view limit);

}  // namespace driveline::motion
