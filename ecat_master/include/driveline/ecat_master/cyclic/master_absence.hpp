#pragma once

#include <chrono>
#include <cstdint>
#include <string>
#include <string_view>
#include <type_traits>

namespace driveline::ecat_master {

/// What happens to a path that is late because drives were given no setpoints.
enum class LatePolicy : std::uint8_t {
  kStay,     ///< it stays late
  kCatchUp,  ///< it runs faster, as far as the limits of all axes allow, until it is not late any more
};

/// Effect of an absence of the master on the motion.
enum class AbsenceEffect : std::uint8_t {
  kNone,     ///< no axis was moved by setpoints
  kBridged,  ///< the axes go on from where they were
  kStopped,  ///< it was too long: the axes are stopped
};

/// The master was late by a period or more: its thread was not woken, or the cycle before took too long.
struct MasterAbsence {
  std::chrono::nanoseconds since{};             ///< the grid instant that was missed first
  std::chrono::nanoseconds duration{};          ///< until the next cycle began
  std::chrono::nanoseconds path_late{};         ///< by how much the path is late now
  std::uint64_t cycle = 0;                      ///< the cycle it ended with
  AbsenceEffect effect = AbsenceEffect::kNone;  ///< on the motion
};
static_assert(std::is_trivially_copyable_v<MasterAbsence>);

/// "the master was away for 54.0 ms at 0.850 s; the path is 54.0 ms late". `begin`: what the time is counted from;
/// `limit`: what the motion bridges, in words: "8 cycles".
[[nodiscard]] std::string describe(const MasterAbsence& absence, std::chrono::nanoseconds begin,
                                   std::string_view limit);

}  // namespace driveline::ecat_master
