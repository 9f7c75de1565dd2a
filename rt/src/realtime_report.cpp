#include "driveline/rt/realtime_report.hpp"

#include <algorithm>
#include <system_error>

namespace driveline::rt {

namespace {

constexpr std::size_t kNameWidth = 22;

std::string shortcoming(const RealtimeItem& item) {
  std::string text = item.effective + " instead of " + item.requested;
  if (item.error_number != 0) {
    text += " (" + std::generic_category().message(item.error_number) + ")";
  }
  if (!item.remedy.empty()) {
    text += "; remedy: " + item.remedy;
  }
  return text;
}

std::string to_line(const RealtimeItem& item, const std::string& marker_if_not_ok) {
  std::string line = item.name;
  line.resize(std::max(kNameWidth, line.size() + 1), ' ');
  return line + (item.ok ? "ok       " + item.effective : marker_if_not_ok + shortcoming(item));
}

}  // namespace

bool RealtimeReport::complete() const noexcept {
  return std::all_of(settings.begin(), settings.end(), [](const RealtimeItem& item) { return item.ok; });
}

std::string RealtimeError::message() const {
  std::string text = "real-time set-up refused";
  for (const RealtimeItem& item : report.settings) {
    if (!item.ok) {
      text += "; " + item.name + " is " + shortcoming(item);
    }
  }
  return text;
}

std::vector<std::string> to_lines(const RealtimeReport& report) {
  std::vector<std::string> lines;
  for (const RealtimeItem& item : report.settings) {
    lines.push_back(to_line(item, "MISSING  "));
  }
  for (const RealtimeItem& item : report.platform) {
    lines.push_back(to_line(item, "note     "));
  }
  return lines;
}

}  // namespace driveline::rt
