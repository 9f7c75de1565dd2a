#pragma once

#include <string>

#include "driveline/esi/device_description.hpp"
#include "fuzz_target.hpp"

/// Inputs that several targets start from. Those from captures exist only where the captures do.
namespace driveline::fuzz {

/// The text of the example devices, examples/terminals.xml.
[[nodiscard]] std::string example_devices();
/// One of them. Aborts without it: the target would test nothing.
[[nodiscard]] esi::DeviceDescription example_device(const std::string& name);

/// EEPROM images read from real devices.
[[nodiscard]] std::vector<Bytes> recorded_images();
/// Frames of real masters, those with the same commands to the same addresses once; each with its length in two bytes
/// in front, in pieces of some hundred frames.
[[nodiscard]] std::vector<Bytes> recorded_frames();
/// What real masters wrote into mailboxes, each with its length in two bytes in front.
[[nodiscard]] std::vector<Bytes> recorded_mailboxes();

}  // namespace driveline::fuzz
