#include "text/machine_report.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <string_view>

#include "text/wrapped_text.hpp"

namespace driveline::cli {
namespace {

struct CostWord {
  rt::Cost cost;
  std::string_view text;  ///< text in reports
  std::string_view json;  ///< value in JSON
};

constexpr std::array kCostWords = {
    CostWord{rt::Cost::kPrevents, "PREVENTS", "prevents"},
    CostWord{rt::Cost::kPeriods, "COSTLY", "periods"},
    CostWord{rt::Cost::kMicroseconds, "SMALL", "microseconds"},
    CostWord{rt::Cost::kUnknown, "UNKNOWN", "unknown"},
};

std::string_view json_word(rt::Cost cost) {
  return std::find_if(kCostWords.begin(), kCostWords.end(), [cost](const CostWord& word) { return word.cost == cost; })
      ->json;
}

}  // namespace

std::string machine_text(const std::vector<rt::RealtimeItem>& items) {
  std::string text;
  for (const auto& word : kCostWords) {
    for (const auto& item : items) {
      if (item.ok || item.cost != word.cost) continue;
      auto plain = item;
      plain.remedy.clear();  // printed on a line of its own
      text += wrapped(fmt::format("{:<9} {:<24} ", word.text, item.name), rt::shortcoming(plain)) + "\n";
      if (!item.consequence.empty()) text += wrapped(fmt::format("{:<9} costs: ", ""), item.consequence) + "\n";
      if (!item.remedy.empty()) text += wrapped(fmt::format("{:<9} fix:   ", ""), item.remedy) + "\n";
    }
  }
  for (const auto& item : items) {
    if (item.ok) text += wrapped(fmt::format("{:<9} {:<24} ", "ok", item.name), item.effective) + "\n";
  }
  return text;
}

nlohmann::json machine_json(const std::vector<rt::RealtimeItem>& items) {
  auto list = nlohmann::json::array();
  for (const auto& item : items) {
    nlohmann::json row = {
        {"name", item.name}, {"requested", item.requested}, {"found", item.effective}, {"ok", item.ok}};
    row["cost"] = nullptr;
    row["consequence"] = nullptr;
    row["remedy"] = nullptr;
    if (!item.ok) {
      row["cost"] = json_word(item.cost);
      if (!item.consequence.empty()) row["consequence"] = item.consequence;
      if (!item.remedy.empty()) row["remedy"] = item.remedy;
    }
    list.push_back(std::move(row));
  }
  return list;
}

}  // namespace driveline::cli
