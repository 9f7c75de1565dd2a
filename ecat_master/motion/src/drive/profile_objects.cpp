#include "driveline/motion/drive/profile_objects.hpp"

#include <cmath>
#include <limits>

#include "drive/drive_entries.hpp"

namespace driveline::motion {

ProfileObjects::ProfileObjects(const ImagePlace& place, const PdoConfiguration& pdos, const Limits& limits)
    : target_(entry<std::int16_t>(pdos.outputs, place.output_offset, 0x6042)),
      velocity_(entry<std::uint32_t>(pdos.outputs, place.output_offset, 0x6081)),
      acceleration_(entry<std::uint32_t>(pdos.outputs, place.output_offset, 0x6083)),
      deceleration_(entry<std::uint32_t>(pdos.outputs, place.output_offset, 0x6084)),
      limits_(limits) {}

void ProfileObjects::set(double velocity, double acceleration, double deceleration) noexcept {
  limits_ = {velocity, acceleration, deceleration, limits_.scale, limits_.counts};
}

bool ProfileObjects::holds_target(double velocity) const noexcept {
  const double counts = std::abs(velocity * limits_.counts);
  const bool lost = velocity != 0.0 && counts < 0.5;
  return !lost && counts <= std::numeric_limits<std::int16_t>::max();
}

void ProfileObjects::write(std::span<std::byte> image) const noexcept {
  // This runs in every cycle for every axis, and most axes map none of these objects, so compute nothing for those.
  const auto write_mapped = [&](const std::optional<PdoEntry<std::uint32_t>>& object, double magnitude) {
    if (object) object->set(image, saturate<std::uint32_t>(magnitude * limits_.scale));
  };
  if (target_) target_->set(image, saturate<std::int16_t>(target_velocity_ * limits_.counts));
  write_mapped(velocity_, limits_.velocity);
  write_mapped(acceleration_, limits_.acceleration);
  write_mapped(deceleration_, limits_.deceleration);
}

}  // namespace driveline::motion
