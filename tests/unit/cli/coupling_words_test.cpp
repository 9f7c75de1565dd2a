// Parsing of orders for gears and cams.
#include "axes/coupling_words.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <memory>
#include <string>
#include <vector>

#include "axes/axis_words.hpp"
#include "script/axis_script.hpp"

namespace driveline::cli {
namespace {

using motion::AxisConfig;
using runtime::CouplingOrder;
using testing::HasSubstr;

AxisConfig axis(const std::string& name, const char* unit) {
  AxisConfig made;
  made.name = name;
  made.unit = trajectory::find_position_unit(unit);
  made.kind = made.unit->kind;
  made.limits = {0.5, 2.0};
  return made;
}

/// x follows the linear axis y, z an encoder in degrees; there is a cam for x.
class CouplingWords : public testing::Test {
 protected:
  CouplingWords() : axes{axis("x", "mm"), axis("y", "mm"), axis("z", "deg")} {
    trajectory::CamTable table;
    table.master_unit = table.slave_unit = trajectory::find_position_unit("mm");
    table.points = {{0.0, 0.0}, {0.1, 0.02}, {0.2, 0.0}};
    plan.cams.push_back(
        {"lift",
         std::make_shared<const trajectory::Cam>(
             trajectory::Cam::make(table, trajectory::CamMethod::kCubic, trajectory::CamKind::kPeriodic).value())});
    auto& encoder = plan.encoders.emplace_back();
    encoder.name = "wheel";
    encoder.unit = trajectory::find_position_unit("deg");
    auto& first = plan.couplings.emplace_back();
    first.axis = 1;
    first.ratio = trajectory::GearRatio::make(2, 3).value();
    auto& second = plan.couplings.emplace_back();
    second.slave = 2;
    second.encoder = 0;
  }
  [[nodiscard]] CouplingOrder read(std::size_t slave, std::string_view text) const {
    const auto order = parse_coupling_order(axes, plan, slave, split_words(text));
    EXPECT_TRUE(order) << order.error().text;
    return order.value_or(CouplingOrder{});
  }
  [[nodiscard]] std::string refusal(std::size_t slave, std::string_view text) const {
    const auto order = parse_coupling_order(axes, plan, slave, split_words(text));
    EXPECT_FALSE(order) << text;
    return order ? std::string{} : order.error().text;
  }

  std::vector<AxisConfig> axes;
  runtime::CouplingPlan plan;
};

TEST_F(CouplingWords, AGearHasTheRatioOfItsCouplingOrItsOwn) {
  EXPECT_EQ(read(0, "gear-in").ratio.numerator(), 2);
  EXPECT_EQ(read(0, "gear-in -1/4").ratio.denominator(), 4);
  EXPECT_EQ(read(0, "gear-in 3").ratio.numerator(), 3);
  const auto at = read(0, "gear-in 1/1 at=400mm to=0.05m over=120");
  EXPECT_DOUBLE_EQ(at.at.value(), 0.4);
  EXPECT_DOUBLE_EQ(at.to, 0.05);
  EXPECT_DOUBLE_EQ(at.over, 0.12);
  EXPECT_EQ(at.text, "gear-in 1/1 at=400mm to=0.05m over=120");
  EXPECT_NEAR(read(2, "gear-in at=180deg to=0").at.value(), 3.14159265, 1e-6);
  EXPECT_EQ(read(0, "gear-out").kind, CouplingOrder::Kind::kOut);
}

TEST_F(CouplingWords, AGearBetweenAnAngleAndALengthHasUnits) {
  plan.couplings[1].encoder.reset();
  plan.couplings[1].axis = 1;  // z in degrees follows y in mm
  constexpr double kTurn = 6.283185307179586;
  for (const auto* const text : {"gear-in 360deg:25mm", "gear-in \"360 deg : 25 mm\"", "gear-in 360 deg : 25 mm",
                                 "gear-in 1 rev:0.025m", "gear-in 360:25", "gear-in -360deg:-25mm"}) {
    EXPECT_DOUBLE_EQ(read(2, text).ratio.travel(0.05), 2.0 * kTurn) << text;
  }
  EXPECT_DOUBLE_EQ(read(0, "gear-in 5mm:0.03m").ratio.factor(), 1.0 / 6.0) << "of the same kind";
  EXPECT_THAT(refusal(2, "gear-in 1/36"),
              HasSubstr("axis z: gear-in: \"1/36\": the slave is rotary and its master linear: a ratio with units is "
                        "expected, such as 360deg:10mm"));
  EXPECT_THAT(refusal(2, "gear-in"), HasSubstr("and the [[coupling]] has no ratio: a ratio with units is expected"));
  EXPECT_THAT(refusal(2, "gear-in 25mm:360deg"), HasSubstr("ratio, slave \"25mm\": axis z has no unit \"mm\""));
  EXPECT_THAT(refusal(2, "gear-in 0deg:5mm"), HasSubstr("other than 0"));
  plan.couplings[1].ratio = trajectory::GearRatio::of_travel(kTurn, 0.05).value();
  plan.couplings[1].ratio_given = true;
  EXPECT_DOUBLE_EQ(read(2, "gear-in").ratio.travel(0.1), 2.0 * kTurn);
}

TEST_F(CouplingWords, ACamHasPlacesOfItsZeroAndAPhaseLimitsOfTheMaster) {
  const auto cam = read(0, "cam-in lift master=100 slave=-5mm");
  EXPECT_EQ(cam.cam, 0U);
  EXPECT_DOUBLE_EQ(cam.master_zero, 0.1);
  EXPECT_DOUBLE_EQ(cam.slave_zero, -0.005);
  const auto phase = read(0, "phase 5mm");
  EXPECT_DOUBLE_EQ(phase.phase, 0.005);
  EXPECT_FALSE(phase.relative);
  EXPECT_DOUBLE_EQ(phase.limits.max_velocity, 0.05) << "a tenth of the master's";
  const auto by = read(0, "phase by=-1mm velocity=20 acceleration=100mm/s^2 jerk=1000");
  EXPECT_TRUE(by.relative);
  EXPECT_DOUBLE_EQ(by.limits.max_velocity, 0.02);
  EXPECT_DOUBLE_EQ(by.limits.max_acceleration, 0.1);
  EXPECT_DOUBLE_EQ(by.limits.max_jerk, 1.0);
}

TEST_F(CouplingWords, WhatCannotBeIsASentence) {
  EXPECT_THAT(refusal(1, "gear-in"), HasSubstr("axis y: gear-in: it has no master: a [[coupling]] with slave = \"y\""));
  EXPECT_THAT(refusal(0, "gear-in 0/1"), HasSubstr("axis x: gear-in: "));
  EXPECT_THAT(refusal(0, "gear-in 1/0"), HasSubstr("axis x: gear-in: "));
  EXPECT_THAT(refusal(0, "gear-in nan"), HasSubstr("a ratio of whole numbers such as 3/2 is expected"));
  EXPECT_THAT(refusal(0, "gear-in at=5"), HasSubstr("must be given together"));
  EXPECT_THAT(refusal(0, "gear-in over=5"), HasSubstr("over= needs at="));
  EXPECT_THAT(refusal(0, "gear-in at=5 to=5 over=-1"), HasSubstr("above 0"));
  EXPECT_THAT(refusal(0, "gear-in at=nan to=5"), HasSubstr("a number is expected"));
  EXPECT_THAT(refusal(0, "gear-in at=5deg to=5"), HasSubstr("deg"));
  EXPECT_THAT(refusal(0, "cam-in lfit"), HasSubstr("there is no cam \"lfit\", but lift"));
  EXPECT_THAT(refusal(0, "cam-in"), HasSubstr("the name of a cam is needed"));
  EXPECT_THAT(refusal(2, "cam-in lift"), HasSubstr("does not fit these axes"));
  EXPECT_THAT(refusal(0, "cam-out now"), HasSubstr("\"now\" was not expected"));
  EXPECT_THAT(refusal(0, "phase"), HasSubstr("an offset of the master, or by=DISTANCE, is needed"));
  EXPECT_THAT(refusal(0, "phase 5 velocity=0"), HasSubstr("velocity must be above 0"));
  EXPECT_THAT(refusal(0, "phase 5 vleocity=1"), HasSubstr("did you mean velocity?"));
  EXPECT_THAT(refusal(0, "gear-in velocity=1"), HasSubstr("\"velocity=\" does not belong there"));
}

TEST_F(CouplingWords, ScriptsTakeThemAndHaveFileAndLine) {
  EXPECT_TRUE(AxisScript::parse("x gear-in 1/2\nwait x\nx phase 5mm\nx gear-out\n", "moves.txt", {axes, {}, &plan}));
  const auto wrong = AxisScript::parse("x gear-in\ny gear-in\n", "moves.txt", {axes, {}, &plan});
  ASSERT_FALSE(wrong);
  EXPECT_THAT(wrong.error().text, HasSubstr("moves.txt:2: axis y: gear-in: it has no master"));
}

}  // namespace
}  // namespace driveline::cli
