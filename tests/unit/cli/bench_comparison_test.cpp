#include "text/bench_comparison.hpp"

#include <gmock/gmock.h>

#include <nlohmann/json.hpp>

namespace driveline::cli {
namespace {

using nlohmann::json;
using testing::HasSubstr;
using testing::Not;

json measured(const std::string& name, double p50) {
  return {{"case", name}, {"metric", "cost"}, {"unit", "ns"}, {"n", 10}, {"p50", p50}};
}

json with_turns(json row, double mean, double low, double high) {
  row["against"] = "floor";
  row["ratio_turns"] = {{"turns", 20}, {"mean", mean}, {"low", low}, {"high", high}};
  return row;
}

std::vector<json> run_of(const std::vector<json>& rows, const json& environment = json::object()) {
  return {{{"bench", "esc"}, {"environment", environment}, {"results", rows}}};
}

json only_row(const json& first, const json& second) {
  const auto comparison = compare_benches(run_of({first}), run_of({second}));
  return comparison["rows"].at(0);
}

TEST(BenchComparison, TakesTheMachineOutWhereBothHaveTheSameFloor) {
  // A machine that is half as fast: the figure has doubled, but not its ratio to the floor.
  const auto row =
      only_row(with_turns(measured("a", 100), 1.10, 1.05, 1.15), with_turns(measured("a", 200), 1.11, 1.06, 1.16));
  EXPECT_EQ(row["ratio"], 2.0);
  EXPECT_NEAR(row["ratio_against"].get<double>(), 1.11 / 1.10, 1e-4);
  EXPECT_EQ(row["verdict"], "same");
  EXPECT_LT(row["low"].get<double>(), 1.0);
  EXPECT_GT(row["high"].get<double>(), 1.0);
}

TEST(BenchComparison, IsAsUnsureAsBothRunsTogether) {
  const auto row = only_row(with_turns(measured("a", 100), 1.0, 0.97, 1.0 / 0.97),
                            with_turns(measured("a", 100), 1.0, 0.96, 1.0 / 0.96));
  // 3 % and 4 % add up as squares.
  EXPECT_NEAR(row["high"].get<double>(), 1.052, 1e-3);
  EXPECT_NEAR(row["low"].get<double>(), 1.0 / 1.052, 1e-3);
}

TEST(BenchComparison, SaysMoreOrLessOnlyBeyondTheInterval) {
  const auto before = with_turns(measured("a", 100), 1.0, 0.99, 1.01);
  EXPECT_EQ(only_row(before, with_turns(measured("a", 100), 1.1, 1.09, 1.11))["verdict"], "more");
  EXPECT_EQ(only_row(before, with_turns(measured("a", 100), 0.9, 0.89, 0.91))["verdict"], "less");
  EXPECT_EQ(only_row(before, with_turns(measured("a", 100), 1.1, 0.9, 1.34))["verdict"], "same");
}

TEST(BenchComparison, HasNoIntervalWithoutTurnsOrWithAnotherFloor) {
  EXPECT_FALSE(only_row(measured("a", 100), measured("a", 110)).contains("verdict"));
  auto other = with_turns(measured("a", 100), 1.0, 0.99, 1.01);
  other["against"] = "another";
  EXPECT_FALSE(only_row(with_turns(measured("a", 100), 1.0, 0.99, 1.01), other).contains("verdict"));
  EXPECT_TRUE(only_row(measured("a", 0), measured("a", 110))["ratio"].is_null()) << "nothing to divide by";
}

TEST(BenchComparison, NamesWhatOnlyOneHasAndWhatDiffers) {
  const auto comparison =
      compare_benches(run_of({measured("a", 1), measured("b", 1)}, {{"commit", "1"}, {"date", "monday"}}),
                      run_of({measured("a", 1), measured("c", 1)}, {{"commit", "2"}, {"date", "friday"}}));
  EXPECT_EQ(comparison["rows"].size(), 1U);
  EXPECT_EQ(comparison["only_first"], json::array({"esc b cost"}));
  EXPECT_EQ(comparison["only_second"], json::array({"esc c cost"}));
  EXPECT_EQ(comparison["differences"], json::parse(R"([{"fact": "commit", "first": "1", "second": "2"}])"));
  const auto text = comparison_report(comparison);
  EXPECT_THAT(text, HasSubstr("commit: 1, then 2\n"));
  EXPECT_THAT(text, HasSubstr("Figures that only the second run has: 1\n"));
  EXPECT_THAT(text, Not(HasSubstr("monday")));
}

}  // namespace
}  // namespace driveline::cli
