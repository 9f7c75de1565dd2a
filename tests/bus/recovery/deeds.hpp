#pragma once

#include <string>
#include <vector>

#include "driveline/ecat_master/recovery/line_supervisor.hpp"
#include "driveline/slaves/line/fault.hpp"

namespace driveline::bus_test {

/// What was done to a plain line, and whether that is what is told of it: who is accused of what, since when, how
/// often, and what had to be told because nothing else was going on. Frames whose bits flip unnoticed
/// (FaultKind::kCorrupt) may mean anything to anybody, so nothing is judged that they may have done.
class Deeds {
 public:
  using History = std::deque<ecat_master::LineEvent>;

  /// A fault that begins now, after all others. Its slave is the position on the line, its port the one towards the
  /// master.
  void add(const slaves::Fault& fault, std::chrono::nanoseconds now);

  /// What is wrong with the history of a line of so many slaves, empty: nothing.
  [[nodiscard]] std::string judge(const History& history, std::size_t slaves);
  /// Sentences that had to be told, and were.
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
