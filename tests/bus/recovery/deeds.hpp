#pragma once

#include <string>
#include <vector>

#include "driveline/ecat_master/recovery/line_supervisor.hpp"
#include "driveline/slaves/line/fault.hpp"

namespace driveline::bus_test {

/// Compares the faults of a plain line with the reports of the master: which slave is blamed for which fault, since
/// when and how often, and which reports must exist because there was no other fault. Frames with flipped bits
/// (FaultKind::kCorrupt) may have any effect on any slave, so their effects are not judged.
class Deeds {
 public:
  using History = std::deque<ecat_master::LineEvent>;

  /// Adds a fault that starts now, after all others. Its slave is the position on the line, its port the one towards
  /// the master.
  void add(const slaves::Fault& fault, std::chrono::nanoseconds now);

  /// Errors in the history of a line with `slaves` slaves; empty: none.
  [[nodiscard]] std::string judge(const History& history, std::size_t slaves);
  /// Number of required reports that were made.
  [[nodiscard]] std::size_t demanded() const noexcept { return demanded_; }

 private:
  struct Deed {
    slaves::Fault fault;
    std::chrono::nanoseconds begin;
    std::chrono::nanoseconds end;
  };
  [[nodiscard]] bool corrupted(std::chrono::nanoseconds before) const;
  [[nodiscard]] std::size_t cuts(std::size_t slave, std::chrono::nanoseconds before) const;
  [[nodiscard]] std::size_t hunger(std::size_t slave, std::chrono::nanoseconds before) const;
  [[nodiscard]] bool starved(std::size_t slave, std::chrono::nanoseconds before) const;
  [[nodiscard]] bool switched_off(std::size_t slave, std::chrono::nanoseconds before) const;
  [[nodiscard]] bool explains(const ecat_master::LineEvent& event) const;
  [[nodiscard]] bool explains_failure(const ecat_master::LineEvent& event) const;
  [[nodiscard]] bool alone(const Deed& deed, const History& history) const;
  [[nodiscard]] std::string never_told(const History& history, std::size_t slaves);

  std::vector<Deed> deeds_;
  std::size_t demanded_ = 0;
};

}  // namespace driveline::bus_test
