#include "driveline/motion/cia402/error_code.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>

namespace driveline::motion::cia402 {
namespace {

struct ErrorName {
  std::uint16_t code;
  std::string_view name;
};

/// Sorted by code. Codes that end in zeros are groups.
constexpr std::array kErrorNames = {
    ErrorName{0x1000, "generic error"},
    ErrorName{0x2000, "current"},
    ErrorName{0x2100, "current at the device's input"},
    ErrorName{0x2110, "short circuit or earth leakage at the input"},
    ErrorName{0x2120, "earth leakage at the input"},
    ErrorName{0x2130, "short circuit at the input"},
    ErrorName{0x2200, "internal current"},
    ErrorName{0x2211, "internal current no. 1"},
    ErrorName{0x2212, "internal current no. 2"},
    ErrorName{0x2213, "overcurrent in the ramp function"},
    ErrorName{0x2214, "overcurrent in the sequence"},
    ErrorName{0x2220, "continuous overcurrent inside the device"},
    ErrorName{0x2230, "short circuit or earth leakage inside the device"},
    ErrorName{0x2240, "earth leakage inside the device"},
    ErrorName{0x2250, "short circuit inside the device"},
    ErrorName{0x2300, "current at the device's output"},
    ErrorName{0x2310, "continuous overcurrent"},
    ErrorName{0x2320, "short circuit or earth leakage at the motor"},
    ErrorName{0x2330, "earth leakage at the motor"},
    ErrorName{0x2340, "short circuit at the motor"},
    ErrorName{0x2350, "overload (I2t, thermal state)"},
    ErrorName{0x2351, "overload warning (I2t, thermal state)"},
    ErrorName{0x3000, "voltage"},
    ErrorName{0x3100, "mains voltage"},
    ErrorName{0x3110, "mains overvoltage"},
    ErrorName{0x3120, "mains undervoltage"},
    ErrorName{0x3130, "phase failure"},
    ErrorName{0x3134, "phase sequence"},
    ErrorName{0x3140, "mains frequency"},
    ErrorName{0x3141, "mains frequency too high"},
    ErrorName{0x3142, "mains frequency too low"},
    ErrorName{0x3200, "DC link voltage"},
    ErrorName{0x3210, "DC link overvoltage"},
    ErrorName{0x3220, "DC link undervoltage"},
    ErrorName{0x3230, "load error"},
    ErrorName{0x3300, "output voltage"},
    ErrorName{0x3310, "output overvoltage"},
    ErrorName{0x3320, "armature circuit"},
    ErrorName{0x3330, "field circuit"},
    ErrorName{0x4000, "temperature"},
    ErrorName{0x4100, "ambient temperature"},
    ErrorName{0x4110, "ambient temperature too high"},
    ErrorName{0x4120, "ambient temperature too low"},
    ErrorName{0x4200, "device temperature"},
    ErrorName{0x4210, "device temperature too high"},
    ErrorName{0x4220, "device temperature too low"},
    ErrorName{0x4300, "drive temperature"},
    ErrorName{0x4310, "drive temperature too high"},
    ErrorName{0x4320, "drive temperature too low"},
    ErrorName{0x4400, "supply temperature"},
    ErrorName{0x4410, "supply temperature too high"},
    ErrorName{0x4420, "supply temperature too low"},
    ErrorName{0x5000, "device hardware"},
    ErrorName{0x5100, "supply of the device hardware"},
    ErrorName{0x5200, "control hardware"},
    ErrorName{0x5210, "measurement circuit"},
    ErrorName{0x5220, "computing circuit"},
    ErrorName{0x5300, "operating unit"},
    ErrorName{0x5400, "power section"},
    ErrorName{0x5410, "output stages"},
    ErrorName{0x5420, "chopper"},
    ErrorName{0x5430, "input stages"},
    ErrorName{0x5440, "contacts"},
    ErrorName{0x5450, "fuses"},
    ErrorName{0x5500, "data storage hardware"},
    ErrorName{0x5510, "RAM"},
    ErrorName{0x5520, "ROM or EPROM"},
    ErrorName{0x5530, "EEPROM"},
    ErrorName{0x6000, "device software"},
    ErrorName{0x6010, "software reset (watchdog)"},
    ErrorName{0x6100, "internal software"},
    ErrorName{0x6200, "user software"},
    ErrorName{0x6300, "data record"},
    ErrorName{0x6310, "loss of parameters"},
    ErrorName{0x6320, "parameter error"},
    ErrorName{0x7000, "additional modules"},
    ErrorName{0x7100, "power of additional modules"},
    ErrorName{0x7110, "brake chopper"},
    ErrorName{0x7111, "failure of the brake chopper"},
    ErrorName{0x7112, "overcurrent in the brake chopper"},
    ErrorName{0x7113, "protective circuit of the brake chopper"},
    ErrorName{0x7120, "motor"},
    ErrorName{0x7121, "motor blocked"},
    ErrorName{0x7122, "motor error or commutation"},
    ErrorName{0x7123, "motor tilted"},
    ErrorName{0x7200, "measurement circuit of additional modules"},
    ErrorName{0x7300, "sensor"},
    ErrorName{0x7301, "tachometer"},
    ErrorName{0x7302, "tachometer with wrong polarity"},
    ErrorName{0x7303, "resolver 1"},
    ErrorName{0x7304, "resolver 2"},
    ErrorName{0x7305, "incremental encoder 1"},
    ErrorName{0x7306, "incremental encoder 2"},
    ErrorName{0x7307, "incremental encoder 3"},
    ErrorName{0x7310, "speed"},
    ErrorName{0x7320, "position"},
    ErrorName{0x7400, "computing circuit of additional modules"},
    ErrorName{0x7500, "communication of additional modules"},
    ErrorName{0x7510, "serial interface no. 1"},
    ErrorName{0x7520, "serial interface no. 2"},
    ErrorName{0x7600, "external data storage"},
    ErrorName{0x8000, "monitoring"},
    ErrorName{0x8100, "communication"},
    ErrorName{0x8200, "protocol error"},
    ErrorName{0x8300, "torque control"},
    ErrorName{0x8311, "excess torque"},
    ErrorName{0x8312, "difficult start-up"},
    ErrorName{0x8313, "standstill torque"},
    ErrorName{0x8321, "insufficient torque"},
    ErrorName{0x8331, "torque fault"},
    ErrorName{0x8400, "velocity controller"},
    ErrorName{0x8500, "position controller"},
    ErrorName{0x8600, "positioning controller"},
    ErrorName{0x8611, "following error"},
    ErrorName{0x8612, "reference limit"},
    ErrorName{0x8700, "synchronisation controller"},
    ErrorName{0x8800, "winding controller"},
    ErrorName{0x8900, "process data monitoring"},
    ErrorName{0x8A00, "control monitoring"},
    ErrorName{0x9000, "external error"},
    ErrorName{0xF000, "additional functions"},
    ErrorName{0xF001, "deceleration"},
    ErrorName{0xF002, "sub-synchronous run"},
    ErrorName{0xF003, "stroke operation"},
    ErrorName{0xF004, "control of additional functions"},
    ErrorName{0xFF00, "manufacturer-specific"},
};

constexpr bool error_names_in_order() noexcept {
  for (std::size_t i = 1; i < kErrorNames.size(); ++i) {
    if (kErrorNames[i - 1].code >= kErrorNames[i].code) return false;
  }
  return true;
}
static_assert(error_names_in_order(), "error_name() needs sorted rows");

}  // namespace

std::string_view error_name(std::uint16_t code) noexcept {
  for (const unsigned mask : {0xFFFFU, 0xFFF0U, 0xFF00U, 0xF000U}) {
    const auto wanted = static_cast<std::uint16_t>(code & mask);
    const auto found = std::lower_bound(kErrorNames.begin(), kErrorNames.end(), wanted,
                                        [](const ErrorName& name, std::uint16_t value) { return name.code < value; });
    if (found != kErrorNames.end() && found->code == wanted) return found->name;
  }
  return {};
}

std::string error_text(std::uint16_t code) {
  const auto name = error_name(code);
  return name.empty() ? fmt::format("0x{:04X}", code) : fmt::format("0x{:04X}, {}", code, name);
}

}  // namespace driveline::motion::cia402
