#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "bus/absence_watch.hpp"
#include "bus/line_motion.hpp"
#include "driveline/rt/clock.hpp"
#include "driveline/runtime/config/line_config.hpp"
#include "driveline/runtime/event/event.hpp"

namespace driveline::runtime {

/// What [recovery] makes of losses, on any bus: absences of the master, failures of the motion, and slaves that do not
/// return. Belongs to the thread that supervises the line.
class LossWatch {
 public:
  /// What may become of a slave.
  struct Losable {
    bool hot_connect = false;  ///< may be missing for any time
  };
  /// Parts of the line; all pointees must outlive the watch.
  struct Parts {
    const LineConfig* config = nullptr;  ///< never null
    rt::Clock* clock = nullptr;          ///< never null
    LineMotion* motion = nullptr;        ///< null: no axes are moved
    AbsenceWatch::Take take_absence;     ///< takes absences of the master from the cycle
  };
  /// `slaves`: by position.
  LossWatch(Parts parts, std::vector<Losable> slaves, LineMotion::Tell tell);

  /// Tells absences of the master. False: one of them ends the run. Check this first: faults that drives report after
  /// an absence of the master are caused by it.
  [[nodiscard]] bool master_was_there();
  /// Tells the failure of the motion. False: it ends the run.
  [[nodiscard]] bool motion_goes_on();
  /// Whether the run continues without this slave.
  [[nodiscard]] bool expendable(std::size_t slave) const;
  /// A slave was lost at `time`, on the clock of the line.
  void lost(std::size_t slave, std::chrono::nanoseconds time) { away_since_[slave] = time; }
  /// A slave has returned.
  void back(std::size_t slave) { away_since_[slave] = {}; }
  /// Whether a slave is lost that should be there.
  [[nodiscard]] bool is_missed(std::size_t slave) const {
    return away_since_[slave] != std::chrono::nanoseconds{0} && !slaves_[slave].hot_connect;
  }
  /// Returns the first slave that has been missed for longer than give_up_s; none: there is none.
  [[nodiscard]] std::optional<std::size_t> missed_too_long() const;
  /// Returns the first slave that is missed; none: there is none.
  [[nodiscard]] std::optional<std::size_t> first_missed() const;
  /// Returns the longest recent absence of the master if one ended shortly before `time`; else none.
  [[nodiscard]] std::optional<motion::MasterAbsence> cause_of(std::chrono::nanoseconds time) const {
    return absences_.cause_of(time);
  }
  /// Tells absences that were not told one by one, and `dropped` ones that could not be taken.
  void tell_rest(std::uint64_t dropped);

 private:
  Parts parts_;
  std::vector<Losable> slaves_;
  LineMotion::Tell tell_;
  AbsenceWatch absences_;
  std::vector<std::chrono::nanoseconds> away_since_;  ///< time at which each slave was lost; zero: not lost
};

}  // namespace driveline::runtime
