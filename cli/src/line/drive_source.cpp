#include "line/drive_source.hpp"

#include <fmt/format.h>

#include "driveline/ecat_master/error.hpp"

namespace driveline::cli {
namespace {

using wire::SdoAbort;

constexpr std::uint16_t kDriveProfile = 402;

}  // namespace

Outcome<void> check_device_type(std::size_t position, const DriveValues& values) {
  const auto type = values.bits(DriveObject::kDeviceType);
  if (!type) return failed(fmt::format("slave {} is not a servo drive: it has no device type, object 1000h", position));
  if ((*type & 0xFFFF) == kDriveProfile) return {};
  return failed(
      fmt::format("slave {} is not a servo drive: its device type 1000h is 0x{:08X}, profile 402 in the low word is "
                  "expected",
                  position, *type));
}

tl::unexpected<Failure> no_fault_reset(std::size_t position) {
  return failed(
      fmt::format("slave {} has no parameter P 153 (2099h); only its master can acknowledge faults, with bit 7 of the "
                  "control word",
                  position));
}

bool never_served(const ecat_master::Error& error) noexcept {
  const auto* abort = error.as<ecat_master::facts::SdoAbort>();
  if (abort == nullptr) return false;
  return abort->code == SdoAbort::kObjectDoesNotExist || abort->code == SdoAbort::kSubindexDoesNotExist ||
         abort->code == SdoAbort::kWriteOnly || abort->code == SdoAbort::kUnsupportedAccess;
}

}  // namespace driveline::cli
