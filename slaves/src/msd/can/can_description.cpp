#include <string>

#include "driveline/slaves/canopen/device_options.hpp"
#include "driveline/slaves/msd/can/can_table.hpp"
#include "msd/object_description.hpp"

namespace driveline::slaves::msd {
namespace {

/// The PDOs from this mapping object on, which are empty from the factory (MSD manual 8.3.3).
std::vector<esi::Pdo> empty_can_pdos(std::uint16_t first, std::string_view name) {
  std::vector<esi::Pdo> pdos(kCanPdos);
  for (std::size_t i = 0; i < pdos.size(); ++i) {
    pdos[i].index = static_cast<std::uint16_t>(first + i);
    pdos[i].name = name;
  }
  return pdos;
}

}  // namespace

esi::EdsFile can_description(Variant variant) {
  const VariantFacts& facts = msd::facts(variant);
  const DictionaryTable& table = can_dictionary_table(variant);
  esi::EdsFile file;
  file.device.vendor_id = kVendorId;
  file.device.vendor_name = "Moog";
  file.device.product_code = facts.product_code;
  file.device.revision = facts.revision;
  file.device.type = facts.type;
  file.device.name = std::string(facts.device_name) + " (simulated)";
  file.device.objects = describe_objects(table);
  file.device.rx_pdos = empty_can_pdos(0x1600, "RxPDO mapping");
  file.device.tx_pdos = empty_can_pdos(0x1A00, "TxPDO mapping");
  const cia301::DeviceOptions options;
  for (const cia301::Address& address : options.node_relative) {
    if (table.find(address.index, address.subindex) != nullptr) {
      file.node_id_defaults.push_back({address.index, address.subindex});
    }
  }
  file.bit_rates.assign(kCanBitRates.begin(), kCanBitRates.end());
  return file;
}

}  // namespace driveline::slaves::msd
