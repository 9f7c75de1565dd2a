#include "text/bench_html.hpp"

#include <fmt/format.h>

#include <cctype>
#include <nlohmann/json.hpp>
#include <string_view>

#include "text/bench_report.hpp"

namespace driveline::cli {
namespace {

using nlohmann::json;

constexpr std::string_view kHead =
    "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n<title>Benchmarks</title>\n<style>\n"
    "body { font-family: sans-serif; margin: 2em auto; max-width: 75em; padding: 0 1em; color: #222; }\n"
    "table { border-collapse: collapse; font-size: 0.9em; }\n"
    "th, td { border-bottom: 1px solid #ddd; padding: 0.25em 0.7em; text-align: left; }\n"
    "td.figure, th.figure { text-align: right; font-variant-numeric: tabular-nums; }\n"
    "td.missed { color: #b00; font-weight: bold; }\nimg { max-width: 100%; margin-top: 1em; }\n"
    ".where { color: #555; }\n</style>\n</head>\n<body>\n<h1>Benchmarks</h1>\n";

std::string escaped(std::string_view text) {
  std::string safe;
  for (const char c : text) {
    switch (c) {
      case '<':
        safe += "&lt;";
        break;
      case '>':
        safe += "&gt;";
        break;
      case '&':
        safe += "&amp;";
        break;
      case '"':
        safe += "&quot;";
        break;
      default:
        safe += c;
    }
  }
  return safe;
}

/// A picture as a data URL (RFC 2397). Used as an image, it cannot run scripts.
std::string data_address(std::string_view svg) {
  std::string address = "data:image/svg+xml,";
  for (const char c : svg) {
    const auto byte = static_cast<unsigned char>(c);
    if (std::isalnum(byte) != 0 || c == '-' || c == '_' || c == '.' || c == '~') {
      address += c;
    } else {
      address += fmt::format("%{:02X}", byte);
    }
  }
  return address;
}

std::string cell(std::string_view text, std::string_view kind = "") {
  const auto attribute = kind.empty() ? std::string() : fmt::format(" class=\"{}\"", kind);
  return fmt::format("<td{}>{}</td>", attribute, escaped(text));
}

std::string row_html(const json& row) {
  std::string text = "<tr>";
  for (const auto* key : {"case", "metric", "unit"}) text += cell(row[key].get<std::string>());
  text += cell(fmt::format("{}", row["n"].get<std::uint64_t>()), "figure");
  for (const auto* key : {"p50", "p99", "p999", "max"}) {
    text += cell(fmt::format("{:.1f}", row[key].get<double>()), "figure");
  }
  const bool aimed = row.contains("aim");
  const bool met = row.value("met", false);
  text += cell(aimed ? fmt::format("{}: {}", row["aim"].get<std::string>(), met ? "met" : "missed") : std::string(),
               aimed && !met ? "missed" : "");
  text += cell(comparison_text(row));
  return text + "</tr>\n";
}

/// A table of all rows with an aim, and their measured values; empty: no row has an aim.
std::string aims_html(const std::vector<json>& documents) {
  std::string rows;
  int met = 0;
  int all = 0;
  for (const auto& document : documents) {
    for (const auto& row : document["results"]) {
      if (!row.contains("aim")) continue;
      const bool is_met = row.value("met", false);
      met += is_met ? 1 : 0;
      ++all;
      rows += "<tr>" + cell(document["bench"].get<std::string>()) + cell(row["case"].get<std::string>()) +
              cell(row["metric"].get<std::string>()) + cell(fmt::format("{:.1f}", row["p50"].get<double>()), "figure") +
              cell(row["unit"].get<std::string>()) +
              cell(fmt::format("{}: {}", row["aim"].get<std::string>(), is_met ? "met" : "missed"),
                   is_met ? "" : "missed") +
              cell(comparison_text(row)) + "</tr>\n";
    }
  }
  if (all == 0) return {};
  return fmt::format(
      "<h2>Targets</h2>\n<p>{} of {} met</p>\n<table>\n<tr><th>program</th><th>case</th><th>metric</th>"
      "<th class=\"figure\">p50</th><th>unit</th><th>aim</th><th>against: p50 (p99.9)</th></tr>\n{}</table>\n",
      met, all, rows);
}

/// All facts of the document about the machine and the build.
std::string environment_html(const json& environment) {
  std::string text;
  for (const auto& [key, value] : environment.items()) {
    text += fmt::format("{}{}: {}", text.empty() ? "" : "; ", escaped(key),
                        escaped(value.is_string() ? value.get<std::string>() : value.dump()));
  }
  return fmt::format("<p class=\"where\">{}</p>\n", text);
}

bool belongs_to(std::string_view picture, std::string_view bench) {
  return picture == bench || (picture.starts_with(bench) && picture[bench.size()] == '_');
}

}  // namespace

std::string bench_html(const std::vector<json>& documents, const std::map<std::string, std::string>& pictures) {
  auto text = std::string(kHead) + aims_html(documents);
  for (const auto& document : documents) {
    const auto bench = document["bench"].get<std::string>();
    text += fmt::format("<h2 id=\"{0}\">{0}</h2>\n", escaped(bench)) + environment_html(document["environment"]);
    if (document["results"].empty()) {
      text += "<p>Skipped: it could not measure on this machine.</p>\n";
      continue;
    }
    text +=
        "<table>\n<tr><th>case</th><th>metric</th><th>unit</th><th class=\"figure\">n</th><th class=\"figure\">p50</th>"
        "<th class=\"figure\">p99</th><th class=\"figure\">p99.9</th><th class=\"figure\">max</th><th>aim</th>"
        "<th>against: p50 (p99.9)</th></tr>\n";
    for (const auto& row : document["results"]) text += row_html(row);
    text += "</table>\n";
    for (const auto& [name, svg] : pictures) {
      if (belongs_to(name, bench))
        text += fmt::format("<p><img alt=\"{}\" src=\"{}\"></p>\n", escaped(name), data_address(svg));
    }
  }
  return text + "</body>\n</html>\n";
}

}  // namespace driveline::cli
