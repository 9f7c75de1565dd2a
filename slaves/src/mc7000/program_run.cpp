#include "driveline/slaves/mc7000/program_run.hpp"

namespace driveline::slaves::mc7000 {

void ProgramRun::start(const Program& program) noexcept {
  program_ = &program;
  place_ = 0;
  waits_ = false;
  fault_ = PosModLocation::kNone;
}

RunState ProgramRun::step() noexcept {
  const auto records = program_->records();
  for (std::size_t executed = 0; executed < kRecordsPerStep; ++executed) {
    if (place_ >= records.size()) return RunState::kEnded;
    record_ = records[place_].number;
    const auto outcome = execute(records[place_]);
    waits_ = outcome == Outcome::kWaits;
    if (outcome == Outcome::kFailed) return RunState::kFailed;
    if (outcome == Outcome::kNext || outcome == Outcome::kNextAfterStep) ++place_;
    if (outcome == Outcome::kWaits || outcome == Outcome::kNextAfterStep) break;
  }
  return RunState::kRunning;
}

ProgramRun::Outcome ProgramRun::execute(const Record& record) noexcept {
  switch (record.command) {
    case Command::kSetVariable:
      values_.set_variable(record.field, record.value.value);
      return Outcome::kNext;
    case Command::kSetFlag:
      return set_flag(record);
    case Command::kReference:
      return waits_ ? wait_for_motion() : reference();
    case Command::kMove:
      return move(record);
    case Command::kMoveAndWait:
      return waits_ ? wait_for_motion() : move(record);
    case Command::kWaitTime:
      return wait_for_time(record);
    case Command::kWaitCondition:
      return wait_for_condition(record);
    case Command::kJump:
      return jump(record);
  }
  return Outcome::kNext;
}

/// An event is the setting itself, not a change: the second example of the manual (lines 1302-1306) sets M99 for every
/// TxPDO and never clears it. It ends the step, so that a step sends no more than one.
ProgramRun::Outcome ProgramRun::set_flag(const Record& record) noexcept {
  values_.set_flag(record.field, static_cast<std::uint8_t>(record.value.value));
  if (record.value.value == 0) return Outcome::kNext;
  if (record.field != kTxPdo1Flag && record.field != kTxPdo2Flag) return Outcome::kNext;
  drive_.tx_pdo_event(record.field == kTxPdo1Flag ? 1 : 2);
  return Outcome::kNextAfterStep;
}

ProgramRun::Outcome ProgramRun::reference() noexcept {
  if (drive_.motion().moving) return fail(PosModLocation::kMoving);
  drive_.start_reference_run();
  return Outcome::kWaits;
}

ProgramRun::Outcome ProgramRun::move(const Record& record) noexcept {
  if (drive_.motion().moving) return fail(PosModLocation::kMoving);
  if (!drive_.referenced()) return fail(PosModLocation::kNoReference);
  const auto speed = values_.value_of(record.speed);
  // Such a move never comes to its target; its text cannot say so, only a variable can.
  if (speed <= 0) return fail(PosModLocation::kNotReached);
  const auto refusal = drive_.start_move(values_.value_of(record.value), speed);
  if (refusal != PosModLocation::kNone) return fail(refusal);
  return record.command == Command::kMoveAndWait ? Outcome::kWaits : Outcome::kNext;
}

/// The sequence control looks at failures of the motion, in every record.
ProgramRun::Outcome ProgramRun::wait_for_motion() noexcept {
  const auto motion = drive_.motion();
  if (motion.moving) return Outcome::kWaits;
  return motion.in_position ? Outcome::kNext : fail(PosModLocation::kNotReached);
}

ProgramRun::Outcome ProgramRun::wait_for_time(const Record& record) noexcept {
  if (waits_) {
    wait_left_ -= period_;
  } else {
    wait_left_ = std::chrono::milliseconds(values_.value_of(record.value));
  }
  return wait_left_.count() > 0 ? Outcome::kWaits : Outcome::kNext;
}

ProgramRun::Outcome ProgramRun::wait_for_condition(const Record& record) noexcept {
  const auto met = record.condition ? holds(*record.condition) : true;
  if (!met) return fail(PosModLocation::kNoHardware);
  return *met ? Outcome::kNext : Outcome::kWaits;
}

ProgramRun::Outcome ProgramRun::jump(const Record& record) noexcept {
  const auto met = record.condition ? holds(*record.condition) : true;
  if (!met) return fail(PosModLocation::kNoHardware);
  if (!*met) return Outcome::kNext;
  const auto target = program_->find(record.target);
  if (!target) return fail(PosModLocation::kNoRecord);
  // What a condition looks at does not change within a step, so a record that jumps to itself waits for the next.
  if (*target == place_) return Outcome::kWaits;
  place_ = *target;
  return Outcome::kJumped;
}

/// None when the drive lacks the input.
std::optional<bool> ProgramRun::holds(const Condition& condition) const noexcept {
  if (condition.source == ConditionSource::kFlag) return (values_.flag(condition.number) != 0) == condition.state;
  const auto input = drive_.input(condition.source, condition.number);
  if (!input) return std::nullopt;
  return *input == condition.state;
}

ProgramRun::Outcome ProgramRun::fail(PosModLocation location) noexcept {
  fault_ = location;
  return Outcome::kFailed;
}

}  // namespace driveline::slaves::mc7000
