#pragma once

#include <string>

#include "driveline/esi/device_description.hpp"

namespace driveline::esi {

/// Writes the device's objects as an electronic data sheet (CiA 306-1) for CANopen configuration tools. Equal input
/// gives equal bytes: the file contains no date. Strings are written without a default value.
[[nodiscard]] std::string write_eds(const DeviceDescription& device, std::string_view file_name);

}  // namespace driveline::esi
