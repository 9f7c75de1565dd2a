// Status that the drive displays to users.
#include <array>
#include <cstddef>
#include <cstdint>
#include <string_view>

#include "driveline/slaves/msd/core/faults.hpp"
#include "driveline/slaves/msd/msd_drive.hpp"

namespace driveline::slaves::msd {
namespace {

std::string_view state_text(PowerState state) noexcept {
  switch (state) {
    case PowerState::kNotReadyToSwitchOn:
      return "not ready to switch on";
    case PowerState::kSwitchOnDisabled:
      return "switch on disabled";
    case PowerState::kReadyToSwitchOn:
      return "ready to switch on";
    case PowerState::kSwitchedOn:
      return "switched on";
    case PowerState::kOperationEnabled:
      return "operation enabled";
    case PowerState::kQuickStopActive:
      return "quick stop active";
    case PowerState::kFaultReactionActive:
      return "fault reaction active";
    case PowerState::kFault:
      return "fault";
  }
  return "";
}

/// Returns the CiA 402 mode of operation in 6061h as text.
std::string_view mode_text(std::int8_t mode) noexcept {
  constexpr std::array<std::string_view, 11> kModes = {"none",
                                                       "profile position",
                                                       "velocity",
                                                       "profile velocity",
                                                       "profile torque",
                                                       "",
                                                       "homing",
                                                       "interpolated position",
                                                       "cyclic synchronous position",
                                                       "cyclic synchronous velocity",
                                                       "cyclic synchronous torque"};
  // Negative modes are also beyond the table.
  const std::size_t number = static_cast<std::uint8_t>(mode);
  return number < kModes.size() ? kModes[number] : std::string_view("of the manufacturer");
}

void show_display(const DisplayFrame& frame, DeviceStatus& out) noexcept {
  std::array<char, 4> text{};
  std::size_t length = 0;
  for (const auto& digit : {frame.first, frame.second}) {
    text[length++] = digit.symbol;
    if (digit.point) text[length++] = '.';
  }
  out.display = std::string_view(text.data(), length);
}

void show_firmware(const FirmwareVersion& version, DeviceStatus& out) noexcept {
  std::array<char, 12> text{};
  std::size_t length = 0;
  const auto put = [&](unsigned number, unsigned digits) {
    for (unsigned unit = digits == 3 ? 100 : 10; unit != 0; unit /= 10) {
      if (digits == 3 && unit > number && unit != 1) continue;
      text[length++] = static_cast<char>('0' + number / unit % 10);
    }
  };
  put(version.major, 3);
  text[length++] = '.';
  put(version.minor, 2);
  text[length++] = '-';
  put(version.correction, 2);
  out.firmware = std::string_view(text.data(), length);
}

void show_actual_values(const DriveCore& core, DeviceStatus& out) noexcept {
  constexpr auto kActual = DeviceStatus::Kind::kActual;
  const auto& values = core.complete_values();
  out.add(kActual, "position", values.get(kValue.position_actual), "increments");
  out.add(kActual, "following error", values.get(kValue.following_error), "increments");
  out.add(kActual, "speed", core.velocity_rad_s() / kRpm, "rpm");
  out.add(kActual, "torque", values.get(kValue.torque_actual) / 10.0, "% of rated");
  out.add(kActual, "current", values.get(kValue.current_actual) / 10.0, "% of rated");
  out.add(kActual, "DC link voltage", values.get(kValue.dc_link_voltage) / 1000.0, "V");
  out.add(kActual, "motor temperature", static_cast<double>(values.get(kValue.motor_temperature)), "°C");
}

void show_parameters(const ObjectDictionary& values, DeviceStatus& out) noexcept {
  constexpr auto kParameter = DeviceStatus::Kind::kParameter;
  out.add(kParameter, "P 320 speed control gain", static_cast<double>(values.get(kValue.velocity_gain)));
  out.add(kParameter, "P 321 speed control reset", static_cast<double>(values.get(kValue.velocity_reset)));
  out.add(kParameter, "P 360 position control gain", static_cast<double>(values.get(kValue.position_gain)));
  out.add(kParameter, "P 306 reference cycle", static_cast<double>(values.get(kValue.reference_cycle)), "ms");
  out.add(kParameter, "P 1516 total inertia", static_cast<double>(values.get(kValue.total_inertia)));
  out.add(kParameter, "6065h following error window", values.get(kValue.following_error_window), "increments");
  out.add(kParameter, "6072h max torque", values.get(kValue.max_torque) / 10.0, "% of rated");
  out.add(kParameter, "6080h max motor speed", values.get(kValue.max_motor_speed), "rpm");
  out.add(kParameter, "6075h motor rated current", values.get(kValue.motor_rated_current) / 1000.0, "A");
  out.add(kParameter, "6076h motor rated torque", values.get(kValue.motor_rated_torque) / 1000.0, "Nm");
}

}  // namespace

void MsdDrive::show(DeviceStatus& out) const noexcept {
  out = {};
  const VariantFacts& drive = facts(core_.variant());
  const auto& values = core_.complete_values();
  out.maker = "Moog";
  out.type = drive.device_name;
  out.name = core_.name();
  show_firmware(core_.firmware(), out);
  out.vendor_id = kVendorId;
  out.product_code = drive.product_code;
  out.revision = drive.revision;
  out.serial_number = values.get(kValue.serial_number);
  out.al_state = al_state_;
  const auto fault = core_.fault();
  out.fault = fault.has_value();
  if (fault) out.message = msd::facts(*fault).text;
  out.control_word = values.get(kValue.control_word);
  out.status_word = core_.status();
  out.error_code = values.get(kValue.error_code);
  out.state = state_text(core_.state());
  out.mode = mode_text(values.get(kValue.mode_display));
  show_display(core_.display_now(), out);
  show_actual_values(core_, out);
  show_parameters(values, out);
}

}  // namespace driveline::slaves::msd
