#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "driveline/ecat_master/cyclic/master_absence.hpp"

namespace driveline::runtime {

/// Reports absences of the master itself, and whether one of them explains a fault of a slave or an axis. Belongs to
/// the thread that supervises the line.
class AbsenceWatch {
 public:
  /// The first absences are reported one by one, later ones only when longer than all before; the rest together at the
  /// end.
  static constexpr std::size_t kToldSingly = 20;

  /// Fetches the oldest absence that has not been fetched; false: there is none.
  using Take = std::function<bool(ecat_master::MasterAbsence&)>;

  /// Times are counted from `begin`; `limit`: of an absence that axes are taken across, in words (max_lost_text()).
  /// Earlier absences are discarded.
  AbsenceWatch(Take take, std::chrono::nanoseconds begin, std::string limit);

  /// Result of a poll: what is new since the last one.
  struct Findings {
    std::vector<std::string> sentences;  ///< of absences that the axes were taken across
    std::string stopped;                 ///< the absence that stopped the axes; empty: none did
  };
  [[nodiscard]] Findings look();
  /// A sentence about the absences not reported singly, and `dropped` ones that could not be fetched; empty: there are
  /// none.
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
