#include "csv_rows.hpp"

#include <algorithm>
#include <cerrno>
#include <charconv>
#include <cmath>
#include <cstdio>
#include <memory>
#include <system_error>
#include <utility>

#include "text.hpp"

namespace driveline::trajectory {
namespace {

constexpr std::string_view kBlanks = " \t";
constexpr std::size_t kMaxFileBytes = std::size_t{128} << 20;
constexpr std::size_t kMaxFileLines = 1'000'000;

using File = std::unique_ptr<std::FILE, int (*)(std::FILE*)>;

void split(std::string_view line, std::vector<CsvField>& fields) {
  fields.clear();
  std::size_t begin = 0;
  while (true) {
    const std::size_t comma = line.find(',', begin);
    const std::string_view raw = line.substr(begin, comma == std::string_view::npos ? comma : comma - begin);
    const std::size_t lead = raw.find_first_not_of(kBlanks);
    fields.push_back({csv_trimmed(raw), begin + 1 + (lead == std::string_view::npos ? 0 : lead)});
    if (comma == std::string_view::npos) {
      return;
    }
    begin = comma + 1;
  }
}

}  // namespace

std::string_view csv_trimmed(std::string_view text) {
  const std::size_t first = text.find_first_not_of(kBlanks);
  if (first == std::string_view::npos) {
    return {};
  }
  return text.substr(first, text.find_last_not_of(kBlanks) - first + 1);
}

CsvRows::CsvRows(std::string_view text, std::string_view name) : rest_(text), name_(name) {
  constexpr std::string_view kByteOrderMark = "\xEF\xBB\xBF";
  if (rest_.substr(0, kByteOrderMark.size()) == kByteOrderMark) {
    rest_.remove_prefix(kByteOrderMark.size());
  }
}

bool CsvRows::next() {
  while (!rest_.empty()) {
    const std::size_t end = rest_.find('\n');
    std::string_view line = rest_.substr(0, end);
    rest_.remove_prefix(end == std::string_view::npos ? rest_.size() : end + 1);
    ++line_;
    if (!line.empty() && line.back() == '\r') {
      line.remove_suffix(1);
    }
    const std::string_view content = csv_trimmed(line);
    if (!content.empty() && content.front() != '#') {
      split(line, fields_);
      return true;
    }
  }
  return false;
}

bool CsvRows::has_foreign_separator() const {
  return std::any_of(fields_.begin(), fields_.end(),
                     [](const CsvField& field) { return field.text.find_first_of(";\t") != std::string_view::npos; });
}

tl::expected<double, PathError> CsvRows::number(const CsvField& field) const {
  const CsvPlace place{line_, field.column};
  double value = 0.0;
  const char* const end = field.text.data() + field.text.size();
  const auto [stop, fault] = std::from_chars(field.text.data(), end, value);
  if (fault == std::errc::invalid_argument || stop != end) {
    return refuse(place, in_quotes(field.text) + " is not a number");
  }
  if (fault == std::errc::result_out_of_range) {
    return refuse(place, in_quotes(field.text) + " is beyond the range of a double");
  }
  if (!std::isfinite(value)) {
    return refuse(place, in_quotes(field.text) + " is not a finite number");
  }
  return value;
}

tl::unexpected<PathError> CsvRows::refuse(CsvPlace place, std::string reason) const {
  return tl::unexpected(PathError{std::string(name_), place.line, place.column, std::move(reason)});
}

tl::expected<std::string, PathError> read_csv_text(const std::filesystem::path& file) {
  const auto refuse = [&file](std::string reason) {
    return tl::unexpected(PathError{file.string(), 0, 0, std::move(reason)});
  };
  const auto unreadable = [&refuse] { return refuse("cannot be read: " + std::generic_category().message(errno)); };
  const File stream(std::fopen(file.c_str(), "rb"), &std::fclose);
  if (!stream) {
    return unreadable();
  }
  std::string text;
  std::vector<char> block(std::size_t{1} << 16);
  while (const std::size_t count = std::fread(block.data(), 1, block.size(), stream.get())) {
    text.append(block.data(), count);
    if (text.size() > kMaxFileBytes) {
      return refuse("is larger than 128 MiB");
    }
  }
  if (std::ferror(stream.get()) != 0) {
    return unreadable();
  }
  // Before any row is parsed, so that the refusal does not take seconds.
  if (static_cast<std::size_t>(std::count(text.begin(), text.end(), '\n')) > kMaxFileLines) {
    return refuse("has more than " + std::to_string(kMaxFileLines) + " lines");
  }
  return text;
}

}  // namespace driveline::trajectory
