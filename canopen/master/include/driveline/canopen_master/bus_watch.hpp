#pragma once

#include <array>
#include <bitset>
#include <deque>

#include "driveline/canopen_master/master_event.hpp"
#include "driveline/canopen_master/node_plan.hpp"
#include "driveline/canopen_port/can_port.hpp"

namespace driveline::canopen {

/// Watches a bus for what no node of the plan sends: another master, strangers, and the state of the adapter.
class BusWatch {
 public:
  /// Least time between two events about the same sign of another master.
  static constexpr std::chrono::nanoseconds kRepeat = std::chrono::seconds{10};

  /// For the line of a plan.
  explicit BusWatch(const MasterPlan& plan);

  /// A frame has arrived. The frames of this master do not arrive (CanPort::receive()).
  void receive(const ReceivedFrame& received);
  /// What the adapter tells of the bus now.
  void look(const PortStatistics& statistics, std::chrono::nanoseconds now);
  /// The first sign of another master; empty: none was seen.
  [[nodiscard]] const std::optional<OtherMasterSign>& other_master() const noexcept { return other_; }
  /// The oldest event that was not taken; empty: none.
  [[nodiscard]] std::optional<MasterEvent> take_event();

 private:
  static constexpr std::size_t kSigns = 4;
  static constexpr std::size_t kIdentifiers = Identifier::kBaseMask + 1;

  [[nodiscard]] std::optional<OtherMasterSign> sign_of(std::uint32_t identifier) const noexcept;
  void look_for_stranger(std::uint32_t identifier, std::chrono::nanoseconds time);
  MasterEvent& tell(MasterEvent::Kind kind, std::chrono::nanoseconds time);

  std::uint32_t sync_identifier_;
  std::uint8_t master_id_;
  std::bitset<kIdentifiers> rpdos_;                                     ///< identifiers of the RPDOs of the plan
  std::bitset<kMaxNodeId + 1U> known_;                                  ///< node-IDs of the plan
  std::bitset<kMaxNodeId + 1U> strangers_;                              ///< node-IDs of strangers that were reported
  std::array<std::optional<std::chrono::nanoseconds>, kSigns> told_{};  ///< when, by sign
  std::optional<OtherMasterSign> other_;
  BusState state_ = BusState::kUnknown;
  bool down_ = false;
  std::deque<MasterEvent> events_;
};

}  // namespace driveline::canopen
