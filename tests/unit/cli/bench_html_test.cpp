#include "text/bench_html.hpp"

#include <gmock/gmock.h>

#include <nlohmann/json.hpp>

namespace driveline::cli {
namespace {

using nlohmann::json;
using testing::HasSubstr;
using testing::Not;

json page_document(const std::string& bench, const std::string& name) {
  return {{"bench", bench},
          {"environment", {{"kernel", "6.1"}, {"cores", 4}, {"cpu", "a & b"}}},
          {"results", json::array({{{"case", name},
                                    {"metric", "cost"},
                                    {"unit", "ns"},
                                    {"n", 5},
                                    {"p50", 1.5},
                                    {"p99", 2.5},
                                    {"p999", 3.5},
                                    {"max", 4.56},
                                    {"aim", "p50<=1"},
                                    {"met", false},
                                    {"against", "floor"},
                                    {"ratio_p50", 1.25},
                                    {"ratio_p999", 2.0}}})}};
}

TEST(BenchHtml, HasTableEnvironmentAndVerdict) {
  const auto page = bench_html({page_document("drive", "1_drive")}, {});
  EXPECT_THAT(page, HasSubstr("<h2 id=\"drive\">drive</h2>"));
  EXPECT_THAT(page, HasSubstr("cores: 4; cpu: a &amp; b; kernel: 6.1"));
  EXPECT_THAT(page, HasSubstr("<td>1_drive</td><td>cost</td><td>ns</td><td class=\"figure\">5</td>"
                              "<td class=\"figure\">1.5</td><td class=\"figure\">2.5</td><td class=\"figure\">3.5</td>"
                              "<td class=\"figure\">4.6</td><td class=\"missed\">p50&lt;=1: missed</td>"
                              "<td>1.25 (2.00) x floor</td>"));
}

TEST(BenchHtml, PicturesAreInsideAndWithTheirProgram) {
  const auto page = bench_html({page_document("drive", "a"), page_document("jitter", "b"), page_document("jit", "c")},
                               {{"jitter_idle", "<svg>1</svg>"}, {"jitter", "<svg/>"}});
  const auto image = [](const std::string& name, const std::string& content) {
    return "<img alt=\"" + name + "\" src=\"data:image/svg+xml," + content + "\">";
  };
  EXPECT_THAT(page, HasSubstr(image("jitter_idle", "%3Csvg%3E1%3C%2Fsvg%3E")));
  EXPECT_THAT(page, HasSubstr(image("jitter", "%3Csvg%2F%3E")));
  EXPECT_LT(page.find("id=\"jitter\""), page.find("<img"));
  EXPECT_LT(page.rfind("<img"), page.find("id=\"jit\"")) << "a name that only begins alike has no picture";
}

TEST(BenchHtml, WhatADocumentSaysIsShownAndNotRun) {
  const auto page = bench_html({page_document("drive", "<script>x</script>")}, {{"drive", "\"><script>"}});
  EXPECT_THAT(page, Not(HasSubstr("<script>")));
  EXPECT_THAT(page, HasSubstr("&lt;script&gt;x&lt;/script&gt;"));
}

TEST(BenchHtml, AProgramThatCouldNotMeasureSaysSo) {
  auto document = page_document("turnaround", "a");
  document["results"] = json::array();
  EXPECT_THAT(bench_html({document}, {}), HasSubstr("<p>Skipped: it could not measure on this machine.</p>"));
}

}  // namespace
}  // namespace driveline::cli
