#include "driveline/ecat_master/configuration/idn_mapping.hpp"

#include <algorithm>
#include <cstdint>
#include <utility>
#include <vector>

#include "driveline/ecat_master/configuration/pdo_discovery.hpp"
#include "driveline/ecat_master/soe/soe_client.hpp"

namespace driveline::ecat_master {
namespace {

constexpr std::uint8_t kMaxDrives = 8;
constexpr std::uint8_t kWordBits = 16;

/// Reads the content of the same list of several drives.
class ListReader {
 public:
  ListReader(MailboxEngine& engine, std::uint16_t position, wire::Idn word, wire::Idn list)
      : soe_(engine, position), position_(position), word_(word) {
    pdo_.index = list.raw;
  }

  /// Returns false when the drive has no such list, or there is no such drive.
  Result<bool> append(std::uint8_t drive) {
    const auto idns = soe_.idn_list({drive, {pdo_.index}});
    if (!idns && (idns.error().is<facts::SoeRefused>() || idns.error().is<facts::MailboxError>())) return false;
    if (!idns) return tl::unexpected(idns.error());
    pdo_.objects.push_back({word_.raw, drive, kWordBits});
    for (const auto idn : *idns) {
      const auto attribute = soe_.attribute({drive, idn});
      if (!attribute) return tl::unexpected(attribute.error());
      if (attribute->list) return tl::unexpected(Error{facts::SoeContent{{drive, idn}, 0}, position_});
      pdo_.objects.push_back({idn.raw, drive, static_cast<std::uint8_t>(8 * attribute->element_size())});
    }
    return true;
  }
  /// Returns one PDO, or none when no drive has the list.
  [[nodiscard]] std::vector<motion::PdoMapping> take() {
    std::vector<motion::PdoMapping> pdos;
    if (!pdo_.objects.empty()) pdos.push_back(std::move(pdo_));
    return pdos;
  }

 private:
  SoeClient soe_;
  std::uint16_t position_;
  wire::Idn word_;
  motion::PdoMapping pdo_{};
};

}  // namespace

bool maps_by_idn(const esi::DeviceDescription& device) noexcept {
  return device.mailbox.soe && !device.mailbox.coe;
}

Result<motion::PdoConfiguration> read_idn_mapping(MailboxEngine& engine, const SlaveInfo& slave) {
  const auto channels = std::min(slave.description.mailbox.soe_channels, kMaxDrives);
  ListReader outputs(engine, slave.ref.position, kMasterControlWord, kMdtList);
  ListReader inputs(engine, slave.ref.position, kDriveStatusWord, kAtList);
  for (std::uint8_t drive = 0; drive < (channels != 0 ? channels : kMaxDrives); ++drive) {
    const auto takes = outputs.append(drive);
    if (!takes) return tl::unexpected(takes.error());
    const auto sends = inputs.append(drive);
    if (!sends) return tl::unexpected(sends.error());
    // The number of drives is unknown: the last drive has been read.
    if (channels == 0 && !*takes && !*sends) break;
  }
  motion::PdoConfiguration configuration{outputs.take(), inputs.take()};
  const bool none = configuration.outputs.empty() && configuration.inputs.empty();
  return none ? pdo_configuration_from_sii(slave.description) : std::move(configuration);
}

}  // namespace driveline::ecat_master
