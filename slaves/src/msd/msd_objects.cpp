// What happens in the drive when an object is written: the application's checks and commands.
#include "driveline/slaves/msd/msd_drive.hpp"
#include "driveline/slaves/msd/msd_values.hpp"

namespace driveline::slaves::msd {
namespace {

using wire::SdoAbort;

constexpr std::uint32_t kSaveSignature = 0x65766173;  ///< "save", CiA 301 7.5.2.13
constexpr std::uint32_t kLoadSignature = 0x64616F6C;  ///< "load", CiA 301 7.5.2.14
constexpr std::uint32_t kLinearProfile = 0;           ///< 6086h
constexpr std::uint32_t kJerkLimitedProfile = 3;

/// 60C0h has the numbers of P 370 the other way round, except that linear is 0 and none is -1.
constexpr std::int16_t sub_mode(std::uint8_t type) noexcept {
  return type == 0 ? std::int16_t{-1} : type == 1 ? std::int16_t{0} : static_cast<std::int16_t>(-type);
}
constexpr std::uint8_t type_of(std::int16_t mode) noexcept {
  return mode == -1 ? std::uint8_t{0} : mode == 0 ? std::uint8_t{1} : static_cast<std::uint8_t>(-mode);
}

/// The object that a cyclic mode follows.
constexpr std::uint16_t setpoint_slot(OperationMode mode) noexcept {
  switch (mode) {
    case OperationMode::kInterpolatedPosition:
      return kInterpolationData;
    case OperationMode::kCyclicSynchronousPosition:
      return kTargetPosition;
    case OperationMode::kCyclicSynchronousVelocity:
      return kTargetVelocity;
    case OperationMode::kCyclicSynchronousTorque:
      return kTargetTorque;
    default:
      return kValueCount;
  }
}

/// Parameters that only make sense together: the first must not exceed the second (the manual's logic check, 8.2.5;
/// which ones it knows is not described).
struct LogicRule {
  Value low;
  Value high;
  bool is_signed;
};
constexpr std::array kLogicRules = {
    LogicRule{kPositionLimitMin, kPositionLimitMax, true},
    LogicRule{kRangeMin, kRangeMax, true},
    LogicRule{kVelocityMin, kVelocityMax, false},
};

bool in_order(const LogicRule& rule, std::uint64_t low, std::uint64_t high) noexcept {
  return rule.is_signed ? static_cast<std::int64_t>(low) <= static_cast<std::int64_t>(high) : low <= high;
}

SdoResult<void> require(bool condition, SdoAbort otherwise) noexcept {
  if (condition) return {};
  return tl::unexpected(otherwise);
}

}  // namespace

bool MsdDrive::parameters_consistent() const noexcept {
  for (const LogicRule& rule : kLogicRules) {
    if (!in_order(rule, dictionary_.get<std::uint64_t>(rule.low), dictionary_.get<std::uint64_t>(rule.high))) {
      return false;
    }
  }
  return true;
}

/// The logic check of one new value against those that are there.
bool MsdDrive::consistent_with(const EntryRow& row, std::uint64_t raw) const noexcept {
  for (const LogicRule& rule : kLogicRules) {
    if (row.slot == rule.low && !in_order(rule, raw, dictionary_.get<std::uint64_t>(rule.high))) return false;
    if (row.slot == rule.high && !in_order(rule, dictionary_.get<std::uint64_t>(rule.low), raw)) return false;
  }
  return true;
}

SdoResult<void> MsdDrive::accept(const EntryRow& row, std::uint64_t raw) {
  const bool checked = dictionary_.get<std::uint8_t>(kParameterDownload) == 0;
  if (checked && !consistent_with(row, raw)) return tl::unexpected(SdoAbort::kParameterIncompatible);
  switch (row.slot) {
    // Saving is what these writes are about: when it fails, so do they (CiA 301 7.5.2.13: 0606 0000h).
    case kStoreCommand:
      if (raw != kSaveSignature) return tl::unexpected(SdoAbort::kCannotTransferOrStore);
      return require(store_parameters(), SdoAbort::kHardwareError);
    case kRestoreCommand:
      if (raw != kLoadSignature) return tl::unexpected(SdoAbort::kCannotTransferOrStore);
      factory_reset_pending_ = true;
      return require(store_parameters(), SdoAbort::kHardwareError);
    case kSaveParameters:
      return require(raw != 1 || store_parameters(), SdoAbort::kHardwareError);
    case kMode:
      return require(ModeControl::supported(static_cast<OperationMode>(raw)), SdoAbort::kValueRange);
    case kHomingMethod:
      return require(raw == 0 || HomingSequence::supported(static_cast<std::int8_t>(raw)), SdoAbort::kValueRange);
    case kInputInversion:
      return require(valid_inversion(raw), SdoAbort::kValueRange);
    case kMotorTemperatureSensor:
      return require(raw != 5, SdoAbort::kValueRange);  // "not used"
    case kMotionProfileType:
      return require(raw == kLinearProfile || raw == kJerkLimitedProfile, SdoAbort::kValueRange);
    case kParameterDownload:
      return require(raw == 0 || motion_.standstill(), SdoAbort::kDeviceState);
    default:
      break;
  }
  if (row.slot >= kInputFunctionFirst && row.slot <= kInputFunctionLast) {
    return require(valid_input_function(row.index, raw), SdoAbort::kValueRange);
  }
  if (row.slot >= kOutputFunctionFirst && row.slot <= kOutputFunctionLast) {
    return require(valid_output_function(row.index, raw), SdoAbort::kValueRange);
  }
  return check_pdo_write(dictionary_, pdo_limits_, row, raw);
}

void MsdDrive::written(const EntryRow& row) {
  if (is_string(row.type)) return;
  if (row.index >= pdo_limits_.rx_first && row.index < 0x2000) build_process_data();  // mapping or assignment
  switch (row.slot) {
    case kErrorCount:
      return dictionary_.set(kLastError, 0U);
    case kStoreCommand:
      return dictionary_.set(kStoreCommand, 1U);
    case kRestoreCommand:
      return dictionary_.set(kRestoreCommand, 1U);
    case kSaveParameters:
      return;
    case kFactoryReset:
      factory_reset_pending_ = factory_reset_pending_ || dictionary_.get<std::uint8_t>(kFactoryReset) == 1;
      return dictionary_.set(kFactoryReset, 0U);
    case kParameterDownload:  // its end: the check that was left out
      if (dictionary_.get<std::uint8_t>(kParameterDownload) == 0 && !parameters_consistent()) {
        raise(Fault::kParameterList);
      }
      return;
    case kFaultResetParameter:
      if (dictionary_.get<std::uint8_t>(kFaultResetParameter) == 1) acknowledge();
      return dictionary_.set(kFaultResetParameter, 0U);
    case kControlWord:
      return watch_fault_reset();
    case kTargetPosition:
    case kTargetVelocity:
    case kTargetTorque:
    case kInterpolationData:
      if (row.slot == setpoint_slot(modes_.mode())) return apply_setpoints();
      [[fallthrough]];  // for another mode: nothing begins
    case kVelocityOffset:
    case kTorqueOffset:
      if (references_from_bus()) motion_.prepare(setpoints());
      return;
    case kInterpolationType:
      dictionary_.set(kInterpolationSubMode, sub_mode(dictionary_.get<std::uint8_t>(kInterpolationType)));
      break;
    case kInterpolationSubMode:
      dictionary_.set(kInterpolationType, type_of(dictionary_.get<std::int16_t>(kInterpolationSubMode)));
      break;
    default:
      break;
  }
  settings_changed_ = true;
}

}  // namespace driveline::slaves::msd
