#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "dc/bring_up.hpp"
#include "driveline/ecat_master/master.hpp"
#include "driveline/rt/clock.hpp"
#include "driveline/slaves/line/simulated_line.hpp"

namespace driveline::bus_test {

using std::chrono::microseconds;
using std::chrono::milliseconds;
using std::chrono::nanoseconds;
using std::chrono::seconds;

/// A slave that matters only for its clock.
struct ClockSpec {
  bool clock = true;
  bool wide = true;
  nanoseconds start{0};  ///< value of the clock at time zero
  double ppm = 0.0;      ///< deviation of the clock; positive: too fast
  nanoseconds resolution{10};
  nanoseconds jitter{0};  ///< jitter of receive times, plus and minus
  /// Rate at which the frequency drifts, by up to 20 ppm around `ppm`.
  double temperature_ppm_per_s = 0.0;
};

/// `count` clocks with random starts and deviations of up to +-`ppm`.
[[nodiscard]] std::vector<ClockSpec> random_clocks(std::size_t count, double ppm, unsigned seed = 1);

/// A simulated line of slaves with clocks whose true times are known, and a master for it. Slaves are numbered as in
/// the wiring; positions are positions on the line.
class ClockLine {
 public:
  explicit ClockLine(const std::vector<ClockSpec>& specs, std::optional<slaves::Wiring> wiring = std::nullopt,
                     const slaves::LineOptions& options = {}, nanoseconds now = milliseconds{1});

  /// Sets station addresses, reads the topology and takes all slaves to PREOP, through `port` (null: the line itself).
  void open(port::Port* port = nullptr);
  /// A clock plan that gives every slave with a clock a SYNC0 in the master's cycle.
  [[nodiscard]] ecat_master::dc::ClockPlan plan(nanoseconds period = microseconds{125}) const;
  [[nodiscard]] ecat_master::Result<ecat_master::dc::LineClocks> bring_up(const ecat_master::dc::ClockPlan& plan);

  /// True time of a frame from the processing unit at position `from` to the one at `to`, as counted by the clock at
  /// `from`.
  [[nodiscard]] double true_delay(std::size_t from, std::size_t to) const;
  /// True time of a frame from the master to the processing unit at a position.
  [[nodiscard]] nanoseconds passing(std::size_t position) const { return passing_[position]; }
  /// The same at the time when the line was opened.
  [[nodiscard]] nanoseconds planned_passing(std::size_t position) const { return planned_[position]; }
  /// To be called after slaves have lost their supply, because frames then take another path.
  void retrace();
  /// The present local copy of the system time at a position.
  [[nodiscard]] std::uint64_t system_time(std::size_t position);
  /// Present lead of the clock at a position over the one at `reference`, in the lower 32 bits.
  [[nodiscard]] nanoseconds ahead(std::size_t position, std::size_t reference);
  [[nodiscard]] slaves::Slave& slave(std::size_t position) { return line_->slave(numbers_[position]); }
  [[nodiscard]] const ClockSpec& spec(std::size_t position) const { return specs_[numbers_[position]]; }
  [[nodiscard]] std::size_t size() const { return specs_.size(); }

  rt::VirtualClock clock;
  [[nodiscard]] slaves::SimulatedLine& line() { return *line_; }
  [[nodiscard]] ecat_master::Master& master() { return *master_; }
  [[nodiscard]] const std::vector<ecat_master::SlaveRef>& refs() const { return refs_; }

 private:
  std::vector<ClockSpec> specs_;
  slaves::LineOptions options_;
  slaves::Wiring wiring_;
  std::unique_ptr<slaves::SimulatedLine> line_;
  std::unique_ptr<ecat_master::Master> master_;
  std::vector<ecat_master::SlaveRef> refs_;
  std::vector<std::size_t> numbers_;  ///< number of the slave in the wiring, by position
  std::vector<nanoseconds> passing_;  ///< time until a frame is processed, by position
  std::vector<nanoseconds> planned_;
};

}  // namespace driveline::bus_test
