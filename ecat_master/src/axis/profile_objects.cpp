#include "driveline/ecat_master/axis/profile_objects.hpp"

#include "axis/axis_entries.hpp"

namespace driveline::ecat_master {

ProfileObjects::ProfileObjects(const ProcessDataPlace& place, const PdoConfiguration& pdos, const Limits& limits)
    : velocity_(entry<std::uint32_t>(pdos.outputs, place.output_offset, 0x6081)),
      acceleration_(entry<std::uint32_t>(pdos.outputs, place.output_offset, 0x6083)),
      deceleration_(entry<std::uint32_t>(pdos.outputs, place.output_offset, 0x6084)),
      limits_(limits) {}

void ProfileObjects::set(double velocity, double acceleration, double deceleration) noexcept {
  limits_ = {velocity, acceleration, deceleration, limits_.scale};
}

void ProfileObjects::write(std::span<std::byte> image) const noexcept {
  put(velocity_, image, saturate<std::uint32_t>(limits_.velocity * limits_.scale));
  put(acceleration_, image, saturate<std::uint32_t>(limits_.acceleration * limits_.scale));
  put(deceleration_, image, saturate<std::uint32_t>(limits_.deceleration * limits_.scale));
}

}  // namespace driveline::ecat_master
