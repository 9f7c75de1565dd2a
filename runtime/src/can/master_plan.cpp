#include "driveline/runtime/can/master_plan.hpp"

#include <algorithm>
#include <chrono>
#include <optional>

#include "driveline/motion/axis/startup_sdos.hpp"
#include "driveline/motion/drive/drive_objects.hpp"
#include "driveline/runtime/setup/composition.hpp"

namespace driveline::runtime {
namespace {

/// Heartbeats of the master, or their time in SYNCs, after which a drive takes the master for dead.
constexpr int kMissedHeartbeats = 3;
/// Watch of SYNC by drives without a consumer of heartbeats, where the master has no heartbeat.
constexpr std::chrono::milliseconds kStandardWatch{300};

/// Entries of an identity that are 0 are not known.
std::optional<std::uint32_t> known_value(std::uint32_t value) {
  return value == 0 ? std::nullopt : std::optional(value);
}

bool maps_object(const std::vector<canopen::PdoPlan>& pdos, std::uint16_t index) {
  return std::any_of(pdos.begin(), pdos.end(), [index](const canopen::PdoPlan& pdo) {
    return std::any_of(pdo.objects.begin(), pdo.objects.end(),
                       [=](const auto& object) { return object.index == index; });
  });
}

/// Returns the plan of a PDO of an axis; `sync`: it is due with every SYNC, otherwise when it changes.
canopen::PdoPlan plan_of_mapping(const motion::PdoMapping& mapping, std::uint16_t first, bool sync) {
  constexpr std::uint8_t kEvent = 255;
  canopen::PdoPlan pdo;
  pdo.number = static_cast<std::uint16_t>(mapping.index - first + 1);
  if (!sync) {
    pdo.transmission = kEvent;
    pdo.exchange = canopen::PdoExchange::kOnChange;
  }
  pdo.objects = mapping.objects;
  return pdo;
}

/// The RPDOs of an axis whose drive plans its motions: control word and mode, and targets as far as the device has
/// them.
std::vector<motion::PdoMapping> profile_rpdos(const SlaveDevice& device, motion::cia402::Mode mode) {
  constexpr motion::MappedObject kTargetPosition{0x607A, 0, 32};
  constexpr motion::MappedObject kProfileVelocity{0x6081, 0, 32};
  constexpr motion::MappedObject kTargetVelocity{0x60FF, 0, 32};
  std::vector<motion::PdoMapping> rpdos{{0x1600, {{0x6040, 0, 16}, {0x6060, 0, 8}}}};
  if (mode == motion::cia402::Mode::kProfileVelocity) {
    rpdos.push_back({0x1601, {kTargetVelocity}});
    return rpdos;
  }
  rpdos.push_back({0x1601, {kTargetPosition, kProfileVelocity}});
  const auto has = [&](std::uint16_t index) { return device.has_object(index).value_or(true); };
  if (has(kTargetVelocity.index) && has(0x1402)) rpdos.push_back({0x1602, {kTargetVelocity}});
  return rpdos;
}

/// The PDOs of an axis: the setpoint of an axis that follows any, and status word with position, go with every SYNC.
CanPdoConfig standard_axis_pdos(const SlaveDevice& device, motion::cia402::Mode mode) {
  constexpr std::uint16_t kFirstRpdo = 0x1600;
  constexpr std::uint16_t kFirstTpdo = 0x1A00;
  constexpr std::uint16_t kSetpoint = 0x1601;
  constexpr std::uint16_t kActual = 0x1A00;
  CanPdoConfig pdos;
  const auto& standard = motion::can_axis_pdo_configuration();
  const bool follows = motion::cia402::by_position(mode);
  for (const auto& pdo : follows ? standard.outputs : profile_rpdos(device, mode)) {
    pdos.rpdos.push_back(plan_of_mapping(pdo, kFirstRpdo, follows && pdo.index == kSetpoint));
  }
  for (const auto& pdo : standard.inputs) {
    pdos.tpdos.push_back(plan_of_mapping(pdo, kFirstTpdo, pdo.index == kActual));
  }
  return pdos;
}

void plan_node_pdos(const LineConfig& config, std::size_t number, canopen::NodePlan& node) {
  const auto& slave = config.slaves[number];
  if (slave.can.pdos) {
    node.rpdos = slave.can.pdos->rpdos;
    node.tpdos = slave.can.pdos->tpdos;
    return;
  }
  const auto axes = axes_of_slave(config, number);
  if (axes.size() != 1 || axes.front()->drive != 0 || slave.device->keeps_own_pdos()) return;
  auto pdos = standard_axis_pdos(*slave.device, axes.front()->mode);
  node.rpdos = std::move(pdos.rpdos);
  node.tpdos = std::move(pdos.tpdos);
}

/// How node and master notice that the other one is gone. A drive that consumes no heartbeat watches SYNC, if it can.
void plan_error_control(const LineConfig& config, const SlaveConfig& slave, canopen::NodePlan& node) {
  const auto& can = *config.can;
  const auto& rules = drive_rules(config, slave);
  auto& control = node.error_control;
  control.heartbeat = slave.can.heartbeat;
  control.guard_time = slave.can.guard_time;
  const bool consumes = rules.consumes_heartbeat() && slave.device->has_object(0x1016).value_or(true);
  const auto limit = kMissedHeartbeats * can.master_heartbeat;
  if (consumes && slave.can.guard_time.count() == 0) control.master_tolerance = limit;
  const auto watch = limit.count() > 0 ? limit : kStandardWatch;
  const auto sdos = rules.sync_watch_sdos(std::max<std::chrono::milliseconds>(
      watch, std::chrono::ceil<std::chrono::milliseconds>(kMissedHeartbeats * config.period)));
  node.startup_sdos.insert(node.startup_sdos.end(), sdos.begin(), sdos.end());
}

canopen::NodePlan node_plan_of(const LineConfig& config, std::size_t number) {
  const auto& slave = config.slaves[number];
  canopen::NodePlan node;
  node.name = slave.name;
  node.id = slave.can.node;
  const auto identity = expected_identity(slave);
  node.vendor_id = known_value(identity.vendor_id);
  node.product_code = known_value(identity.product_code);
  node.revision = slave.can.revision;
  node.serial_number = slave.can.serial_number;
  node.timeouts = slave.can.timeouts;
  node.optional = slave.can.optional;
  plan_node_pdos(config, number, node);
  for (const auto* axis : axes_of_slave(config, number)) {
    auto sdos = axis_startup_sdos(config, *axis, maps_object(node.rpdos, 0x6060));
    // There is nothing to interpolate.
    if (motion::cia402::by_drive(axis->mode)) {
      std::erase_if(sdos, [](const motion::StartupSdo& sdo) {
        return motion::object_of_first_drive(sdo.index) == motion::kInterpolationTime;
      });
    }
    node.startup_sdos.insert(node.startup_sdos.end(), sdos.begin(), sdos.end());
  }
  plan_error_control(config, slave, node);
  node.startup_sdos.insert(node.startup_sdos.end(), slave.plan.sdos.begin(), slave.plan.sdos.end());
  return node;
}

}  // namespace

canopen::MasterPlan make_master_plan(const LineConfig& config) {
  const auto& can = *config.can;
  canopen::MasterPlan plan;
  plan.bit_rate = can.bit_rate;
  plan.period = config.period;
  plan.master_id = can.master_node;
  plan.master_heartbeat = can.master_heartbeat;
  for (std::size_t i = 0; i < config.slaves.size(); ++i) plan.nodes.push_back(node_plan_of(config, i));
  return plan;
}

}  // namespace driveline::runtime
