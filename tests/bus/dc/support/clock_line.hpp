#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "dc/bring_up.hpp"
#include "driveline/ecat_master/master.hpp"
#include "driveline/rt/clock.hpp"
#include "driveline/slaves/line/line.hpp"

namespace driveline::bus_test {

using std::chrono::microseconds;
using std::chrono::milliseconds;
using std::chrono::nanoseconds;
using std::chrono::seconds;

/// A slave that is of interest for its clock only.
struct ClockSpec {
  bool clock = true;
  bool wide = true;
  nanoseconds start{0};  ///< what its clock shows at time zero
  double ppm = 0.0;      ///< how much too fast it runs
  nanoseconds resolution{10};
  nanoseconds jitter{0};  ///< of receive times, either way
  /// Its speed wanders by up to 20 ppm around `ppm`, that fast.
  double temperature_ppm_per_s = 0.0;
};

/// `count` clocks with any start and up to +-`ppm`.
[[nodiscard]] std::vector<ClockSpec> random_clocks(std::size_t count, double ppm, unsigned seed = 1);

/// A simulated line of slaves with clocks, whose true times are known, and a master's way to them. Slaves are numbered
/// as in the wiring; positions are those on the line.
class ClockLine {
 public:
  explicit ClockLine(const std::vector<ClockSpec>& specs, std::optional<slaves::Wiring> wiring = std::nullopt,
                     const slaves::LineOptions& options = {}, nanoseconds now = milliseconds{1});

  /// Station addresses, topology, all in PREOP, through `port` (the line itself unless told otherwise).
  void open(port::Port* port = nullptr);
  /// The plan in which every slave with a clock has SYNC0 with the master's cycle.
  [[nodiscard]] ecat_master::dc::ClockPlan plan(nanoseconds period = microseconds{125}) const;
  [[nodiscard]] ecat_master::Result<ecat_master::dc::LineClocks> bring_up(const ecat_master::dc::ClockPlan& plan);

  /// True time a frame takes from the processing unit at position `from` to that at `to`, as the clock at `from`
  /// counts.
  [[nodiscard]] double true_delay(std::size_t from, std::size_t to) const;
  /// From the master to the processing unit at a position.
  [[nodiscard]] nanoseconds passing(std::size_t position) const { return passing_[position]; }
  /// The same when the line was opened.
  [[nodiscard]] nanoseconds planned_passing(std::size_t position) const { return planned_[position]; }
  /// To be called when slaves have lost their supply: frames take another way.
  void retrace();
  /// The local copy of the system time at a position, now.
  [[nodiscard]] std::uint64_t system_time(std::size_t position);
  /// By how much the clock at a position is ahead of that at `reference`, now, in the lower 32 bits.
  [[nodiscard]] nanoseconds ahead(std::size_t position, std::size_t reference);
  [[nodiscard]] slaves::Slave& slave(std::size_t position) { return line_->slave(numbers_[position]); }
  [[nodiscard]] const ClockSpec& spec(std::size_t position) const { return specs_[numbers_[position]]; }
  [[nodiscard]] std::size_t size() const { return specs_.size(); }

  rt::VirtualClock clock;
  [[nodiscard]] slaves::Line& line() { return *line_; }
  [[nodiscard]] ecat_master::Master& master() { return *master_; }
  [[nodiscard]] const std::vector<ecat_master::SlaveRef>& refs() const { return refs_; }

 private:
  std::vector<ClockSpec> specs_;
  slaves::LineOptions options_;
  slaves::Wiring wiring_;
  std::unique_ptr<slaves::Line> line_;
  std::unique_ptr<ecat_master::Master> master_;
  std::vector<ecat_master::SlaveRef> refs_;
  std::vector<std::size_t> numbers_;  ///< slave of the wiring by position
  std::vector<nanoseconds> passing_;  ///< when a frame is processed, by position
  std::vector<nanoseconds> planned_;
};

}  // namespace driveline::bus_test
