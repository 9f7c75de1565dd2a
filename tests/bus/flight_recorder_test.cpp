#include <gmock/gmock.h>

#include <cmath>
#include <map>
#include <sstream>

#include "drive_line.hpp"

namespace driveline::bus_test {
namespace {

using motion::FlightRecorder;
using motion::MotionPhase;

/// A CSV file as columns of numbers by name.
std::map<std::string, std::vector<double>> columns_of(const std::string& csv) {
  std::istringstream in(csv);
  std::string line;
  std::vector<std::string> names;
  std::map<std::string, std::vector<double>> columns;
  while (std::getline(in, line)) {
    std::istringstream cells(line);
    std::string cell;
    for (std::size_t i = 0; std::getline(cells, cell, ','); ++i) {
      if (columns.size() < i + 1 && names.size() == i) names.push_back(cell);
      if (cell == names[i]) {
        columns[cell];
      } else {
        columns[names[i]].push_back(
            std::stod(cell.starts_with("0x") ? std::to_string(std::stoul(cell, nullptr, 16)) : cell));
      }
    }
  }
  return columns;
}

class Recording : public testing::Test {
 protected:
  void start() {
    operation = std::make_unique<LineOperation>(drives, RunOptions{.repeat = true, .recorder = &recorder});
    ASSERT_EQ(sentence(operation->to_motion()), "");
    ASSERT_TRUE(operation->run_until(MotionPhase::kFollowing, std::chrono::seconds{2}));
    operation->run(milliseconds{400});
  }
  std::map<std::string, std::vector<double>> columns() {
    std::ostringstream out;
    recorder.write_csv(out, labels);
    return columns_of(out.str());
  }

  DriveLine drives{3};
  FlightRecorder recorder{3};
  std::vector<FlightRecorder::AxisLabel> labels{{"x"}, {"y"}, {"z"}};
  std::unique_ptr<LineOperation> operation;
};

TEST_F(Recording, WritesPositionsInTheUnitsOfTheAxes) {
  start();
  const auto si = columns();
  const auto& degrees = *trajectory::find_position_unit("deg");
  const double increments_per_rad = operation->motion().axes()[1].config().increments_per_unit;
  labels[1] = {"y", &degrees, increments_per_rad};
  const auto data = columns();
  EXPECT_FALSE(data.contains("y.actual_position"));
  EXPECT_FALSE(data.contains("x.actual_position[increments]"));
  EXPECT_EQ(data.at("x.actual_position"), si.at("x.actual_position"));
  for (const auto& [figure, per] : {std::pair{"target_position", ""}, std::pair{"actual_position", ""},
                                    std::pair{"actual_velocity", "/s"}, std::pair{"following_error", ""}}) {
    const auto& rad = si.at(std::string("y.") + figure);
    const auto& shown = data.at(std::string("y.") + figure + "[deg" + per + "]");
    ASSERT_EQ(shown.size(), rad.size());
    for (std::size_t i = 0; i < rad.size(); ++i)
      ASSERT_NEAR(shown[i], degrees.from_si(rad[i]), 1e-5 * (1.0 + std::abs(shown[i]))) << figure;
  }
  EXPECT_NEAR(data.at("y.actual_position[increments]").back(), si.at("y.actual_position").back() * increments_per_rad,
              1.0);
}

TEST_F(Recording, KeepsWhatLedToAFaultAndWhatFollowed) {
  start();
  EXPECT_FALSE(recorder.frozen());
  drives.drive(1).set_dc_link(false);
  operation->run(milliseconds{100});
  ASSERT_TRUE(recorder.frozen());
  const auto data = columns();
  ASSERT_EQ(data.at("cycle").size(), FlightRecorder::kCycles);
  for (std::size_t i = 1; i < FlightRecorder::kCycles; ++i) {
    ASSERT_EQ(data.at("cycle")[i], data.at("cycle")[i - 1] + 1) << "not one cycle is missing";
    ASSERT_EQ(data.at("time_ns")[i], data.at("time_ns")[i - 1] + 125'000);
  }
  // Status word before and after the fault (CiA 402: bit 3 fault, mask 0x4F).
  const auto& status = data.at("y.status_word");
  const auto state = [&](std::size_t row) { return static_cast<unsigned>(status[row]) & 0x4FU; };
  EXPECT_EQ(state(0), 0x07U) << "operation enabled";
  EXPECT_TRUE(state(FlightRecorder::kCycles - 1) == 0x08U || state(FlightRecorder::kCycles - 1) == 0x0FU);
  std::size_t fault = 0;
  while ((state(fault) & 0x08U) == 0) ++fault;
  EXPECT_NEAR(static_cast<double>(FlightRecorder::kCycles - fault), static_cast<double>(FlightRecorder::kCyclesAfter),
              2.0);
  // The other axes get the stop command a cycle later, and their targets are those of the drives.
  EXPECT_EQ(data.at("x.control_word")[fault - 2], 0x0F);
  EXPECT_EQ(data.at("x.control_word")[fault + 2], 0x02) << "quick stop";
  EXPECT_NEAR(data.at("x.target_position")[fault - 1], data.at("x.actual_position")[fault - 1], 0.05);
  EXPECT_EQ(data.at("working_counter")[0], 9);
  EXPECT_EQ(data.count("dc_difference_ns"), 0U) << "no clock is locked on this line";
}

TEST_F(Recording, StopsAfterALossOfCommunication) {
  start();
  drives.line().drop_frames(1'000'000);
  operation->run(milliseconds{100});
  ASSERT_TRUE(recorder.frozen());
  const auto data = columns();
  const auto& received = data.at("frames_received");
  EXPECT_EQ(received.front(), 1);
  EXPECT_EQ(received.back(), 0);
}

TEST_F(Recording, RecordsAgainOnceItIsRearmed) {
  start();
  drives.drive(1).set_dc_link(false);
  operation->run(milliseconds{300});
  ASSERT_TRUE(recorder.frozen());
  const auto first = columns().at("cycle").back();
  recorder.rearm();
  EXPECT_EQ(recorder.size(), 0U);
  drives.drive(1).set_dc_link(true);
  operation->motion().request_start();
  operation->run(milliseconds{50});
  EXPECT_FALSE(recorder.frozen());
  EXPECT_EQ(recorder.size(), 400U);
  EXPECT_GT(columns().at("cycle").front(), first);
}

}  // namespace
}  // namespace driveline::bus_test
