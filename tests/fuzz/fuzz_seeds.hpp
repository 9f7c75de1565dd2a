#pragma once

#include <string>

#include "driveline/esi/device_description.hpp"
#include "fuzz_target.hpp"

/// Inputs that several targets start with. Inputs from captures exist only where the captures exist.
namespace driveline::fuzz {

/// The text of the example devices, examples/terminals.xml.
[[nodiscard]] std::string example_devices();
/// One of the example devices. Aborts if it is missing, because the target would test nothing.
[[nodiscard]] esi::DeviceDescription example_device(const std::string& name);

/// EEPROM images read from real devices.
[[nodiscard]] std::vector<Bytes> recorded_images();
/// Frames of real masters, without repetitions of the same commands to the same addresses; each after its length in two
/// bytes, in chunks of some hundred frames.
[[nodiscard]] std::vector<Bytes> recorded_frames();
/// Mailbox messages written by real masters, each after its length in two bytes.
[[nodiscard]] std::vector<Bytes> recorded_mailboxes();

}  // namespace driveline::fuzz
