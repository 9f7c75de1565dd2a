#include "driveline/slaves/od/parameter_file.hpp"

#include <unistd.h>

#include <cerrno>
#include <charconv>
#include <cmath>
#include <cstring>
#include <fstream>
#include <vector>

#include "driveline/rt/output_place.hpp"

namespace driveline::slaves {
namespace {

using Result = tl::expected<void, ParameterFileError>;

/// Far more than all parameters of a device need; an endless file is refused before it fills the memory.
constexpr std::size_t kMaxFileBytes = std::size_t{4} << 20;
constexpr std::string_view kHeader = "# Stored parameters: index:sub-index = value\n";

bool is_stored(const EntryRow& row) noexcept {
  return (row.access & access::kBackup) != 0 && row.slot != slot::kConstant;
}

std::string address_text(const EntryRow& row) {
  constexpr std::string_view kDigits = "0123456789ABCDEF";
  std::string text;
  for (int shift = 12; shift >= 0; shift -= 4) text += kDigits[row.index >> shift & 0xF];
  text += ':';
  text += kDigits[row.subindex >> 4];
  text += kDigits[row.subindex & 0xF];
  return text;
}

template <typename T>
std::string number_text(T value) {
  std::array<char, 32> buffer{};
  const auto end = std::to_chars(buffer.data(), buffer.data() + buffer.size(), value).ptr;
  return {buffer.data(), end};
}

std::string value_text(const ObjectDictionary& dictionary, const EntryRow& row) {
  if (is_string(row.type)) {
    std::string text = "\"";
    for (const char c : dictionary.text(row.slot)) {
      if (c == '"' || c == '\\') text += '\\';
      text += c == '\n' || c == '\r' ? ' ' : c;
    }
    return text + '"';
  }
  const std::uint64_t raw = dictionary.raw(row);
  if (row.type == esi::DataType::kReal32) return number_text(static_cast<float>(number_from_raw(row.type, raw)));
  if (row.type == esi::DataType::kReal64) return number_text(number_from_raw(row.type, raw));
  return is_signed(row.type) ? number_text(static_cast<std::int64_t>(raw)) : number_text(raw);
}

std::string_view trimmed(std::string_view text) {
  const auto first = text.find_first_not_of(" \t\r");
  if (first == std::string_view::npos) return {};
  return text.substr(first, text.find_last_not_of(" \t\r") - first + 1);
}

template <typename T>
bool parse(std::string_view text, T& value, int base = 10) {
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value, base);
  return error == std::errc{} && end == text.data() + text.size();
}

/// Returns an error in a line, whose number the caller adds, or in the file as a whole.
tl::unexpected<ParameterFileError> wrong(std::string what) {
  return tl::unexpected(ParameterFileError{0, std::move(what)});
}

/// A validated value of the file.
struct Assignment {
  const EntryRow* row = nullptr;
  std::uint64_t raw = 0;
  std::string text;
};

tl::expected<std::string, ParameterFileError> parse_string(std::string_view value, const EntryRow& row) {
  std::string text;
  std::size_t i = 1;
  for (; i < value.size() && value[i] != '"'; ++i) {
    if (value[i] == '\\' && i + 1 < value.size()) ++i;
    text += value[i];
  }
  if (value.empty() || value[0] != '"' || i >= value.size()) return wrong("a text in quotes is expected");
  if (text.size() > row.string_length) {
    return wrong("at most " + number_text(row.string_length) + " characters are possible");
  }
  return text;
}

tl::expected<std::uint64_t, ParameterFileError> parse_number(std::string_view value, const EntryRow& row) {
  double number = 0.0;
  std::uint64_t raw = 0;
  if (row.type == esi::DataType::kReal32 || row.type == esi::DataType::kReal64) {
    const auto [end, error] = std::from_chars(value.data(), value.data() + value.size(), number);
    if (error != std::errc{} || end != value.data() + value.size() || !std::isfinite(number)) {
      return wrong("a number is expected");
    }
    raw = raw_from_number(row.type, number);
  } else if (is_signed(row.type)) {
    std::int64_t whole = 0;
    if (!parse(value, whole)) return wrong("a whole number is expected");
    raw = static_cast<std::uint64_t>(whole);
    number = static_cast<double>(whole);
  } else {
    if (!parse(value, raw)) return wrong("a whole number without sign is expected");
    number = static_cast<double>(raw);
  }
  const std::size_t bits = 8 * byte_size(row.type);
  const double span = std::ldexp(1.0, static_cast<int>(bits) - (is_signed(row.type) ? 1 : 0));
  const bool whole = row.type != esi::DataType::kReal32 && row.type != esi::DataType::kReal64;
  if (number < row.minimum || number > row.maximum ||
      (whole && (number >= span || number < (is_signed(row.type) ? -span : 0.0)))) {
    return wrong("the value is out of range");
  }
  return raw;
}

tl::expected<Assignment, ParameterFileError> parse_line(std::string_view line, const DictionaryTable& table) {
  std::uint16_t index = 0;
  std::uint8_t subindex = 0;
  const auto colon = line.find(':');
  const auto equals = line.find('=');
  if (colon == std::string_view::npos || equals == std::string_view::npos || colon > equals ||
      !parse(trimmed(line.substr(0, colon)), index, 16) ||
      !parse(trimmed(line.substr(colon + 1, equals - colon - 1)), subindex, 16)) {
    return wrong("`index:sub-index = value` is expected");
  }
  const EntryRow* row = table.find(index, subindex);
  if (row == nullptr) return wrong("there is no such object");
  if (!is_stored(*row)) return wrong("this object is not a stored parameter");
  auto value = trimmed(line.substr(equals + 1));
  if (is_string(row->type)) return parse_string(value, *row).map([&](auto text) { return Assignment{row, 0, text}; });
  value = trimmed(value.substr(0, value.find('#')));
  return parse_number(value, *row).map([&](auto raw) { return Assignment{row, raw, {}}; });
}

tl::unexpected<ParameterFileError> system_error(std::string_view what) {
  return wrong(std::string(what) + ": " + std::strerror(errno));
}

/// Writes the text to the disk, waits until it is stored, and closes the file; returns the reason when that fails.
Result write_through(int file, std::string_view text) {
  while (!text.empty()) {
    const auto written = ::write(file, text.data(), text.size());
    if (written < 0) {
      const auto error = system_error("cannot be written");
      ::close(file);
      return error;
    }
    text.remove_prefix(static_cast<std::size_t>(written));
  }
  const bool synchronised = ::fsync(file) == 0;
  const bool closed = ::close(file) == 0;
  if (!synchronised || !closed) return system_error("cannot be written");
  return {};
}

}  // namespace

std::string write_parameters(const ObjectDictionary& dictionary) {
  std::string text(kHeader);
  std::vector<bool> seen(dictionary.table().slot_count());
  // A value with a standard and a manufacturer's address is written with the standard one.
  for (const bool manufacturer : {false, true}) {
    for (const auto& row : dictionary.table().rows()) {
      if (!is_stored(row) || (row.index >= 0x2000 && row.index < 0x6000) != manufacturer) continue;
      if (!is_string(row.type)) {
        if (seen[row.slot]) continue;
        seen[row.slot] = true;
      }
      text += address_text(row) + " = " + value_text(dictionary, row) + "  # " + std::string(row.name) + '\n';
    }
  }
  return text;
}

Result read_parameters(std::string_view text, ObjectDictionary& dictionary) {
  std::vector<Assignment> assignments;
  for (std::size_t number = 1; !text.empty(); ++number) {
    const auto end = text.find('\n');
    const auto line = trimmed(text.substr(0, end));
    text.remove_prefix(end == std::string_view::npos ? text.size() : end + 1);
    if (line.empty() || line[0] == '#') continue;
    auto assignment = parse_line(line, dictionary.table());
    if (!assignment) return tl::unexpected(ParameterFileError{number, assignment.error().what});
    assignments.push_back(std::move(*assignment));
  }
  for (const auto& a : assignments) {
    if (is_string(a.row->type)) {
      dictionary.text(a.row->slot) = a.text;
    } else {
      dictionary.set_raw(a.row->slot, a.raw);
    }
  }
  return {};
}

Result save_parameter_file(const std::string& path, const ObjectDictionary& dictionary) {
  const auto place = rt::OutputPlace::find(path);
  if (!place) return wrong(rt::describe_output_error(path, place.error()));
  const auto file = place->open();
  if (!file) return wrong("cannot be opened for writing: " + file.error().message());
  auto written = write_through(*file, write_parameters(dictionary));
  if (!written) {
    place->discard();
    return written;
  }
  if (const auto error = place->complete()) return wrong("cannot be replaced: " + error.message());
  return {};
}

Result load_parameter_file(const std::string& path, ObjectDictionary& dictionary) {
  std::ifstream file(path, std::ios::binary);
  if (!file) return errno == ENOENT ? Result{} : Result{system_error("cannot be read")};
  std::string text(kMaxFileBytes + 1, '\0');
  file.read(text.data(), static_cast<std::streamsize>(text.size()));
  text.resize(static_cast<std::size_t>(file.gcount()));
  if (text.size() > kMaxFileBytes) return wrong("is larger than 4 MiB");
  return read_parameters(text, dictionary);
}

}  // namespace driveline::slaves
