#include "soe_line.hpp"

#include <algorithm>
#include <optional>
#include <stdexcept>
#include <utility>

#include "drive_line.hpp"
#include "driveline/wire/soe.hpp"

namespace driveline::bus_test {

using slaves::generic::GenericDevice;

esi::DeviceDescription soe_device(std::uint16_t mailbox) {
  using Use = esi::SyncManager::Use;
  esi::DeviceDescription device;
  device.vendor_id = 0x1234;
  device.product_code = 0x0500 + std::uint32_t{mailbox};
  device.name = "SoE drive";
  device.type = "SoE drive";
  device.eeprom_config_data_hex = "050E000000000000000000000000";
  device.mailbox.coe = true;
  device.mailbox.soe = true;
  device.mailbox.soe_channels = 2;
  device.sync_managers = {{Use::kMailboxOut, 0x1000, mailbox, mailbox, mailbox, 0x26, true},
                          {Use::kMailboxIn, 0x1400, mailbox, mailbox, mailbox, 0x22, true}};
  return device;
}

std::vector<std::byte> as_list(std::span<const std::byte> content) {
  std::vector<std::byte> list(wire::SoeListHeader::kSize + content.size());
  const auto length = static_cast<std::uint16_t>(content.size());
  wire::SoeListHeader{length, length}.encode(std::span(list).first<wire::SoeListHeader::kSize>());
  std::copy(content.begin(), content.end(), list.begin() + wire::SoeListHeader::kSize);
  return list;
}

std::unique_ptr<slaves::SimulatedLine> SoeLine::make(const esi::DeviceDescription& device) {
  auto model = slaves::generic::DeviceModel::create(device);
  if (!model) throw std::runtime_error(describe(model.error()));
  std::vector<std::unique_ptr<slaves::Slave>> slaves;
  for (auto*& made : devices) {
    auto owned = std::make_unique<GenericDevice>(*model, slaves::generic::GenericOptions{});
    made = owned.get();
    slaves.push_back(std::make_unique<slaves::Slave>(std::move(owned), slaves::SlaveOptions{}));
  }
  return std::make_unique<slaves::SimulatedLine>(clock, std::move(slaves), slaves::LineOptions{}, std::nullopt);
}

std::string SoeLine::to_pre_op() {
  if (const auto found = master.scan(); !found) return sentence(found);
  return sentence(master.enter_pre_op());
}

}  // namespace driveline::bus_test
