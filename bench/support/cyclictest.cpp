#include "support/cyclictest.hpp"

#include <fmt/format.h>

#include <charconv>
#include <sstream>
#include <stdexcept>

#include "support/child_program.hpp"

namespace driveline::bench {
namespace {

/// Size of its histogram; cyclictest counts longer latencies, but reports only the largest of them.
constexpr int kHistogramUs = 20'000;

/// The number at the start of `text`; none: it starts with something else.
std::optional<long> leading_number(std::string_view text) {
  text.remove_prefix(std::min(text.find_first_not_of(" \t"), text.size()));
  long value = 0;
  const auto parsed = std::from_chars(text.data(), text.data() + text.size(), value);
  if (parsed.ec != std::errc{}) return std::nullopt;
  return value;
}

/// The number after `title`, if the line starts with that.
std::optional<long> titled(std::string_view line, std::string_view title) {
  if (!line.starts_with(title)) return std::nullopt;
  return leading_number(line.substr(title.size()));
}

void append(std::vector<double>& latencies_ns, long us, long count) {
  latencies_ns.insert(latencies_ns.end(), static_cast<std::size_t>(count), static_cast<double>(us) * 1000.0);
}

}  // namespace

std::vector<double> parse_cyclictest(std::string_view text, int loops) {
  std::vector<double> latencies_ns;
  long largest_us = 0;
  long beyond = 0;
  std::istringstream lines{std::string(text)};
  for (std::string line; std::getline(lines, line);) {
    if (const auto value = titled(line, "# Max Latencies:")) largest_us = *value;
    if (const auto value = titled(line, "# Histogram Overflows:")) beyond = *value;
    const auto space = line.find_first_of(" \t");
    if (line.starts_with("#") || space == std::string::npos) continue;
    const auto us = leading_number(line);
    const auto count = leading_number(std::string_view(line).substr(space));
    if (us && count && *us >= 0 && *count > 0 && *count <= loops) append(latencies_ns, *us, *count);
  }
  if (beyond > 0 && beyond <= loops) append(latencies_ns, largest_us, beyond);
  if (latencies_ns.size() != static_cast<std::size_t>(loops)) {
    throw std::runtime_error(
        fmt::format("cyclictest reports {} latencies instead of the {} requested", latencies_ns.size(), loops));
  }
  return latencies_ns;
}

std::optional<std::vector<double>> run_cyclictest(const CyclictestJob& job) {
  const auto child = ChildProgram::start({"cyclictest", "-m", "-q", "-t", "1", "-p", std::to_string(job.priority), "-a",
                                          std::to_string(job.cpu), "-i", std::to_string(job.period.count()), "-l",
                                          std::to_string(job.loops), "-h", std::to_string(kHistogramUs)});
  if (!child) return std::nullopt;
  return parse_cyclictest(child->finish(), job.loops);
}

}  // namespace driveline::bench
