#pragma once

#include <functional>
#include <optional>
#include <vector>

#include "driveline/ecat_master/cyclic/master_absence.hpp"
#include "driveline/runtime/event/operation_events.hpp"

namespace driveline::runtime {

/// Finds absences of the master itself, and whether one of them explains a fault of a slave or an axis. Belongs to the
/// thread that supervises the line. Absences that it returns have the time in operation.
class AbsenceWatch {
 public:
  /// The first absences are reported one by one, later ones only when longer than all before; the rest together at the
  /// end.
  static constexpr std::size_t kToldSingly = 20;

  /// Fetches the oldest absence that has not been fetched; false: there is none.
  using Take = std::function<bool(ecat_master::MasterAbsence&)>;

  /// The operation has begun at `begin`: earlier absences are discarded.
  AbsenceWatch(Take take, std::chrono::nanoseconds begin);

  /// Result of a poll: what is new since the last one.
  struct Findings {
    std::vector<ecat_master::MasterAbsence> bridged;    ///< those that the axes were taken across
    std::optional<ecat_master::MasterAbsence> stopped;  ///< the one that stopped the axes; none did
  };
  [[nodiscard]] Findings look();
  /// The absences not reported singly, and `dropped` ones that could not be fetched; none: there are none.
  [[nodiscard]] std::optional<events::MasterAwayOften> rest(std::uint64_t dropped) const;
  /// The longest absence of late when one ended shortly before `time` (of the clock of the line); else none.
  [[nodiscard]] std::optional<ecat_master::MasterAbsence> cause_of(std::chrono::nanoseconds time) const;

 private:
  [[nodiscard]] ecat_master::MasterAbsence in_operation(ecat_master::MasterAbsence absence) const noexcept;

  Take take_;
  std::chrono::nanoseconds begin_;
  std::size_t told_ = 0;
  std::chrono::nanoseconds longest_{0};
  std::uint64_t untold_ = 0;
  std::chrono::nanoseconds untold_time_{0};
  std::chrono::nanoseconds longest_untold_{0};
  std::optional<ecat_master::MasterAbsence> longest_recent_;
};

}  // namespace driveline::runtime
