#include "driveline/slaves/mc7000/program_line.hpp"

#include <algorithm>
#include <charconv>
#include <limits>

namespace driveline::slaves::mc7000 {
namespace {

template <typename Value>
using Parsed = tl::expected<Value, LineError>;

constexpr bool is_digit(char c) noexcept {
  return c >= '0' && c <= '9';
}
constexpr bool is_letter(char c) noexcept {
  return c >= 'A' && c <= 'Z';
}
constexpr bool is_blank(char c) noexcept {
  return c == ' ' || c == '\t' || c == '\r' || c == '\n';
}

/// The rest of a line.
class Cursor {
 public:
  explicit Cursor(std::string_view text) noexcept : rest_(text) {}

  /// Skips blanks.
  [[nodiscard]] bool at_end() noexcept {
    skip_blanks();
    return rest_.empty();
  }
  [[nodiscard]] bool next_is(std::string_view expected) noexcept {
    skip_blanks();
    return rest_.starts_with(expected);
  }
  /// Consumes the expected text when it is next.
  [[nodiscard]] bool take(std::string_view expected) noexcept {
    if (!next_is(expected)) return false;
    rest_.remove_prefix(expected.size());
    return true;
  }
  /// Consumes capital letters.
  [[nodiscard]] std::string_view word() noexcept {
    skip_blanks();
    return take_while(is_letter);
  }
  /// Consumes digits that begin here, without blanks before them.
  [[nodiscard]] std::string_view digits() noexcept { return take_while(is_digit); }
  /// Consumes all text up to a character, and the character.
  [[nodiscard]] Parsed<std::string_view> up_to(char end) noexcept {
    const auto length = rest_.find(end);
    if (length == std::string_view::npos) return tl::unexpected(LineError::kSyntax);
    const auto text = rest_.substr(0, length);
    rest_.remove_prefix(length + 1);
    return text;
  }

 private:
  void skip_blanks() noexcept { static_cast<void>(take_while(is_blank)); }
  [[nodiscard]] std::string_view take_while(bool (*wanted)(char)) noexcept {
    const auto end = std::ranges::find_if_not(rest_, wanted);
    const auto text = rest_.substr(0, static_cast<std::size_t>(end - rest_.begin()));
    rest_.remove_prefix(text.size());
    return text;
  }

  std::string_view rest_;
};

Parsed<std::int32_t> number_in(Cursor& line, std::int32_t low, std::int32_t high) noexcept {
  const bool negative = line.take("-");
  if (!negative) static_cast<void>(line.take("+"));
  const auto digits = line.digits();
  if (digits.empty()) return tl::unexpected(LineError::kSyntax);
  std::int64_t magnitude = 0;
  const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), magnitude);
  if (error != std::errc{}) return tl::unexpected(LineError::kOutOfRange);
  const auto number = negative ? -magnitude : magnitude;
  if (number < low || number > high) return tl::unexpected(LineError::kOutOfRange);
  return static_cast<std::int32_t>(number);
}

/// Digits right behind their letter.
Parsed<std::int32_t> index_up_to(Cursor& line, std::int32_t highest) noexcept {
  const auto digits = line.digits();
  if (digits.empty()) return tl::unexpected(LineError::kSyntax);
  std::int32_t index = 0;
  const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), index);
  if (error != std::errc{} || index > highest) return tl::unexpected(LineError::kOutOfRange);
  return index;
}

Parsed<std::uint8_t> field_of(Cursor& line) noexcept {
  return index_up_to(line, kFields - 1).map([](std::int32_t index) { return static_cast<std::uint8_t>(index); });
}

Parsed<std::uint16_t> record_number(Cursor& line) noexcept {
  return index_up_to(line, kMaxRecord).map([](std::int32_t index) { return static_cast<std::uint16_t>(index); });
}

Parsed<Operand> operand_in(Cursor& line, std::int32_t low) noexcept {
  if (line.take("H")) {
    return field_of(line).map([](std::uint8_t field) { return Operand{.variable = true, .value = field}; });
  }
  return number_in(line, low, std::numeric_limits<std::int32_t>::max()).map([](std::int32_t number) {
    return Operand{.variable = false, .value = number};
  });
}

Parsed<ConditionSource> source_of(std::string_view word) noexcept {
  if (word == "M") return ConditionSource::kFlag;
  if (word == "IE") return ConditionSource::kExtensionInput;
  if (word == "IS") return ConditionSource::kServoInput;
  return tl::unexpected(LineError::kSyntax);
}

/// What follows an opening bracket.
Parsed<Condition> condition_in(Cursor& line) noexcept {
  const auto source = source_of(line.word());
  if (!source) return tl::unexpected(source.error());
  const auto number = field_of(line);
  if (!number) return tl::unexpected(number.error());
  if (!line.take("=")) return tl::unexpected(LineError::kSyntax);
  const auto state = number_in(line, 0, 1);
  if (!state) return tl::unexpected(state.error());
  if (!line.take(")")) return tl::unexpected(LineError::kSyntax);
  return Condition{.source = *source, .number = *number, .state = *state == 1};
}

Parsed<void> read_set(Cursor& line, Record& record) noexcept {
  const auto kind = line.word();
  if (kind != "H" && kind != "M") return tl::unexpected(LineError::kSyntax);
  const bool flag = kind == "M";
  record.command = flag ? Command::kSetFlag : Command::kSetVariable;
  const auto field = field_of(line);
  if (!field) return tl::unexpected(field.error());
  record.field = *field;
  if (!line.take("=")) return tl::unexpected(LineError::kSyntax);
  using Limits = std::numeric_limits<std::int32_t>;
  const auto value = flag ? number_in(line, 0, 1) : number_in(line, Limits::min(), Limits::max());
  if (!value) return tl::unexpected(value.error());
  record.value.value = *value;
  return {};
}

Parsed<void> read_go(Cursor& line, Record& record) noexcept {
  if (line.take("0")) {
    record.command = Command::kReference;
    return {};
  }
  record.command = line.take("W") ? Command::kMoveAndWait : Command::kMove;
  if (!line.take("A")) return tl::unexpected(LineError::kSyntax);
  const auto position = operand_in(line, std::numeric_limits<std::int32_t>::min());
  if (!position) return tl::unexpected(position.error());
  if (!line.next_is("H") && !line.take("V")) return tl::unexpected(LineError::kSyntax);
  const auto speed = operand_in(line, 1);
  if (!speed) return tl::unexpected(speed.error());
  record.value = *position;
  record.speed = *speed;
  return {};
}

Parsed<void> read_wait(Cursor& line, Record& record) noexcept {
  if (line.take("(")) {
    record.command = Command::kWaitCondition;
    return condition_in(line).map([&record](const Condition& condition) { record.condition = condition; });
  }
  record.command = Command::kWaitTime;
  return operand_in(line, 0).map([&record](const Operand& time) { record.value = time; });
}

Parsed<void> read_jump(Cursor& line, Record& record) noexcept {
  record.command = Command::kJump;
  if (line.take("(")) {
    const auto condition = condition_in(line);
    if (!condition) return tl::unexpected(condition.error());
    record.condition = *condition;
  }
  if (!line.take("N")) return tl::unexpected(LineError::kSyntax);
  return record_number(line).map([&record](std::uint16_t target) { record.target = target; });
}

Parsed<Line> read_record(Cursor& line) noexcept {
  Record record;
  const auto number = record_number(line);
  if (!number) return tl::unexpected(number.error());
  record.number = *number;
  using Reader = Parsed<void> (*)(Cursor&, Record&) noexcept;
  struct Named {
    std::string_view name;
    Reader read;
  };
  static constexpr Named kCommands[] = {{"SET", read_set}, {"GO", read_go}, {"WAIT", read_wait}, {"JMP", read_jump}};
  const auto word = line.word();
  if (word.empty()) return tl::unexpected(LineError::kSyntax);
  const auto* const named = std::ranges::find(kCommands, word, &Named::name);
  if (named == std::ranges::end(kCommands)) return tl::unexpected(LineError::kUnknownCommand);
  return named->read(line, record).map([&record] { return Line{record}; });
}

Parsed<std::uint8_t> program_number(Cursor& line) noexcept {
  return index_up_to(line, kPrograms - 1).map([](std::int32_t index) { return static_cast<std::uint8_t>(index); });
}

/// What follows a percent sign.
Parsed<Line> read_direct(Cursor& line) {
  const auto word = line.word();
  if (word == "SAV") return SavePrograms{};
  if (word != "P" && word != "CLP") return tl::unexpected(LineError::kUnknownCommand);
  const auto number = program_number(line);
  if (!number) return tl::unexpected(number.error());
  if (word == "CLP") return DeleteProgram{*number};
  OpenProgram open{.number = *number, .name = {}};
  if (line.take("(")) {
    const auto name = line.up_to(')');
    if (!name) return tl::unexpected(name.error());
    open.name = *name;
  }
  return open;
}

Parsed<Line> read_line(Cursor& line) {
  if (line.take("%")) return read_direct(line);
  const auto word = line.word();
  if (word == "N") return read_record(line);
  if (word == "END") return EndProgram{};
  return tl::unexpected(word.empty() ? LineError::kSyntax : LineError::kUnknownCommand);
}

}  // namespace

std::string_view text_of(LineError error) noexcept {
  switch (error) {
    case LineError::kSyntax:
      return "the line is not complete, too long, or has something behind its end";
    case LineError::kUnknownCommand:
      return "no command has this name";
    case LineError::kOutOfRange:
      return "a number is outside its range";
    case LineError::kNotManual:
      return "programs are taken in manual mode only";
    case LineError::kNoOpenProgram:
      return "no %Pnn has begun a program";
    case LineError::kOpenProgram:
      return "END has not ended the program";
    case LineError::kProgramExists:
      return "the program exists; %CLPnn deletes it";
    case LineError::kProgramMissing:
      return "the program is not there";
    case LineError::kSaving:
      return "programs are being saved";
  }
  return {};
}

tl::expected<Line, LineError> parse_line(std::string_view text) {
  text = text.substr(0, text.find(';'));
  if (text.size() > kMaxLineLength) return tl::unexpected(LineError::kSyntax);
  Cursor line(text);
  auto parsed = read_line(line);
  if (parsed && !line.at_end()) return tl::unexpected(LineError::kSyntax);
  return parsed;
}

}  // namespace driveline::slaves::mc7000
