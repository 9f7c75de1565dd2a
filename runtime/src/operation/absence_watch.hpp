#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "driveline/ecat_master/cyclic/master_absence.hpp"

namespace driveline::runtime {

/// Tells of the times at which the master itself was away, and whether one of them explains what happened to a slave or
/// an axis. Belongs to the thread that looks after the line.
class AbsenceWatch {
 public:
  /// Absences that are told one by one, and those that are longer than all before; the others are told together at the
  /// end.
  static constexpr std::size_t kToldSingly = 20;

  /// Fetches the oldest absence that has not been fetched; false: there is none.
  using Take = std::function<bool(ecat_master::MasterAbsence&)>;

  /// Times are counted from `begin`; `limit`: of an absence that axes are taken across, in words
  /// (max_lost_text()). What there is by now is forgotten.
  AbsenceWatch(Take take, std::chrono::nanoseconds begin, std::string limit);

  /// A look at what is new.
  struct Findings {
    std::vector<std::string> sentences;  ///< of absences that the axes were taken across
    std::string stopped;                 ///< of the one that stopped the axes; empty: none did
  };
  [[nodiscard]] Findings look();
  /// A sentence about those that were not told, and `dropped` ones that nobody could fetch; empty: all were.
  [[nodiscard]] std::string rest(std::uint64_t dropped) const;
  /// "; the master had been away for 54.0 ms at 0.850 s" when one ended shortly before `time`; else empty.
  [[nodiscard]] std::string cause_of(std::chrono::nanoseconds time) const;

 private:
  Take take_;
  std::chrono::nanoseconds begin_;
  std::string limit_;
  std::size_t told_ = 0;
  std::chrono::nanoseconds longest_{0};
  std::uint64_t untold_ = 0;
  std::chrono::nanoseconds untold_time_{0};
  std::chrono::nanoseconds longest_untold_{0};
  std::optional<ecat_master::MasterAbsence> longest_recent_;
};

}  // namespace driveline::runtime
