// The example lines set a limit for machines that are away for some milliseconds now and then, such as virtual
// machines. Their axes bridge an absence within it, and stop after a longer one.
#include <gtest/gtest.h>

#include <cstdint>
#include <memory>
#include <string>

#include "drive_line.hpp"

namespace driveline::bus_test {
namespace {

using motion::AxisCommand;
using motion::AxisError;
using motion::AxisRequest;
using motion::PlcopenState;
using motion::RequestPhase;
using std::chrono::seconds;

/// One drive with the cycle and the limit of an example; its axis turns.
class ExampleLine : public testing::TestWithParam<const char*> {
 protected:
  void SetUp() override {
    const auto config = runtime::load_line_config(std::string("examples/") + GetParam() + ".toml");
    ASSERT_TRUE(config) << describe(config.error());
    RunOptions options;
    options.single_axes = true;
    options.period = config->period;
    options.max_lost_cycles = config->max_lost_cycles;
    operation = std::make_unique<LineOperation>(drives, options);
    ASSERT_EQ(sentence(operation->to_op()), "");
    AxisRequest power;
    power.command = AxisCommand::kPower;
    submit(power);
    operation->run(seconds{1});
    ASSERT_EQ(report().state, PlcopenState::kStandstill);
    AxisRequest turn;
    turn.command = AxisCommand::kMoveVelocity;
    turn.target_si = 4.5;
    turning = submit(turn);
    operation->run(seconds{1});
    ASSERT_EQ(phase(), RequestPhase::kReached);
  }
  std::uint64_t submit(const AxisRequest& request) { return operation->single_axes().submit(0, request); }
  [[nodiscard]] motion::AxisReport report() const { return operation->single_axes().axis_report(0); }
  [[nodiscard]] RequestPhase phase() const { return operation->single_axes().report(turning).phase; }

  DriveLine drives{1};
  std::unique_ptr<LineOperation> operation;
  std::uint64_t turning = 0;
};

TEST_P(ExampleLine, SurvivesThatTheMasterIsAwayFor23Ms) {
  drives.leave_alone(milliseconds{23});
  operation->run(seconds{1});
  EXPECT_GE(operation->statistics().longest_absence, milliseconds{22});
  EXPECT_EQ(report().state, PlcopenState::kContinuousMotion);
  EXPECT_EQ(phase(), RequestPhase::kReached);
}

TEST_P(ExampleLine, StopsAfterTheMasterWasAwayFor60Ms) {
  drives.leave_alone(milliseconds{60});
  operation->run(seconds{1});
  EXPECT_EQ(report().state, PlcopenState::kErrorStop);
  EXPECT_EQ(report().error, AxisError::kMasterAway);
}

INSTANTIATE_TEST_SUITE_P(Of, ExampleLine, testing::Values("by_hand", "delta", "flying_saw", "gantry", "plotter"));

}  // namespace
}  // namespace driveline::bus_test
