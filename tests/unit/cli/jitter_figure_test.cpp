#include "text/jitter_figure.hpp"

#include <gmock/gmock.h>

#include <nlohmann/json.hpp>

namespace driveline::cli {
namespace {

using nlohmann::json;
using testing::HasSubstr;
using testing::Not;

json jitter_row(const std::string& name, const std::string& metric, const std::string& bins, int missed) {
  return {{"case", name},
          {"metric", metric},
          {"unit", "ns"},
          {"n", 10},
          {"p50", 14'000},
          {"p99", 15'000},
          {"p999", 300'500},
          {"max", 300'500},
          {"histogram", {{"deadline_us", 125.0}, {"missed", missed}, {"bins", json::parse(bins)}}}};
}

json jitter_document(const std::vector<json>& rows) {
  return {{"bench", "jitter"}, {"environment", json::object()}, {"results", rows}};
}

TEST(JitterFigure, HasEveryMeasurementAndMissedPeriodsInABarOfTheirOwn) {
  const auto figures = jitter_figures(
      jitter_document({jitter_row("idle_bare_loop", "wake_latency", "[[13, 10]]", 0),
                       jitter_row("idle_cycle_pure_sleep", "wake_latency", "[[0, 8], [15, 1], [300, 1]]", 1)}));
  ASSERT_EQ(figures.size(), 1U);
  EXPECT_EQ(figures[0].name, "jitter_idle_wake_latency");
  // Two blocks per method; a dummy value keeps the number of an empty block.
  EXPECT_EQ(figures[0].data,
            "# bare_loop\n13 10\n\n\n# bare_loop, missed\n-1 0\n\n\n"
            "# cycle_pure_sleep\n0 8\n15 1\n\n\n# cycle_pure_sleep, missed\n131 1\n\n\n");
  const auto& script = figures[0].script;
  EXPECT_THAT(script, HasSubstr("set logscale y"));
  EXPECT_THAT(script, HasSubstr("set arrow 1 from 125,graph 0 to 125,graph 1 nohead lw 2 lc 'red'")) << "the deadline";
  EXPECT_THAT(script, HasSubstr("'p50 14.0'"));
  EXPECT_THAT(script, HasSubstr("'p99 15.0'"));
  EXPECT_THAT(script, Not(HasSubstr("'p99.9 300.5'"))) << "beyond the deadline, where the bar is";
  EXPECT_THAT(script,
              HasSubstr("'bare_loop: 10 instants, max 300.5 us', NaN with boxes lc rgb 'red' title 'missed: none'"));
  EXPECT_THAT(script, HasSubstr("index 3 using 1:2:(8) with boxes lc rgb 'red' title 'missed: 1'"));
}

TEST(JitterFigure, IsOnePerStateOfTheMachineAndMetric) {
  const auto figures = jitter_figures(jitter_document({jitter_row("idle_cycle", "wake_latency", "[[13, 10]]", 0),
                                                       jitter_row("idle_cycle", "send_time", "[[13, 10]]", 0),
                                                       jitter_row("load_cycle", "wake_latency", "[[130, 10]]", 10)}));
  ASSERT_EQ(figures.size(), 3U);
  EXPECT_EQ(figures[1].name, "jitter_idle_send_time");
  EXPECT_EQ(figures[2].name, "jitter_load_wake_latency");
  EXPECT_THAT(figures[2].script, HasSubstr("plot NaN title 'cycle: 10 instants, max 300.5 us', "
                                           "'jitter_load_wake_latency.dat' index 1"))
      << "all of them were missed";
}

TEST(JitterFigure, EqualLogarithmicBarsHoldAllThatWasMeasured) {
  auto row = jitter_row("idle_cycle", "wake_latency", "[[0, 4], [14, 2], [124, 1], [125, 1], [300, 2]]", 3);
  auto& histogram = row["histogram"];
  histogram["per_decade"] = 20;
  histogram["unresolved"] = {{"below_bin", 28}, {"count", 3}};
  // The period is in bin 101: one of its two values was in time, one was missed.
  histogram["log_bins"] = json::parse("[[30, 1], [82, 2], [101, 2], [109, 2]]");
  const auto figures = jitter_figures(jitter_document({row}));
  ASSERT_EQ(figures.size(), 2U);
  EXPECT_EQ(figures[1].name, "jitter_idle_wake_latency_log");
  EXPECT_EQ(figures[1].data,
            "# cycle\n0.0316228 0.0354813 1\n12.5893 14.1254 2\n112.202 125 1\n\n\n0.0139549 0.0228353 3\n\n\n"
            "125 125.893 1\n281.838 316.228 2\n\n\n")
      << "missed periods are at their delays";
  EXPECT_THAT(figures[1].script, HasSubstr("'max 300.50' at 300.5,"));
  EXPECT_THAT(figures[1].script, HasSubstr("set logscale xy"));
  EXPECT_THAT(figures[1].script, HasSubstr("'unresolved: 3'"));
  EXPECT_THAT(figures[1].script, HasSubstr("'missed: 3'"));
}

TEST(JitterFigure, ANameCannotEndItsQuotes) {
  const auto figures =
      jitter_figures(jitter_document({jitter_row("idle_a'; system 'x", "wake_latency", "[[1, 10]]", 0)}));
  EXPECT_THAT(figures.at(0).script, Not(HasSubstr("a'; system")));
}

}  // namespace
}  // namespace driveline::cli
