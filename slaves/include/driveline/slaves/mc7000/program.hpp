#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

namespace driveline::slaves::mc7000 {

/// Number of variables H00 to H99 and of flags M00 to M99 (MC7000 manual, lines 227, 238: fields 0 to 63h).
inline constexpr std::size_t kFields = 100;
/// Highest record number (MC7000 manual, lines 924, 1610: three digits).
inline constexpr std::uint16_t kMaxRecord = 999;
/// Number of programs P00 to P99 (MC7000 manual, line 1610: two digits).
inline constexpr std::size_t kPrograms = 100;
/// Flag whose setting by a program is an event of TxPDO1 (MC7000 manual, lines 1158-1164).
inline constexpr std::uint8_t kTxPdo1Flag = 98;
/// Flag whose setting by a program is an event of TxPDO2 (MC7000 manual, lines 1158-1164).
inline constexpr std::uint8_t kTxPdo2Flag = 99;

/// A number in the text of a program, or the variable that holds it.
struct Operand {
  /// `value` is the number of a variable.
  bool variable = false;
  /// The number itself, or 0 to 99 for H00 to H99.
  std::int32_t value = 0;

  [[nodiscard]] bool operator==(const Operand&) const = default;
};

/// What a condition looks at.
enum class ConditionSource : std::uint8_t {
  /// Flag M00 to M99.
  kFlag,
  /// Input IE00 to IE99 of the extension.
  kExtensionInput,
  /// Input IS00 to IS99 of the servo itself.
  kServoInput,
};

/// Condition in brackets: a flag or an input has a state.
struct Condition {
  ConditionSource source = ConditionSource::kFlag;
  /// Number of the flag or input, 0 to 99.
  std::uint8_t number = 0;
  /// State in which the condition holds.
  bool state = false;

  [[nodiscard]] bool operator==(const Condition&) const = default;
};

/// What a record does.
enum class Command : std::uint8_t {
  /// `SET Hn=v`.
  kSetVariable,
  /// `SET Mn=v`.
  kSetFlag,
  /// `GO 0`: reference run.
  kReference,
  /// `GO A position speed`: starts an absolute move and goes on.
  kMove,
  /// `GO W A position speed`: starts an absolute move and waits for its end.
  kMoveAndWait,
  /// `WAIT n`, `WAIT Hn`: milliseconds.
  kWaitTime,
  /// `WAIT (condition)`.
  kWaitCondition,
  /// `JMP Nnnn`, `JMP (condition) Nnnn`.
  kJump,
};

/// A line of a program. Fields that its command does not name keep their defaults.
struct Record {
  /// Number of the record, 0 to 999.
  std::uint16_t number = 0;
  Command command = Command::kJump;
  /// Number of the variable or flag that SET writes, 0 to 99.
  std::uint8_t field = 0;
  /// Value of SET, position of GO in increments, time of WAIT in ms.
  Operand value{};
  /// Speed of GO in increments per 5 ms.
  Operand speed{};
  /// Condition of WAIT and JMP. JMP without it always jumps.
  std::optional<Condition> condition{};
  /// Record to which JMP jumps.
  std::uint16_t target = 0;

  [[nodiscard]] bool operator==(const Record&) const = default;
};

/// Records in the order of their numbers, in which they run.
class Program {
 public:
  /// Adds a record. It replaces a record with its number, which is how the example of the manual with a number that is
  /// there twice (line 924) waits as often as its comments say.
  void put(const Record& record);

  /// Returns all records in ascending order of their numbers. \rtsafe
  [[nodiscard]] std::span<const Record> records() const noexcept { return records_; }
  /// Returns the place of a record in records(); none when no record has the number. Takes logarithmic time. \rtsafe
  [[nodiscard]] std::optional<std::size_t> find(std::uint16_t number) const noexcept;
  /// Returns the first record that jumps to a number which no record has; none when all jumps have targets. The drive
  /// stores such a program, and reports the jump when it is executed (MC7000 manual, line 1582: location 217).
  [[nodiscard]] std::optional<std::uint16_t> first_lost_jump() const noexcept;

 private:
  std::vector<Record> records_;
};

}  // namespace driveline::slaves::mc7000
