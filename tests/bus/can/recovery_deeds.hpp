#pragma once

#include <chrono>
#include <cstdint>
#include <string>
#include <vector>

#include "driveline/canopen_master/master_event.hpp"
#include "driveline/slaves/msd/core/faults.hpp"

/// What was done to a CAN line, compared with what its master tells.
namespace driveline::bus_test {

/// What is done to a line.
enum class DeedKind : std::uint8_t {
  kPowerOff,        ///< a node without supply, which starts when it is back
  kNodeBusOff,      ///< a node is bus off until it is switched off and on
  kAdapterBusOff,   ///< the adapter of the master is bus off
  kHeartbeatLost,   ///< the master does not hear heartbeats and answers to guarding of a node
  kMasterUnheard,   ///< the nodes do not hear the heartbeat of the master
  kReset,           ///< another master resets a node, or its communication
  kStop,            ///< another master takes a node to Stopped
  kPreOperational,  ///< another master takes a node to Pre-operational
  kSilentSdo,       ///< the answers to SDO requests of a node that starts anew are lost
  kOtherDevice,     ///< another device has taken the place of a node
  kFault,           ///< a drive has a fault
  kCount,
};
inline constexpr std::size_t kDeedKinds = static_cast<std::size_t>(DeedKind::kCount);
[[nodiscard]] const char* to_text(DeedKind kind) noexcept;

/// A deed and its time.
struct Deed {
  DeedKind kind{};
  std::size_t node = 0;  ///< not of kAdapterBusOff and kMasterUnheard
  std::chrono::nanoseconds begin{};
  std::chrono::nanoseconds end{};
  slaves::msd::Fault fault{};  ///< kFault
};

/// The facts of a line that a deed may concern.
struct DeedNode {
  bool hears_master = false;  ///< consumes its heartbeat
  bool guarded = false;
};

/// Judges whether each event has its deed, with the true reason, and whether each deed that came alone was told.
class RecoveryDeeds {
 public:
  using History = std::vector<canopen::MasterEvent>;

  explicit RecoveryDeeds(std::vector<DeedNode> nodes) : nodes_(std::move(nodes)) {}

  void add(const Deed& deed) { deeds_.push_back(deed); }
  /// Whether something was done that has such an event as its consequence.
  [[nodiscard]] bool explains(const canopen::MasterEvent& event) const;
  /// Whether the events tell of this deed, beside which nothing else was done.
  [[nodiscard]] static bool told(const Deed& deed, const History& since);
  /// Names of all deeds, for findings.
  [[nodiscard]] std::string text() const;

 private:
  [[nodiscard]] bool explains(const Deed& deed, const canopen::MasterEvent& event) const;
  [[nodiscard]] bool explains_emergency(const Deed& deed, const canopen::MasterEvent& event) const;
  [[nodiscard]] static bool explains_failure(const Deed& deed, const canopen::NodeError& error);

  std::vector<DeedNode> nodes_;
  std::vector<Deed> deeds_;
};

}  // namespace driveline::bus_test
