#include "driveline/canopen_master/plan_check.hpp"

#include <algorithm>
#include <set>

namespace driveline::canopen {
namespace {

using std::chrono::milliseconds;

constexpr milliseconds kLongestTime{0xFFFF};  ///< longest time in 100Ch, 1016h and 1017h
constexpr std::uint16_t kMostPdos = 512;
constexpr std::uint8_t kFirstAsynchronous = 254;

/// Collects the faults of a plan.
class PlanCheck {
 public:
  explicit PlanCheck(const MasterPlan& plan) : plan_(&plan) {}

  [[nodiscard]] NodeErrors run() {
    users_.insert(plan_->sync_identifier);
    for (const auto& node : plan_->nodes) users_.insert(static_cast<std::uint16_t>(predefined::kEmergency + node.id));
    for (node_ = 0; node_ < plan_->nodes.size(); ++node_) {
      check_node_id();
      check_error_control();
      check_startup();
      check_pdos(true);
      check_pdos(false);
    }
    return std::move(errors_);
  }

 private:
  [[nodiscard]] const NodePlan& node() const { return plan_->nodes[node_]; }

  NodeError& add(PlanFault fault) {
    NodeError error{NodeErrorKind::kBadPlan, node_, node().id};
    error.fault = fault;
    return errors_.emplace_back(error);
  }

  void check_node_id() {
    const auto id = node().id;
    if (id == 0 || id > kMaxNodeId) add(PlanFault::kNodeId).found = id;
    const bool twice = std::any_of(plan_->nodes.begin(), plan_->nodes.begin() + static_cast<std::ptrdiff_t>(node_),
                                   [&](const NodePlan& other) { return other.id == id; });
    if (twice || id == plan_->master_id) add(PlanFault::kNodeIdTwice).found = id;
  }

  void check_error_control() {
    const auto& control = node().error_control;
    if (control.heartbeat.count() > 0 && control.guard_time.count() > 0) add(PlanFault::kBothControls);
    for (const auto time : {control.heartbeat, control.guard_time, control.master_tolerance}) {
      if (time.count() < 0 || time > kLongestTime)
        add(PlanFault::kTime).found = static_cast<std::uint32_t>(time.count());
    }
    const bool impatient = control.tolerance.count() != 0 && control.tolerance <= control.heartbeat;
    if (control.heartbeat.count() > 0 && impatient) {
      auto& error = add(PlanFault::kTime);
      error.wanted = static_cast<std::uint32_t>(control.heartbeat.count());
      error.found = static_cast<std::uint32_t>(control.tolerance.count());
    }
    const auto own = plan_->master_heartbeat;
    if (control.master_tolerance.count() > 0 && (own.count() == 0 || own >= control.master_tolerance)) {
      auto& error = add(PlanFault::kMasterHeartbeat);
      error.wanted = static_cast<std::uint32_t>(control.master_tolerance.count());
      error.found = static_cast<std::uint32_t>(own.count());
    }
  }

  void check_startup() {
    for (const auto& sdo : node().startup_sdos) {
      if (sdo.complete) add(PlanFault::kCompleteAccess).object = {sdo.index, sdo.subindex};
    }
  }

  void check_pdos(bool rpdo) {
    const auto& pdos = rpdo ? node().rpdos : node().tpdos;
    for (std::size_t i = 0; i < pdos.size(); ++i) {
      check_pdo(pdos[i], rpdo);
      const bool twice = std::any_of(pdos.begin(), pdos.begin() + static_cast<std::ptrdiff_t>(i),
                                     [&](const PdoPlan& other) { return other.number == pdos[i].number; });
      if (twice) add(PlanFault::kPdoNumber, pdos[i], rpdo);
    }
  }

  NodeError& add(PlanFault fault, const PdoPlan& pdo, bool rpdo) {
    auto& error = add(fault);
    error.pdo = pdo.number;
    error.rpdo = rpdo;
    return error;
  }

  void check_pdo(const PdoPlan& pdo, bool rpdo) {
    if (pdo.number == 0 || pdo.number > kMostPdos) add(PlanFault::kPdoNumber, pdo, rpdo);
    std::uint32_t bits = 0;
    for (const auto& object : pdo.objects) bits += object.bits;
    if (bits > 8 * Frame::kMaxLength) add(PlanFault::kPdoTooLong, pdo, rpdo).found = bits;
    if (pdo.transmission > kLastSynchronous && pdo.transmission < kFirstAsynchronous) {
      add(PlanFault::kTransmission, pdo, rpdo).found = pdo.transmission;
    }
    const auto identifier = pdo_identifier(pdo, rpdo, node().id);
    const Identifier full{identifier};
    const bool used = !users_.insert(identifier).second;
    if (identifier == 0 || !full.valid() || is_restricted(full) || used) {
      add(PlanFault::kPdoIdentifier, pdo, rpdo).found = identifier;
    }
  }

  const MasterPlan* plan_;
  std::size_t node_ = 0;
  std::set<std::uint16_t> users_;  ///< identifiers of other messages
  NodeErrors errors_;
};

}  // namespace

NodeErrors check(const MasterPlan& plan) {
  return PlanCheck(plan).run();
}

}  // namespace driveline::canopen
