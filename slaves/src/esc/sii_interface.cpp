#include "driveline/slaves/esc/sii_interface.hpp"

#include <utility>

#include "driveline/esi/sii.hpp"
#include "driveline/wire/sii_access.hpp"

namespace driveline::slaves {

namespace reg = wire::reg;
namespace sii = wire::sii_access;

namespace {

constexpr std::size_t kAliasWord = 4;
constexpr std::size_t kChecksumWord = 7;
/// This value as the checksum disables the check (ESC data sheet I, SII EEPROM).
constexpr std::uint16_t kCheckDisabled = 0x88A4;
constexpr std::uint16_t kErrors = sii::kErrorNotLoaded | sii::kErrorAcknowledge | sii::kErrorWriteEnable;
/// EEPROMs above 16 kbit have two address bytes.
constexpr std::size_t kOneAddressByteLimit = 2048;

}  // namespace

SiiInterface::SiiInterface(EscMemory& memory, std::vector<std::byte> image, const SiiOptions& options)
    : memory_(memory), image_(std::move(image)), options_(options) {
  if (image_.size() % 2 != 0) image_.push_back(std::byte{0xFF});
}

void SiiInterface::reset() noexcept {
  busy_ = false;
  unsigned status = options_.reads_8_bytes ? sii::kReads8Bytes : 0U;
  if (image_.size() > kOneAddressByteLimit) status |= sii::kTwoByteAddress;
  memory_.set(reg::kSiiControl, static_cast<std::uint16_t>(status));
  load_configuration(true);
}

void SiiInterface::load_configuration(bool power_on) noexcept {
  ++loads_;
  const auto checksum = word(kChecksumWord);
  constexpr std::size_t kArea = esi::SiiConfigArea::kSize;
  loaded_ = image_.size() > kArea &&
            (checksum == kCheckDisabled || (checksum & 0xFF) == esi::sii_checksum(std::span(image_).first<kArea>()));
  if (!loaded_) {
    set_status(0, sii::kErrorChecksum | sii::kErrorNotLoaded);
    return;
  }
  set_status(sii::kErrorChecksum | sii::kErrorNotLoaded, 0);
  memory_.set(reg::kPdiControl, static_cast<std::uint8_t>(word(0) & 0xFF));
  memory_.set(reg::kEscConfiguration, static_cast<std::uint8_t>(word(0) >> 8));
  memory_.set(reg::kPdiConfiguration, static_cast<std::uint8_t>(word(1) & 0xFF));
  memory_.set(reg::kSyncLatchConfiguration, static_cast<std::uint8_t>(word(1) >> 8));
  memory_.set(reg::kSyncPulseLength, word(2));
  memory_.set(reg::kPdiConfigurationExtended, word(3));
  // The alias is loaded at power-on only (ESC data sheet II, 0x0012).
  if (power_on) memory_.set(reg::kStationAlias, word(kAliasWord));
}

bool SiiInterface::owned_by(Side side) const noexcept {
  const bool offered = (memory_.get(reg::kSiiConfiguration) & sii::kConfigPdiOwns) != 0;
  const bool taken = (memory_.get(reg::kSiiPdiAccess) & 1U) != 0;
  return side == Side::kEcat ? !offered && !taken : offered && taken;
}

bool SiiInterface::write_ownership(Side side, std::size_t address, std::byte value) noexcept {
  const auto raw = std::to_integer<unsigned>(value);
  if (address == reg::kSiiConfiguration.address && side == Side::kEcat) {
    memory_.set(reg::kSiiConfiguration, static_cast<std::uint8_t>(raw & (sii::kConfigPdiOwns | sii::kConfigForceEcat)));
    if ((raw & sii::kConfigForceEcat) != 0) memory_.set(reg::kSiiPdiAccess, 0);
    return true;
  }
  if (address == reg::kSiiPdiAccess.address && side == Side::kPdi) {
    // The PDI may take over the EEPROM only while ECAT offers it and does not force its own access.
    if (memory_.get(reg::kSiiConfiguration) == sii::kConfigPdiOwns || (raw & 1U) == 0) {
      memory_.set(reg::kSiiPdiAccess, static_cast<std::uint8_t>(raw & 1U));
    }
    return true;
  }
  return false;
}

bool SiiInterface::write_registers(Side side, std::size_t address, std::span<const std::byte> data,
                                   Nanoseconds now) noexcept {
  refresh(now);
  const std::size_t control_address = reg::kSiiControl.address;
  bool any = false;
  bool commanded = false;
  std::uint16_t control = 0;
  for (std::size_t i = 0; i < data.size(); ++i) {
    const std::size_t target = address + i;
    if (target < control_address) {
      any |= write_ownership(side, target, data[i]);
      continue;
    }
    if (!owned_by(side) || busy_) continue;
    any = true;
    if (target < control_address + 2) {
      control =
          static_cast<std::uint16_t>(control | std::to_integer<unsigned>(data[i]) << 8 * (target - control_address));
      commanded |= target == control_address + 1;
    } else {
      memory_.at(target, 1)[0] = data[i];
    }
  }
  // The command bits are in the second byte; a write of the first byte only (write enable) starts no command.
  if (commanded) start(control, now);
  return any;
}

void SiiInterface::start(std::uint16_t control, Nanoseconds now) noexcept {
  command_ = control & sii::kCommandMask;
  set_status(kErrors, 0);
  if (command_ == 0) return;
  const bool known = command_ == sii::kCommandRead || command_ == sii::kCommandWrite || command_ == sii::kCommandReload;
  if (!known) return set_status(0, sii::kErrorAcknowledge);
  if (command_ == sii::kCommandWrite && (control & sii::kWriteEnable) == 0)
    return set_status(0, sii::kErrorWriteEnable);
  busy_ = true;
  done_at_ = now + options_.busy_time;
  set_status(0, static_cast<std::uint16_t>(sii::kBusy | command_));
  refresh(now);
}

void SiiInterface::complete() noexcept {
  busy_ = false;
  set_status(sii::kBusy | sii::kCommandMask, 0);
  const std::size_t address = memory_.get(reg::kSiiAddress);
  if (command_ == sii::kCommandReload) return load_configuration(false);
  if (command_ == sii::kCommandWrite) {
    const auto data = memory_.at(reg::kSiiData.address, 2);
    if (address < image_.size() / 2) {
      image_[2 * address] = data[0];
      image_[2 * address + 1] = data[1];
      ++revision_;
    }
    return;
  }
  const unsigned words = options_.reads_8_bytes ? 4 : 2;
  for (unsigned i = 0; i < words; ++i) {
    bytes::store_le(memory_.at(reg::kSiiData.address + 2 * i, 2), word(address + i));
  }
}

std::uint16_t SiiInterface::word(std::size_t address) const noexcept {
  if (address >= image_.size() / 2) return 0xFFFF;
  return bytes::load_le<std::uint16_t>(std::span(image_).subspan(2 * address));
}

void SiiInterface::set_status(std::uint16_t clear, std::uint16_t set) noexcept {
  memory_.set(reg::kSiiControl, static_cast<std::uint16_t>((memory_.get(reg::kSiiControl) & ~unsigned{clear}) | set));
}

}  // namespace driveline::slaves
