#pragma once

#include <array>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "driveline/ecat_master/state_machine.hpp"
#include "driveline/esi/device_description.hpp"
#include "driveline/wire/dl.hpp"

namespace driveline::cli {

/// The objects on the page of a drive: objects of CiA 301 and CiA 402, and parameters from the manual of the MSD.
enum class DriveObject : std::uint8_t {
  kDeviceType,
  kDeviceName,
  kSoftwareVersion,
  kVendor,
  kProduct,
  kRevision,
  kSerial,
  kAlias,
  kErrorRegister,
  kLastError,
  kErrorCode,
  kControlWord,
  kStatusWord,
  kMode,
  kModeDisplay,
  kPositionActual,
  kPositionDemand,
  kTargetPosition,
  kVelocityActual,
  kVelocityDemand,
  kTargetVelocity,
  kTorqueActual,
  kTorqueDemand,
  kTargetTorque,
  kFollowingError,
  kCurrentActual,
  kDcLink,
  kDigitalInputs,
  kPhysicalOutputs,
  kInputState,
  kOutputState,
  kNetworkState,
  kWarnings,
  kFaultText,
  kWarningText,
  kRatedTorque,
  kRatedCurrent,
  kFeed,
  kFeedRevolutions,
  kPositionNotation,
  kVelocityNotation,
  kControlLocation,
  kReferenceSource,
  kReferenceCycle,
  kPeriodValue,
  kPeriodIndex,
  kInterpolation,
  kFollowingWindow,
  kFollowingTime,
  kPositionMin,
  kPositionMax,
  kMaxTorque,
  kMaxSpeed,
  kQuickStopOption,
  kShutdownOption,
  kDisableOption,
  kHaltOption,
  kFaultOption,
  kCount,
};

/// Address, type and JSON key of an object.
struct DriveObjectRow {
  DriveObject object;
  std::uint16_t index;
  std::uint8_t subindex;
  esi::DataType type;
  std::string_view key;    ///< key in JSON
  bool constant = false;   ///< read only once
  bool important = false;  ///< a parameter, listed on the page under its own name
  std::string_view label{};
  std::string_view unit{};
};

/// All objects, in the order of the enumeration.
[[nodiscard]] const std::array<DriveObjectRow, static_cast<std::size_t>(DriveObject::kCount)>& drive_objects() noexcept;

/// Uploaded values. Objects that a drive does not have stay empty.
class DriveValues {
 public:
  void set(DriveObject object, std::optional<std::vector<std::byte>> bytes) { at(object) = std::move(bytes); }
  /// The value as a number, REAL32 included; none: the object is missing, is no number, or has another length than its
  /// type.
  [[nodiscard]] std::optional<double> number(DriveObject object) const;
  /// The same without sign, for bit fields.
  [[nodiscard]] std::optional<std::uint32_t> bits(DriveObject object) const;
  /// The text up to its first zero byte; empty: there is none.
  [[nodiscard]] std::string text(DriveObject object) const;

 private:
  [[nodiscard]] std::optional<std::vector<std::byte>>& at(DriveObject object) {
    return bytes_[static_cast<std::size_t>(object)];
  }
  [[nodiscard]] const std::optional<std::vector<std::byte>>& at(DriveObject object) const {
    return bytes_[static_cast<std::size_t>(object)];
  }
  std::array<std::optional<std::vector<std::byte>>, static_cast<std::size_t>(DriveObject::kCount)> bytes_;
};

/// State of a drive at one moment.
struct DriveView {
  std::size_t position = 0;
  unsigned drive = 0;      ///< number in the slave; the same for all slaves that are shown
  std::size_t slaves = 1;  ///< on the line
  ecat_master::AlReport al;
  wire::DlStatus dl;
  bool other_master = false;  ///< another master had already taken the line to PREOP or above
  std::string trouble;        ///< why the values are not up to date; empty: they are
  DriveValues values;
};

}  // namespace driveline::cli
