#include "text/drive_view.hpp"

#include <algorithm>
#include <bit>

#include "driveline/slaves/od/entry_row.hpp"

namespace driveline::cli {
namespace {

using enum esi::DataType;

constexpr std::array<DriveObjectRow, static_cast<std::size_t>(DriveObject::kCount)> kObjects = {{
    {DriveObject::kDeviceType, 0x1000, 0, kUnsigned32, "device_type", true},
    {DriveObject::kDeviceName, 0x1008, 0, kVisibleString, "device_name", true},
    {DriveObject::kSoftwareVersion, 0x100A, 0, kVisibleString, "software_version", true},
    {DriveObject::kVendor, 0x1018, 1, kUnsigned32, "vendor_id", true},
    {DriveObject::kProduct, 0x1018, 2, kUnsigned32, "product_code", true},
    {DriveObject::kRevision, 0x1018, 3, kUnsigned32, "revision", true},
    {DriveObject::kSerial, 0x1018, 4, kUnsigned32, "serial_number", true},
    {DriveObject::kAlias, 0x2003, 0, kVisibleString, "alias_name", true},
    {DriveObject::kErrorRegister, 0x1001, 0, kUnsigned8, "error_register"},
    {DriveObject::kLastError, 0x1003, 1, kUnsigned32, "last_error"},
    {DriveObject::kErrorCode, 0x603F, 0, kUnsigned16, "error_code"},
    {DriveObject::kControlWord, 0x6040, 0, kUnsigned16, "control_word"},
    {DriveObject::kStatusWord, 0x6041, 0, kUnsigned16, "status_word"},
    {DriveObject::kMode, 0x6060, 0, kInteger8, "mode_wanted"},
    {DriveObject::kModeDisplay, 0x6061, 0, kInteger8, "mode"},
    {DriveObject::kPositionActual, 0x6064, 0, kInteger32, "position_actual"},
    {DriveObject::kPositionDemand, 0x6062, 0, kInteger32, "position_demand"},
    {DriveObject::kTargetPosition, 0x607A, 0, kInteger32, "position_target"},
    {DriveObject::kVelocityActual, 0x606C, 0, kInteger32, "velocity_actual"},
    {DriveObject::kVelocityDemand, 0x606B, 0, kInteger32, "velocity_demand"},
    {DriveObject::kTargetVelocity, 0x60FF, 0, kInteger32, "velocity_target"},
    {DriveObject::kTorqueActual, 0x6077, 0, kInteger16, "torque_actual"},
    {DriveObject::kTorqueDemand, 0x6074, 0, kInteger16, "torque_demand"},
    {DriveObject::kTargetTorque, 0x6071, 0, kInteger16, "torque_target"},
    {DriveObject::kFollowingError, 0x60F4, 0, kInteger32, "following_error"},
    {DriveObject::kCurrentActual, 0x6078, 0, kInteger16, "current_actual"},
    {DriveObject::kDcLink, 0x6079, 0, kUnsigned32, "dc_link_mv"},
    {DriveObject::kDigitalInputs, 0x60FD, 0, kUnsigned32, "digital_inputs"},
    {DriveObject::kPhysicalOutputs, 0x60FE, 1, kUnsigned32, "physical_outputs"},
    {DriveObject::kInputState, 0x2079, 0, kUnsigned32, "input_state"},
    {DriveObject::kOutputState, 0x208F, 0, kUnsigned32, "output_state"},
    {DriveObject::kNetworkState, 0x280C, 0, kUnsigned8, "network_state"},
    {DriveObject::kWarnings, 0x2022, 0, kUnsigned32, "warnings"},
    {DriveObject::kFaultText, 0x2021, 0, kVisibleString, "fault_text"},
    {DriveObject::kWarningText, 0x2021, 1, kVisibleString, "warning_text"},
    {DriveObject::kRatedTorque, 0x6076, 0, kUnsigned32, "rated_torque_mnm", true, true, "rated torque 6076h", "mNm"},
    {DriveObject::kRatedCurrent, 0x6075, 0, kUnsigned32, "rated_current_ma", true, true, "rated current 6075h", "mA"},
    {DriveObject::kFeed, 0x6092, 1, kUnsigned32, "feed", true, true, "feed 6092h:01", "units"},
    {DriveObject::kFeedRevolutions, 0x6092, 2, kUnsigned32, "feed_revolutions", true, true, "per 6092h:02", "rev"},
    {DriveObject::kPositionNotation, 0x6089, 0, kInteger8, "position_notation", true},
    {DriveObject::kVelocityNotation, 0x608B, 0, kInteger8, "velocity_notation", true},
    {DriveObject::kControlLocation, 0x209F, 0, kUnsigned16, "control_location", false, true, "control location P 159"},
    {DriveObject::kReferenceSource, 0x20A5, 0, kUnsigned16, "reference_source", false, true, "reference P 165"},
    {DriveObject::kReferenceCycle, 0x2132, 0, kReal32, "setpoint_cycle_ms", false, true, "setpoint cycle P 306", "ms"},
    {DriveObject::kPeriodValue, 0x60C2, 1, kUnsigned8, "period_value", false, true, "bus cycle 60C2h", "ms"},
    {DriveObject::kPeriodIndex, 0x60C2, 2, kInteger8, "period_index"},
    {DriveObject::kInterpolation, 0x60C0, 0, kInteger16, "interpolation", false, true, "interpolation 60C0h"},
    {DriveObject::kFollowingWindow, 0x6065, 0, kUnsigned32, "following_error_window", false, true,
     "following window 6065h", "units"},
    {DriveObject::kFollowingTime, 0x6066, 0, kUnsigned16, "following_error_time", false, true, "following time 6066h",
     "ms"},
    {DriveObject::kPositionMin, 0x607D, 1, kInteger32, "position_min", false, true, "position min 607Dh:01", "units"},
    {DriveObject::kPositionMax, 0x607D, 2, kInteger32, "position_max", false, true, "position max 607Dh:02", "units"},
    {DriveObject::kMaxTorque, 0x6072, 0, kUnsigned16, "max_torque", false, true, "max torque 6072h", "0.1 %"},
    {DriveObject::kMaxSpeed, 0x6080, 0, kUnsigned32, "max_speed_rpm", false, true, "max motor speed 6080h", "rpm"},
    {DriveObject::kQuickStopOption, 0x605A, 0, kInteger16, "quick_stop_option", false, true, "quick stop option 605Ah"},
    {DriveObject::kShutdownOption, 0x605B, 0, kInteger16, "shutdown_option", false, true, "shutdown option 605Bh"},
    {DriveObject::kDisableOption, 0x605C, 0, kInteger16, "disable_option", false, true, "disable option 605Ch"},
    {DriveObject::kHaltOption, 0x605D, 0, kInteger16, "halt_option", false, true, "halt option 605Dh"},
    {DriveObject::kFaultOption, 0x605E, 0, kInteger16, "fault_option", false, true, "fault reaction 605Eh"},
}};

constexpr bool in_order() noexcept {
  for (std::size_t i = 0; i < kObjects.size(); ++i) {
    if (static_cast<std::size_t>(kObjects[i].object) != i) return false;
  }
  return true;
}
static_assert(in_order(), "the object is used as index");

constexpr const DriveObjectRow& row_of(DriveObject object) noexcept {
  return kObjects[static_cast<std::size_t>(object)];
}

}  // namespace

const std::array<DriveObjectRow, static_cast<std::size_t>(DriveObject::kCount)>& drive_objects() noexcept {
  return kObjects;
}

std::optional<std::uint32_t> DriveValues::bits(DriveObject object) const {
  const auto& bytes = at(object);
  const std::size_t size = slaves::byte_size(row_of(object).type);
  if (!bytes || size == 0 || size > sizeof(std::uint32_t) || bytes->size() != size) return std::nullopt;
  std::uint32_t value = 0;
  for (std::size_t i = size; i-- > 0;) value = value << 8 | std::to_integer<std::uint32_t>((*bytes)[i]);
  return value;
}

std::optional<double> DriveValues::number(DriveObject object) const {
  const auto raw = bits(object);
  if (!raw) return std::nullopt;
  const auto type = row_of(object).type;
  if (type == kReal32) return static_cast<double>(std::bit_cast<float>(*raw));
  if (!slaves::is_signed(type)) return static_cast<double>(*raw);
  const auto unused = static_cast<unsigned>(8 * (sizeof(std::uint32_t) - slaves::byte_size(type)));
  return static_cast<double>(static_cast<std::int32_t>(*raw << unused) >> unused);
}

std::string DriveValues::text(DriveObject object) const {
  std::string text;
  const auto& bytes = at(object);
  if (!bytes || !slaves::is_string(row_of(object).type)) return text;
  for (const std::byte byte : *bytes) {
    if (byte == std::byte{0}) break;
    // Replace control characters, because terminals act on them.
    const auto symbol = std::to_integer<unsigned char>(byte);
    text += symbol < 0x20 || symbol == 0x7F ? '?' : static_cast<char>(symbol);
  }
  return text;
}

}  // namespace driveline::cli
