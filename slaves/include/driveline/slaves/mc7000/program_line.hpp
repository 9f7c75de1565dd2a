#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <tl/expected.hpp>
#include <variant>

#include "driveline/slaves/mc7000/program.hpp"

namespace driveline::slaves::mc7000 {

/// Longest line in characters. Ours: the manual states no length of parameter 551.
inline constexpr std::size_t kMaxLineLength = 80;

/// Why the drive refuses a line that is written to parameter 551 (POCMD).
enum class LineError : std::uint8_t {
  /// The line is cut, has something behind its end, or is longer than kMaxLineLength.
  kSyntax,
  /// No command has this name.
  kUnknownCommand,
  /// A record, field, flag value, speed, time or number is outside its range.
  kOutOfRange,
  /// The sequence control is not in manual mode.
  kNotManual,
  /// A record or END before `%Pnn`.
  kNoOpenProgram,
  /// `%SAV` or `%CLPnn` between `%Pnn` and END.
  kOpenProgram,
  /// `%Pnn` of a program that has not been deleted.
  kProgramExists,
  /// `%CLPnn` of a program that is not there.
  kProgramMissing,
  /// The programs are being saved.
  kSaving,
};

/// Returns the meaning of an error.
[[nodiscard]] std::string_view text_of(LineError error) noexcept;

/// `%Pnn (name)`: begins a program.
struct OpenProgram {
  /// 0 to 99.
  std::uint8_t number = 0;
  /// Without its brackets; empty when the line has none.
  std::string name;
};
/// `%CLPnn`: deletes a program.
struct DeleteProgram {
  /// 0 to 99.
  std::uint8_t number = 0;
};
/// `%SAV`: saves all programs in flash memory.
struct SavePrograms {};
/// `END`: ends a program.
struct EndProgram {};

/// Content of a line.
using Line = std::variant<OpenProgram, DeleteProgram, SavePrograms, EndProgram, Record>;

/// Reads one line of a program or one direct command, with any number of blanks between its parts. A semicolon begins a
/// comment. Commands are in capitals, as the manual prints them.
[[nodiscard]] tl::expected<Line, LineError> parse_line(std::string_view text);

}  // namespace driveline::slaves::mc7000
