#pragma once

#include <chrono>
#include <cstdint>
#include <string>
#include <vector>

#include "driveline/ecat_master/diagnosis/diagnosis.hpp"
#include "driveline/ecat_master/master.hpp"
#include "driveline/rt/clock.hpp"
#include "driveline/snapshot/feed/feed_condition.hpp"

namespace driveline::runtime {

/// Sets identity and position of a slave in `record`.
void set_identity(snapshot::FeedSlave& record, const ecat_master::ConfiguredSlave& slave);
/// Sets the register values of a slave in `record`; a slave that does not answer leaves them unchanged.
void set_registers(snapshot::FeedSlave& record, const ecat_master::SlaveDiagnosis& slave, std::int64_t wall_time_ns);
/// Sets the place of a slave in the topology in `record`; a slave that is not in `topology` has none.
void set_place(snapshot::FeedSlave& record, const ecat_master::Topology& topology, std::size_t slave);
/// Returns the data of the wiring that do not belong to one slave.
[[nodiscard]] snapshot::FeedConditionHead wiring_of(const ecat_master::Topology& topology);

/// Watches the slaves for the telemetry: reads their states, links and error counters, once per second and as soon as
/// the cycle shows that a slave has changed its state. Belongs to the thread that owns the master.
class SlaveWatch {
 public:
  /// Interval of the register readings while nothing changes.
  static constexpr std::chrono::seconds kPeriod{1};

  /// Both must outlive it.
  SlaveWatch(ecat_master::Master& master, rt::Clock& clock) : master_(master), clock_(clock) {}

  /// Reads the registers of all slaves at once, due or not. Slaves that cannot be read count as not answering.
  void read();
  /// Reads the registers if they are due. True: there are new data.
  [[nodiscard]] bool poll();
  /// Sets the owners of the axes, by axis number; empty: none. True: they have changed.
  [[nodiscard]] bool set_owners(const std::vector<std::string>& owners);
  /// Returns the present data.
  [[nodiscard]] const snapshot::FeedCondition& condition() const noexcept { return condition_; }

 private:
  [[nodiscard]] std::vector<std::uint32_t> states_in_cycle() const;
  void set_clocks();

  ecat_master::Master& master_;
  rt::Clock& clock_;
  snapshot::FeedCondition condition_;
  std::vector<std::uint32_t> seen_;  ///< result of states_in_cycle() at the last reading
  std::chrono::nanoseconds due_{0};
};

}  // namespace driveline::runtime
