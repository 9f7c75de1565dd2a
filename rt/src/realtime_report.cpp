#include "driveline/rt/realtime_report.hpp"

#include <algorithm>
#include <system_error>

namespace driveline::rt {

namespace {

constexpr std::size_t kNameWidth = 22;

std::string to_line(const RealtimeItem& item, const std::string& marker_if_not_ok) {
  std::string line = item.name;
  line.resize(std::max(kNameWidth, line.size() + 1), ' ');
  return line + (item.ok ? "ok       " + item.effective : marker_if_not_ok + shortcoming(item));
}

}  // namespace

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

const RealtimeItem* most_important(const std::vector<RealtimeItem>& items) noexcept {
  const RealtimeItem* most = nullptr;
  for (const RealtimeItem& item : items) {
    if (!item.ok && (most == nullptr || item.cost > most->cost)) most = &item;
  }
  return most;
}

std::vector<std::string> to_lines(const RealtimeReport& report) {
  std::vector<std::string> lines;
  for (const RealtimeItem& item : report.settings) {
    lines.push_back(to_line(item, "MISSING  "));
  }
  if (!report.cpu_latency.name.empty()) lines.push_back(to_line(report.cpu_latency, "note     "));
  const RealtimeItem* const finding = most_important(report.platform);
  if (finding == nullptr) return lines;
  lines.push_back(to_line(*finding, "note     "));
  const auto others =
      std::count_if(report.platform.begin(), report.platform.end(), [](const RealtimeItem& item) { return !item.ok; });
  if (others > 1) {
    lines.push_back("machine               note     " + std::to_string(others - 1) +
                    " more findings; `driveline doctor` shows them all");
  }
  return lines;
}

}  // namespace driveline::rt
