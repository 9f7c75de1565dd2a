#include "driveline/slaves/msd/drive_files.hpp"

#include <algorithm>
#include <string>

#include "driveline/slaves/msd/core/firmware_image.hpp"

namespace driveline::slaves::msd {
namespace {

using wire::AlState;
using wire::FoeError;

tl::unexpected<FileRefusal> refused(FoeError code, std::string text) {
  return tl::unexpected(FileRefusal{code, std::move(text)});
}

tl::unexpected<FileRefusal> refused(FirmwareError error) {
  switch (error) {
    case FirmwareError::kNoHeader:
      return refused(FoeError::kNoFileHeader, "this is not a firmware file");
    case FirmwareError::kProduct:
      return refused(FoeError::kWrongFirmware, "the firmware is for another drive");
    case FirmwareError::kTooOld:
      return refused(FoeError::kIncompatible, "the firmware is older than this drive");
    case FirmwareError::kLength:
      return refused(FoeError::kIllegal, "the firmware is not as long as its header says");
    default:
      return refused(FoeError::kWrongChecksum, "the firmware is damaged");
  }
}

}  // namespace

FileAnswer<DriveFiles::Kind> DriveFiles::find(const FileRequest& request) const {
  if (password_ != 0 && request.password != password_) return refused(FoeError::kNoRights, "wrong password");
  const bool boot = request.state == AlState::kBootstrap;
  if (request.name.ends_with(kFirmwareSuffix)) {
    if (!boot) return refused(FoeError::kBootstrapOnly, "firmware is accepted in BOOT only");
    return Kind::kFirmware;
  }
  if (request.name != kParameterSet)
    return refused(FoeError::kNotFound, "the drive has parameters.txt and accepts *.efw");
  if (boot) return refused(FoeError::kNotBootstrap, "only firmware is accepted in BOOT");
  return Kind::kParameterSet;
}

FileAnswer<std::vector<std::byte>> DriveFiles::read_file(const FileRequest& request) {
  const auto kind = find(request);
  if (!kind) return tl::unexpected(kind.error());
  if (*kind == Kind::kFirmware) return refused(FoeError::kAccessDenied, "firmware cannot be read back");
  const auto text = core_->parameter_set();
  const auto bytes = std::as_bytes(std::span(text));
  return std::vector<std::byte>(bytes.begin(), bytes.end());
}

FileAnswer<std::size_t> DriveFiles::open_file(const FileRequest& request) {
  const auto kind = find(request);
  if (!kind) return tl::unexpected(kind.error());
  if (core_->power_stage_on()) return refused(FoeError::kAccessDenied, "the power stage is on");
  if (*kind == Kind::kFirmware) return kMaxFirmware;
  if (request.state != AlState::kPreOp)
    return refused(FoeError::kAccessDenied, "parameters can be written in PREOP only");
  return kMaxParameterSet;
}

FileAnswer<void> DriveFiles::write_file(const FileRequest& request, std::span<const std::byte> content) {
  // State and power stage may have changed in the meantime.
  if (const auto allowed = open_file(request); !allowed) return tl::unexpected(allowed.error());
  return request.name == kParameterSet ? write_parameters(content) : write_firmware(content);
}

FileAnswer<void> DriveFiles::write_firmware(std::span<const std::byte> content) {
  const auto version = check_firmware(content, core_->variant());
  if (!version) return refused(version.error());
  core_->install_firmware(*version);
  kept_at_ = core_->running_time() + flash_time_;
  return {};
}

FileAnswer<void> DriveFiles::write_parameters(std::span<const std::byte> content) {
  std::string text(content.size(), '\0');
  std::transform(content.begin(), content.end(), text.begin(), [](std::byte byte) { return static_cast<char>(byte); });
  const auto taken = core_->take_parameter_set(text);
  if (taken) return {};
  const auto& [line, what] = taken.error();
  return refused(FoeError::kIllegal, line == 0 ? what : "line " + std::to_string(line) + ": " + what);
}

std::optional<wire::FoeBusy> DriveFiles::busy() const noexcept {
  const auto left = kept_at_ - core_->running_time();
  if (left.count() <= 0) return std::nullopt;
  constexpr std::uint16_t kEntire = 100;
  return wire::FoeBusy{static_cast<std::uint16_t>(kEntire - kEntire * left.count() / flash_time_.count()), kEntire};
}

}  // namespace driveline::slaves::msd
