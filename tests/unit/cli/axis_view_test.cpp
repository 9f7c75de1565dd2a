// Axes as text and as JSON.
#include "axes/axis_view.hpp"

#include <gmock/gmock.h>

#include <nlohmann/json.hpp>
#include <numbers>
#include <sstream>
#include <string>

namespace driveline::cli {
namespace {

using testing::HasSubstr;
using testing::Not;

constexpr double kTurn = 2.0 * std::numbers::pi;

runtime::AxisStatus status_at(double position, std::optional<double> modulo) {
  runtime::AxisStatus status;
  status.axis.name = "x";
  status.axis.unit = *trajectory::find_position_unit("deg");
  status.axis.modulo = modulo;
  status.owner = "hand";
  status.report.emplace().position = position;
  return status;
}

TEST(AxisView, AnEndlessAxisIsShownWithinItsModuloToo) {
  for (const auto& [position, within] :
       {std::pair{3.25 * kTurn, 90.0}, {-0.25 * kTurn, 270.0}, {0.0, 0.0}, {-1e-300, 0.0}, {kTurn, 0.0}}) {
    const auto axis = to_json(status_at(position, kTurn));
    EXPECT_DOUBLE_EQ(axis.at("modulo").get<double>(), 360.0);
    EXPECT_NEAR(axis.at("modulo_position").get<double>(), within, 1e-9) << position;
    EXPECT_GE(axis.at("modulo_position").get<double>(), 0.0);
    EXPECT_LT(axis.at("modulo_position").get<double>(), 360.0);
    EXPECT_NEAR(axis.at("position").get<double>(), position / kTurn * 360.0, 1e-9) << "the other one goes on";
  }
  const auto axis = to_json(status_at(3.25 * kTurn, kTurn));
  EXPECT_EQ(axis_line(axis), "axis x: Disabled at 1170 deg (90 of 360 deg)");
  EXPECT_EQ(motion_line(axis), "axis x: Disabled at 1170 deg (90 of 360 deg), 0 deg/s, 0 Nm");
  EXPECT_THAT(axes_table(nlohmann::json::array({axis})), HasSubstr("1170 deg (90 of 360 deg)"));
}

TEST(AxisView, TheTableFitsATerminalAndNamesEachOwnerOnce) {
  auto moving = status_at(1000.25 * kTurn, std::nullopt);
  moving.axis.name = "turntable";
  moving.report->state = motion::PlcopenState::kSynchronizedMotion;
  moving.report->velocity = -100.0 * kTurn;
  moving.report->torque = -12.3456;
  auto other = moving;
  other.axis.name = "y";
  auto free = status_at(0.0, std::nullopt);
  free.axis.name = "z";
  moving.owner = other.owner = "control socket 123 (process 1234567, user 1000)";
  free.owner = "";
  const auto table = axes_table(nlohmann::json::array({to_json(moving), to_json(free), to_json(other)}));
  std::istringstream lines(table);
  for (std::string line; std::getline(lines, line);) EXPECT_LE(line.size(), 80U) << line;
  EXPECT_THAT(table, HasSubstr("\nturntable SynchronizedMotion 360090 deg -36000 deg/s -12.3456 Nm -       100 %\n"));
  EXPECT_THAT(table, HasSubstr("\ncommanded by control socket 123 (process 1234567, user 1000): turntable, y\n"
                               "commanded by nobody: z\n"));
}

TEST(AxisView, OtherAxesHaveOnePlace) {
  const auto axis = to_json(status_at(3.25 * kTurn, std::nullopt));
  EXPECT_FALSE(axis.contains("modulo"));
  EXPECT_FALSE(axis.contains("modulo_position"));
  EXPECT_EQ(axis_line(axis), "axis x: Disabled at 1170 deg");
  EXPECT_THAT(axes_table(nlohmann::json::array({axis})), Not(HasSubstr(" of ")));
}

TEST(AxisView, WhatATouchProbeHasRecordedIsShownOnceThereIsSomething) {
  auto status = status_at(0.0, std::nullopt);
  EXPECT_FALSE(to_json(status).contains("recorded_position"));
  status.report->recorded_request = 7;
  status.report->recorded_position = 0.5 * kTurn;
  EXPECT_EQ(recorded_line(to_json(status)), "axis x: recorded 180 deg");
}

}  // namespace
}  // namespace driveline::cli
