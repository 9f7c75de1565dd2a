#include "can/node_feed.hpp"

#include <fmt/format.h>

#include "driveline/motion/cia402/error_code.hpp"
#include "driveline/wire/al.hpp"
#include "telemetry/feed_owners.hpp"

namespace driveline::runtime {
namespace {

using canopen::NmtState;
using canopen::NodePhase;
using canopen::NodeView;
using snapshot::FeedSlave;
using wire::AlState;

constexpr std::chrono::seconds kFeedInterval{1};

std::int64_t wall_clock_ns() {
  return std::chrono::duration_cast<std::chrono::nanoseconds>(std::chrono::system_clock::now().time_since_epoch())
      .count();
}

bool is_on_bus(const NodeView& node) noexcept {
  return node.phase != NodePhase::kNotSeen && node.phase != NodePhase::kLost;
}

AlState feed_state_of(const NodeView& node) noexcept {
  if (node.phase == NodePhase::kOperational) return AlState::kOp;
  if (!node.state) return AlState::kInit;
  switch (*node.state) {
    case NmtState::kOperational:
      return AlState::kOp;
    case NmtState::kStopped:
      return AlState::kSafeOp;
    case NmtState::kPreOperational:
      return AlState::kPreOp;
    default:
      return AlState::kInit;
  }
}

FeedSlave feed_record_of(const canopen::NodePlan& plan, const NodeView& node, std::int64_t now_ns) {
  FeedSlave record;
  record.name.set(plan.name);
  record.device.set(fmt::format("node {}", plan.id));
  record.vendor_id = node.identity.vendor_id.value_or(0);
  record.product_code = node.identity.product_code.value_or(0);
  record.revision = node.identity.revision.value_or(0);
  record.serial_number = node.identity.serial_number.value_or(0);
  record.station = plan.id;
  record.hot_connect = plan.optional ? 1 : 0;
  record.answers = is_on_bus(node) ? 1 : 0;
  record.al_state = static_cast<std::uint8_t>(feed_state_of(node));
  record.read_at_ns = now_ns;
  if (!node.emergency || node.emergency->code == 0) return record;
  record.al_error = 1;
  record.al_status_code = node.emergency->code;
  record.al_text.set(motion::cia402::error_text(node.emergency->code));
  return record;
}

}  // namespace

bool NodeFeed::poll(bool now) {
  std::vector<unsigned> seen;
  const auto& nodes = master_.plan().nodes;
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    const auto& node = master_.node(i);
    seen.push_back(static_cast<unsigned>(node.phase) << 16 | static_cast<unsigned>(feed_state_of(node)) << 8 |
                   static_cast<unsigned>(node.emergencies & 0xFFU));
  }
  if (!now && seen == seen_ && clock_.now() < due_) return false;
  seen_ = std::move(seen);
  due_ = clock_.now() + kFeedInterval;
  condition_.slaves.clear();
  const auto time = wall_clock_ns();
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    condition_.slaves.push_back(feed_record_of(nodes[i], master_.node(i), time));
    condition_.slaves.back().parent = snapshot::kFeedParentMaster;
  }
  return true;
}

bool NodeFeed::set_owners(const std::vector<std::string>& owners) {
  return set_feed_owners(owners, condition_);
}

}  // namespace driveline::runtime
