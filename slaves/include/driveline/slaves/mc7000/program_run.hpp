#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <optional>

#include "driveline/slaves/mc7000/posmod_location.hpp"
#include "driveline/slaves/mc7000/process_values.hpp"
#include "driveline/slaves/mc7000/program.hpp"
#include "driveline/slaves/mc7000/sequence_drive.hpp"

namespace driveline::slaves::mc7000 {

/// Most records that one step executes. Ours: a program that never waits goes on in the next step.
inline constexpr std::size_t kRecordsPerStep = 1000;

/// What a program does after a step.
enum class RunState : std::uint8_t {
  /// It goes on in the next step.
  kRunning,
  /// It has come to its end.
  kEnded,
  /// An error has ended it; see ProgramRun::fault().
  kFailed,
};

/// Executes a program, one step per control period. A step executes records until one waits, sends a TxPDO or fails,
/// and at most kRecordsPerStep.
class ProgramRun {
 public:
  /// @param[in] drive,values outlive this
  /// @param[in] period time between two steps, above 0
  ProgramRun(SequenceDrive& drive, ProcessValues& values, std::chrono::nanoseconds period) noexcept
      : drive_(drive), values_(values), period_(period) {}

  /// Begins with the first record, which the next step executes. The program outlives its run. \rtsafe
  void start(const Program& program) noexcept;
  /// One control period. Precondition: start() has been called, and the run has neither ended nor failed. \rtsafe
  [[nodiscard]] RunState step() noexcept;
  /// Returns the error that has ended the program, kNone without one. \rtsafe
  [[nodiscard]] PosModLocation fault() const noexcept { return fault_; }
  /// Returns the number of the record that was executed last, or that waits. \rtsafe
  [[nodiscard]] std::uint16_t record() const noexcept { return record_; }

 private:
  /// How the execution of a record ends.
  enum class Outcome : std::uint8_t { kNext, kNextAfterStep, kWaits, kJumped, kFailed };

  [[nodiscard]] Outcome execute(const Record& record) noexcept;
  [[nodiscard]] Outcome set_flag(const Record& record) noexcept;
  [[nodiscard]] Outcome reference() noexcept;
  [[nodiscard]] Outcome move(const Record& record) noexcept;
  [[nodiscard]] Outcome wait_for_motion() noexcept;
  [[nodiscard]] Outcome wait_for_time(const Record& record) noexcept;
  [[nodiscard]] Outcome wait_for_condition(const Record& record) noexcept;
  [[nodiscard]] Outcome jump(const Record& record) noexcept;
  [[nodiscard]] std::optional<bool> holds(const Condition& condition) const noexcept;
  [[nodiscard]] Outcome fail(PosModLocation location) noexcept;

  SequenceDrive& drive_;
  ProcessValues& values_;
  std::chrono::nanoseconds period_;
  const Program* program_ = nullptr;
  /// Place in the program of the record to execute.
  std::size_t place_ = 0;
  std::uint16_t record_ = 0;
  /// This record was executed in the step before and waits.
  bool waits_ = false;
  std::chrono::nanoseconds wait_left_{};
  PosModLocation fault_ = PosModLocation::kNone;
};

}  // namespace driveline::slaves::mc7000
