// Facts that drives report at the start of a run.
#include "driveline/runtime/setup/drive_facts.hpp"

#include <gmock/gmock.h>

#include <algorithm>
#include <cstdint>
#include <numbers>
#include <string>
#include <utility>
#include <vector>

#include "driveline/runtime/event.hpp"
#include "driveline/runtime/line.hpp"
#include "driveline/runtime/setup/composition.hpp"
#include "failure_of.hpp"
#include "support/temporary_directory.hpp"
#include "virtual_line.hpp"

namespace driveline::runtime {
namespace {

using motion::AxisConfig;
using motion::cia402::Mode;
using testing::Contains;

constexpr double kTurn = 2.0 * std::numbers::pi;

AxisConfig rotary_axis(double increments, bool assumed) {
  AxisConfig axis;
  axis.name = "x";
  axis.unit_per_revolution = kTurn;
  axis.increments_per_unit = increments / kTurn;
  axis.scale_assumed = assumed;
  return axis;
}

/// The refusal, or the difference.
std::string take(AxisConfig& axis, const DriveFacts& facts) {
  const auto taken = take_drive_facts(axis, facts);
  if (!taken) return describe(taken.error());
  if (!*taken) return "";
  return describe(Event{events::ScaleDiffers{axis.name, (*taken)->described, (*taken)->reported_by_drive}});
}

TEST(DriveFacts, ScaleIsFeedOverGearElseTheEncoder) {
  DriveFacts facts;
  EXPECT_FALSE(increments_per_revolution(facts));
  facts.encoder = DriveRatio{196608, 3};
  EXPECT_EQ(increments_per_revolution(facts), 65536.0);
  facts.feed = DriveRatio{36000, 2};
  EXPECT_EQ(increments_per_revolution(facts), 18000.0);
  facts.gear = DriveRatio{10, 4};
  EXPECT_EQ(increments_per_revolution(facts), 7200.0);
  facts.gear = DriveRatio{10, 0};
  EXPECT_EQ(increments_per_revolution(facts), 18000.0) << "no such gear";
  facts.feed = DriveRatio{0, 1};
  EXPECT_EQ(increments_per_revolution(facts), 65536.0);
}

TEST(DriveFacts, ScaleOfTheDriveCountsWhereTheDescriptionHasNone) {
  DriveFacts facts;
  facts.feed = DriveRatio{1080000, 3};
  auto axis = rotary_axis(1048576.0, true);
  EXPECT_EQ(take(axis, facts), "");
  EXPECT_NEAR(axis.increments_per_unit * kTurn, 360000.0, 1e-6);
  facts.feed = DriveRatio{1, 2};
  EXPECT_EQ(take(axis, facts),
            "axis x: according to 6092h, 6091h and 608Fh a turn of its motor is 0.5 increments, 1 to 4294967295 are "
            "expected: increments_per_revolution is needed");
}

TEST(DriveFacts, ScaleOfTheDescriptionCountsBeforeThatOfTheDriveAndThatIsTold) {
  DriveFacts facts;
  facts.feed = DriveRatio{360000, 1};
  auto axis = rotary_axis(360000.0, false);
  EXPECT_EQ(take(axis, facts), "");
  axis = rotary_axis(1048576.0, false);
  EXPECT_EQ(take(axis, facts),
            "axis x: increments_per_revolution is 1048576, and objects 6092h, 6091h and 608Fh of its drive give "
            "360000 increments per turn of the motor; driveline uses the line description");
  EXPECT_NEAR(axis.increments_per_unit * kTurn, 1048576.0, 1e-6);
}

TEST(DriveFacts, ModeThatTheDriveLacksIsRefusedWithThoseThatItHas) {
  auto axis = rotary_axis(1048576.0, true);
  axis.mode = Mode::kCyclicVelocity;
  DriveFacts facts;
  EXPECT_EQ(take(axis, facts), "");
  EXPECT_FALSE(axis.supported_modes) << "it does not tell";
  facts.supported_modes = 0x000000A1;
  EXPECT_EQ(take(axis, facts),
            "axis x: its drive does not support mode csv; according to 6502h it supports pp, hm, csp");
  axis.mode = Mode::kCyclicPosition;
  EXPECT_EQ(take(axis, facts), "");
  EXPECT_EQ(axis.supported_modes, 0xA1U);
  axis.mode = Mode::kInterpolatedPosition;
  EXPECT_EQ(
      take(axis, facts),
      "axis x: its drive does not support mode ip; according to 6502h it supports pp, hm, csp: with mode = \"pp\" "
      "in the [[axis]] the drive plans its motions itself");
}

TEST(DriveFacts, PolarityThatTurnsHalfOfItIsRefused) {
  auto axis = rotary_axis(1048576.0, true);
  DriveFacts facts;
  for (const auto both : {std::uint8_t{0x00}, std::uint8_t{0xC0}}) {
    facts.polarity = both;
    EXPECT_EQ(take(axis, facts), "");
  }
  facts.polarity = 0x80;
  EXPECT_EQ(take(axis, facts),
            "axis x: 607Eh of its drive is 80h, so it counts positions in another direction than velocities: both of "
            "bits 7 and 6 are expected, or none");
}

TEST(DriveFacts, PolarityThatTurnsNoTorquesIsRefusedWhereTheseAreUsed) {
  DriveFacts facts;
  facts.polarity = 0xC0;
  const auto* const refusal =
      "axis x: 607Eh of its drive is C0h and reverses positions and velocities but not torques, so that torques would "
      "have the wrong direction: polarity = \"reversed\" in the [[axis]] reverses all of them, with 607Eh = 0";
  auto axis = rotary_axis(1048576.0, true);
  axis.inertia = 3e-4;
  EXPECT_EQ(take(axis, facts), refusal);
  axis = rotary_axis(1048576.0, true);
  axis.mode = Mode::kCyclicTorque;
  EXPECT_EQ(take(axis, facts), refusal);
  axis.mode = Mode::kCyclicVelocity;
  EXPECT_EQ(take(axis, facts), "");
}

TEST(DriveFacts, RangeOfTheDriveIsThatOfTheAxis) {
  auto axis = rotary_axis(1048576.0, true);
  DriveFacts facts;
  facts.range_min = -500;
  facts.range_max = 499;
  EXPECT_EQ(take(axis, facts), "");
  EXPECT_EQ(axis.range_min, -500);
  EXPECT_EQ(axis.range_max, 499);
}

TEST(DriveFacts, TargetsOfVelocityModeCountInTurnsPerMinuteOrByTheFactorGroup) {
  auto axis = rotary_axis(1048576.0, true);
  DriveFacts facts;
  EXPECT_EQ(take(axis, facts), "");
  EXPECT_NEAR(axis.velocity_count, kTurn / 60.0, 1e-12) << "CiA 402-2, without 604Ch";
  facts.velocity_factor = DriveRatio{1, 10};
  EXPECT_EQ(take(axis, facts), "");
  EXPECT_NEAR(axis.velocity_count, kTurn / 600.0, 1e-12);
  facts.velocity_factor = DriveRatio{0xFFFFFFFF, 10};
  EXPECT_EQ(take(axis, facts), "");
  EXPECT_NEAR(axis.velocity_count, -kTurn / 600.0, 1e-12) << "it is signed";
  facts.velocity_factor = DriveRatio{0, 1};
  EXPECT_EQ(take(axis, facts), "");
  EXPECT_NEAR(axis.velocity_count, kTurn / 60.0, 1e-12) << "nothing could be told by it";

  axis.velocity_by_factors = true;
  facts.velocity_factor = DriveRatio{1048576, 60};
  EXPECT_EQ(take(axis, facts), "");
  EXPECT_NEAR(axis.velocity_count, kTurn / 60.0, 1e-12);
  facts.feed = DriveRatio{36000, 1};
  EXPECT_EQ(take(axis, facts), "");
  EXPECT_NEAR(axis.velocity_count, 1048576.0 / 60.0 / 36000.0 * kTurn, 1e-9) << "by the scale of the drive";
}

TEST(DriveFacts, ObjectsThatCannotBeReadAreLeftOut) {
  std::vector<std::uint16_t> asked;
  const auto facts =
      ask_drive_facts([&](std::uint16_t index, std::uint8_t sub) -> std::optional<std::vector<std::byte>> {
        asked.push_back(index);
        if (index == 0x6092)
          return std::vector<std::byte>{std::byte{sub == 1 ? std::uint8_t{200} : std::uint8_t{2}}, {}, {}, {}};
        if (index == 0x6091) return std::vector<std::byte>(2);
        return std::nullopt;
      });
  EXPECT_EQ(increments_per_revolution(facts), 100.0);
  EXPECT_FALSE(facts.supported_modes);
  EXPECT_FALSE(facts.gear) << "of another size";
  EXPECT_THAT(asked, Contains(0x608F));
}

class Events final : public Observer {
 public:
  void event(const Event& event) override { told.push_back(describe(event)); }
  void poll() override {}
  std::vector<std::string> told;
};

class DriveFactsOfALine : public test::TemporaryDirectory {
 protected:
  RunReport run(const std::string& drive, const std::string& axis) {
    auto line = virtual_line("[line]\ncycle_us = 1000\n[telemetry]\nenabled = false\n[[slave]]\nname = \"x\"\n" +
                                 drive + "[[axis]]\nname = \"x\"\nunit = \"rev\"\n" + axis,
                             directory);
    EXPECT_TRUE(line) << describe(line.error());
    (*line)->observe(events);
    Line::RunSettings settings;
    settings.duration_s = 0.5;
    auto report = (*line)->run(settings);
    EXPECT_TRUE(report) << describe(report.error());
    return report ? std::move(*report) : RunReport{};
  }
  Events events;
};

TEST_F(DriveFactsOfALine, ScaleIsAskedForWhereItIsLeftOut) {
  const auto report = run("[slave.plant.encoder]\nincrements_per_revolution = 65536\n", "");
  EXPECT_EQ(failure_of(report), "");
  EXPECT_NEAR(report.axes.at(0).increments_per_unit, 65536.0, 1e-6);
}

TEST_F(DriveFactsOfALine, ScaleThatIsAnotherIsTold) {
  const auto report =
      run("[slave.plant.encoder]\nincrements_per_revolution = 65536\n", "increments_per_revolution = 1048576\n");
  EXPECT_NEAR(report.axes.at(0).increments_per_unit, 1048576.0, 1e-6);
  EXPECT_THAT(
      events.told,
      Contains("axis x: increments_per_revolution is 1048576, and objects 6092h, 6091h and 608Fh of its drive give "
               "65536 increments per turn of the motor; driveline uses the line description"));
}

TEST_F(DriveFactsOfALine, FactorsThatTheLineDescriptionWritesAreThoseThatCount) {
  const auto report =
      run("[[slave.sdo]]\nindex = 0x6092\nsubindex = 1\ntype = \"uint32\"\nvalue = 36000\n"
          "[[slave.sdo]]\nindex = 0x6092\nsubindex = 2\ntype = \"uint32\"\nvalue = 5\n"
          "[[slave.sdo]]\nindex = 0x6091\nsubindex = 1\ntype = \"uint32\"\nvalue = 10\n"
          "[[slave.sdo]]\nindex = 0x6091\nsubindex = 2\ntype = \"uint32\"\nvalue = 3\n",
          "");
  EXPECT_EQ(failure_of(report), "");
  EXPECT_NEAR(report.axes.at(0).increments_per_unit, 36000.0 / 5.0 / (10.0 / 3.0), 1e-6);
}

TEST_F(DriveFactsOfALine, ModuloIsWrittenToTheDrive) {
  const auto config = parse_line_config(
      "[[slave]]\nname = \"x\"\n[[axis]]\nname = \"x\"\nunit = \"rev\"\nincrements_per_revolution = 1048576\nmodulo = "
      "1\n",
      "line.toml");
  ASSERT_TRUE(config) << describe(config.error());
  const auto plans = make_slave_plans(*config);
  const auto& sdos = plans.at(0).startup_sdos;
  const auto written = [&](std::uint8_t subindex, std::int32_t value) {
    const auto expected = motion::startup_sdo(0x607B, subindex, value);
    return std::any_of(sdos.begin(), sdos.end(), [&](const auto& sdo) {
      return sdo.index == expected.index && sdo.subindex == expected.subindex && sdo.data == expected.data;
    });
  };
  EXPECT_TRUE(written(1, 0));
  EXPECT_TRUE(written(2, 1048575));
  EXPECT_EQ(failure_of(run("", "increments_per_revolution = 1048576\nmodulo = 1\n")), "");
}

}  // namespace
}  // namespace driveline::runtime
