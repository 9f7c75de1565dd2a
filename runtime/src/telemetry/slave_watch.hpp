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

/// Puts identity and place of a slave into `record`.
void set_identity(snapshot::FeedSlave& record, const ecat_master::ConfiguredSlave& slave);
/// Puts what its registers tell into `record`; a slave that does not answer leaves them as they were.
void set_registers(snapshot::FeedSlave& record, const ecat_master::SlaveDiagnosis& slave, std::int64_t wall_time_ns);
/// Puts its place in the line into `record`; a slave that `topology` does not know has none.
void set_place(snapshot::FeedSlave& record, const ecat_master::Topology& topology, std::size_t slave);
/// What of the wiring is not of one slave.
[[nodiscard]] snapshot::FeedConditionHead wiring_of(const ecat_master::Topology& topology);

/// Looks after the slaves for who reads the telemetry: reads their states, links and error counters, once in a second
/// and as soon as the cycle shows that one has changed its state. Belongs to the thread that owns the master.
class SlaveWatch {
 public:
  /// Between two readings of the registers while nothing changes.
  static constexpr std::chrono::seconds kPeriod{1};

  /// Both must outlive it.
  SlaveWatch(ecat_master::Master& master, rt::Clock& clock) : master_(master), clock_(clock) {}

  /// Reads the registers of all slaves, whether they are due or not. Slaves that cannot be read do not answer.
  void read();
  /// The same when they are due. True: there is something to tell.
  [[nodiscard]] bool look();
  /// Who commands the axes, by their number; empty: nobody. True: that is new.
  [[nodiscard]] bool set_owners(const std::vector<std::string>& owners);
  /// What is known.
  [[nodiscard]] const snapshot::FeedCondition& condition() const noexcept { return condition_; }

 private:
  [[nodiscard]] std::vector<std::uint32_t> states_in_cycle() const;
  void set_clocks();

  ecat_master::Master& master_;
  rt::Clock& clock_;
  snapshot::FeedCondition condition_;
  std::vector<std::uint32_t> seen_;  ///< states_in_cycle() at the last reading
  std::chrono::nanoseconds due_{0};
};

}  // namespace driveline::runtime
