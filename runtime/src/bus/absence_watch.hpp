#pragma once

#include <functional>
#include <optional>
#include <vector>

#include "driveline/motion/control/master_absence.hpp"
#include "driveline/runtime/event/operation_events.hpp"

namespace driveline::runtime {

/// Finds absences of the master itself, and whether one of them explains a fault of a slave or an axis. Belongs to the
/// thread that supervises the line. The times of the absences that it returns are times in operation.
class AbsenceWatch {
 public:
  /// The first absences are reported individually, later ones only if they are longer than all before; the others are
  /// summed up at the end.
  static constexpr std::size_t kReportedSingly = 20;

  /// Takes the oldest absence not taken yet; false: there is none.
  using Take = std::function<bool(motion::MasterAbsence&)>;

  /// `begin`: start of operation; earlier absences are discarded.
  AbsenceWatch(Take take, std::chrono::nanoseconds begin);

  /// New absences since the last poll.
  struct Findings {
    std::vector<motion::MasterAbsence> bridged;    ///< absences that the axes bridged
    std::optional<motion::MasterAbsence> stopped;  ///< the absence that stopped the axes; none: no absence did
  };
  [[nodiscard]] Findings poll();
  /// Returns the absences not reported individually, and `dropped` ones that could not be taken; none: there are none.
  [[nodiscard]] std::optional<events::MasterAwayOften> rest(std::uint64_t dropped) const;
  /// Returns the longest recent absence if one ended shortly before `time` (on the clock of the line); else none.
  [[nodiscard]] std::optional<motion::MasterAbsence> cause_of(std::chrono::nanoseconds time) const;

 private:
  [[nodiscard]] motion::MasterAbsence in_operation(motion::MasterAbsence absence) const noexcept;

  Take take_;
  std::chrono::nanoseconds begin_;
  std::size_t reported_ = 0;
  std::chrono::nanoseconds longest_{0};
  std::uint64_t unreported_ = 0;
  std::chrono::nanoseconds unreported_time_{0};
  std::chrono::nanoseconds longest_unreported_{0};
  std::optional<motion::MasterAbsence> longest_recent_;
};

}  // namespace driveline::runtime
