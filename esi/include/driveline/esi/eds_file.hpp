#pragma once

#include <string>

#include "driveline/esi/device_description.hpp"

namespace driveline::esi {

/// The device's objects as an electronic data sheet (CiA 306-1) for configuration tools of CANopen. Equal input gives
/// equal bytes: there is no date in it. Strings have no default value there.
[[nodiscard]] std::string write_eds(const DeviceDescription& device, std::string_view file_name);

}  // namespace driveline::esi
