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

esi::DeviceDescription drive_by_idn() {
  using Use = esi::SyncManager::Use;
  auto device = soe_device(128);
  device.mailbox.coe = false;
  device.sync_managers.push_back({Use::kOutputs, 0x1800, 0, 0, 0, 0x64, true});
  device.sync_managers.push_back({Use::kInputs, 0x1C00, 0, 0, 0, 0x20, true});
  return device;
}

std::vector<std::byte> as_list(std::span<const std::byte> content) {
  std::vector<std::byte> list(wire::SoeListHeader::kSize + content.size());
  const auto length = static_cast<std::uint16_t>(content.size());
  wire::SoeListHeader{length, length}.encode(std::span(list).first<wire::SoeListHeader::kSize>());
  std::copy(content.begin(), content.end(), list.begin() + wire::SoeListHeader::kSize);
  return list;
}

std::unique_ptr<slaves::SimulatedLine> SoeLine::make(const esi::DeviceDescription& device,
                                                     const std::vector<slaves::generic::SoeRule>& rules) {
  auto model = slaves::generic::DeviceModel::create(device);
  if (!model) throw std::runtime_error(describe(model.error()));
  std::vector<std::unique_ptr<slaves::Slave>> made;
  for (std::size_t i = 0; i < devices.size(); ++i) {
    slaves::generic::GenericOptions options;
    if (i == 1) options.soe_rules = rules;
    auto owned = std::make_unique<GenericDevice>(*model, options);
    devices.at(i) = owned.get();
    made.push_back(std::make_unique<slaves::Slave>(std::move(owned), slaves::SlaveOptions{}));
    stations.at(i) = made.back().get();
  }
  return std::make_unique<slaves::SimulatedLine>(clock, std::move(made), slaves::LineOptions{}, std::nullopt);
}

std::string SoeLine::to_pre_op() {
  if (const auto found = master.scan(); !found) return sentence(found);
  return sentence(master.enter_pre_op());
}

std::string SoeLine::to_safe_op(std::vector<ecat_master::SlavePlan> plans) {
  if (const auto found = master.scan(); !found) return sentence(found);
  return sentence(master.configure(std::move(plans)));
}

std::string SoeLine::to_op() {
  const auto started = master.start_cycle(nullptr, {}, {}, [this](ecat_master::CyclicCore& core) {
    return std::make_unique<motion::InlineRunner>(core, clock);
  });
  return started ? sentence(master.go_operational()) : started.error().message();
}

}  // namespace driveline::bus_test
