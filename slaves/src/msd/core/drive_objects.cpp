// Reactions of the drive to writes of objects: checks and commands.
#include "driveline/slaves/msd/core/drive_core.hpp"
#include "driveline/slaves/msd/core/drive_values.hpp"
#include "driveline/slaves/msd/core/object_checks.hpp"

namespace driveline::slaves::msd {
namespace {

using wire::SdoAbort;

constexpr std::uint32_t kSaveSignature = 0x65766173;  ///< "save", CiA 301 7.5.2.13
constexpr std::uint32_t kLoadSignature = 0x64616F6C;  ///< "load", CiA 301 7.5.2.14

SdoResult<void> require(bool condition, SdoAbort otherwise) noexcept {
  if (condition) return {};
  return tl::unexpected(otherwise);
}

}  // namespace

/// Returns false when the parameter file could not be written, which raises a fault.
bool DriveCore::store_parameters() {
  const bool stored = store_.store(dictionary_);
  if (!stored) raise(Fault::kParameterList);
  return stored;
}

SdoResult<void> DriveCore::accept(const EntryRow& row, std::uint64_t raw) {
  const bool checked = dictionary_.get(kValue.parameter_download) == 0;
  if (checked && !consistent_with(dictionary_, row, raw)) return tl::unexpected(SdoAbort::kParameterIncompatible);
  switch (row.slot) {
    // These writes save parameters and fail if saving fails (CiA 301 7.5.2.13: 0606 0000h).
    case kValue.store_command.number:
      if (raw != kSaveSignature) return tl::unexpected(SdoAbort::kCannotTransferOrStore);
      return require(store_parameters(), SdoAbort::kHardwareError);
    case kValue.restore_command.number:
      if (raw != kLoadSignature) return tl::unexpected(SdoAbort::kCannotTransferOrStore);
      store_.request_factory_reset();
      return require(store_parameters(), SdoAbort::kHardwareError);
    case kValue.save_parameters.number:
      return require(raw != 1 || store_parameters(), SdoAbort::kHardwareError);
    case kValue.parameter_download.number:
      return require(raw == 0 || motion_.standstill(), SdoAbort::kDeviceState);
    default:
      return require(possible_value(row, raw), SdoAbort::kValueRange);
  }
}

tl::expected<void, ParameterFileError> DriveCore::take_parameter_set(std::string_view text) {
  ObjectDictionary candidate = dictionary_;
  if (auto read = read_parameters(text, candidate); !read) return read;
  if (!parameters_consistent(candidate))
    return tl::unexpected(ParameterFileError{0, "the values contradict each other"});
  if (!store_.store(candidate)) {
    raise(Fault::kParameterList);
    return tl::unexpected(store_.error());
  }
  disturb();
  dictionary_.copy_backup_values(candidate);
  settings_changed_ = true;
  bus_->parameters_replaced();
  return {};
}

void DriveCore::written(const EntryRow& row) {
  if (is_string(row.type)) return;
  disturb();
  switch (row.slot) {
    case kValue.error_count.number:
      return dictionary_.set(kValue.last_error, 0U);
    case kValue.store_command.number:
      return dictionary_.set(kValue.store_command, 1U);
    case kValue.restore_command.number:
      return dictionary_.set(kValue.restore_command, 1U);
    case kValue.save_parameters.number:
      return;
    case kValue.factory_reset.number:
      if (dictionary_.get(kValue.factory_reset) == 1) store_.request_factory_reset();
      return dictionary_.set(kValue.factory_reset, std::uint8_t{0});
    case kValue.parameter_download.number:  // end of the download: check now
      if (dictionary_.get(kValue.parameter_download) == 0 && !parameters_consistent(dictionary_)) {
        raise(Fault::kParameterList);
      }
      return;
    case kValue.fault_reset_parameter.number:
      if (dictionary_.get(kValue.fault_reset_parameter) == 1) acknowledge();
      return dictionary_.set(kValue.fault_reset_parameter, std::uint8_t{0});
    default:
      break;
  }
  switch (control_.profile().written(row.slot)) {
    case DriveProfile::Effect::kCommand:
      return watch_fault_reset();
    case DriveProfile::Effect::kSetpoint:
      return control_.apply_setpoints();
    case DriveProfile::Effect::kPrepared:
      return control_.prepare_setpoints();
    case DriveProfile::Effect::kSetting:
    case DriveProfile::Effect::kNone:
      break;
  }
  settings_changed_ = true;
}

}  // namespace driveline::slaves::msd
