// Axes that turn endlessly: the positions of the drive wrap around, which must not affect the axis.
#include <gmock/gmock.h>

#include <array>
#include <cmath>
#include <cstdint>
#include <string>
#include <tuple>

#include "single_line.hpp"
#include "startup_objects.hpp"

namespace driveline::bus_test {
namespace {

using motion::cia402::Mode;

constexpr double kEndlessTurn = 6.283185307179586;
constexpr std::int32_t kEndlessRange = 1048576;

/// In CST the motion of the axis includes the response of the master's loop to friction.
AxisRequest soft(AxisRequest asked) {
  asked.acceleration_si = asked.deceleration_si = 600.0;
  return asked;
}

RunOptions endless(Mode mode, std::int32_t low, std::int32_t high) {
  auto options = single_options();
  options.mode = mode;
  options.range_min = low;
  options.range_max = high;
  set_object<std::int32_t>(options, 0x607B, 1, low);
  set_object<std::int32_t>(options, 0x607B, 2, high);
  return options;
}

/// Positions reported by the drive, and the number of their wrap-arounds.
class Rounds {
 public:
  void look(SingleLine& line) {
    const auto now = line.drives.drive(0).dictionary().get(slaves::msd::kValue.position_actual);
    if (std::abs(static_cast<double>(now) - last_) > 0.5 * static_cast<double>(kEndlessRange) && known_) ++count_;
    known_ = true;
    last_ = now;
    low_ = std::min(low_, last_);
    high_ = std::max(high_, last_);
  }
  [[nodiscard]] int count() const { return count_; }
  [[nodiscard]] double low() const { return low_; }
  [[nodiscard]] double high() const { return high_; }

 private:
  bool known_ = false;
  int count_ = 0;
  double last_ = 0.0;
  double low_ = 1e12;
  double high_ = -1e12;
};

class EndlessAxis : public testing::TestWithParam<std::tuple<Mode, double>> {};

TEST_P(EndlessAxis, TurnsOnOverThreeEndsOfItsRange) {
  const auto [mode, direction] = GetParam();
  for (const std::int32_t low : {0, -300'000}) {
    SCOPED_TRACE(low);
    Enabled<SingleLine> line(1, endless(mode, low, low + kEndlessRange - 1), {}, 0.3);
    const double from = line.setpoint();
    const double shaft = line.drives.drive(0).position_rad();
    Rounds rounds;
    line.submit(soft(request(AxisCommand::kMoveVelocity, 30.0 * direction)));
    for (int i = 0; i < 6500; ++i) {
      line.cycle();
      rounds.look(line);
      if (i > 800) {
        ASSERT_NEAR(line.axes().axis_report(0).velocity, 30.0 * direction, 1.0) << i;
        ASSERT_NEAR(line.axes().axis_report(0).position, line.setpoint(), 0.1) << i;
      }
    }
    EXPECT_GE(rounds.count(), 3);
    EXPECT_GE(rounds.low(), low);
    EXPECT_LT(rounds.high(), low + kEndlessRange);
    EXPECT_EQ(line.ask(soft(request(AxisCommand::kHalt))).phase, RequestPhase::kDone);
    line.cycles(800);
    // The distance is that of the shaft, whatever positions the drive reports.
    EXPECT_GT(std::abs(line.setpoint() - from), 3.0 * kEndlessTurn);
    EXPECT_NEAR(line.drives.drive(0).position_rad() - shaft, line.setpoint() - from, 0.05);
    line.expect_obedience();
  }
}

/// The end of the 32 bits, from both sides.
TEST_P(EndlessAxis, TurnsOnOverTheEndOfThe32Bits) {
  const auto [mode, direction] = GetParam();
  auto options = single_options();
  options.mode = mode;
  Enabled<SingleLine> line(1, options, {}, direction * (2048.0 * kEndlessTurn - 3.0));
  const double from = line.setpoint();
  EXPECT_EQ(line.ask(soft(request(AxisCommand::kMoveRelative, direction * 6.0))).phase, RequestPhase::kDone);
  EXPECT_NEAR(line.setpoint(), from + direction * 6.0, 1e-6);
  EXPECT_EQ(line.ask(soft(request(AxisCommand::kMoveRelative, -direction * 6.0))).phase, RequestPhase::kDone);
  EXPECT_EQ(line.ask(soft(request(AxisCommand::kMoveRelative, direction * 6.0))).phase, RequestPhase::kDone);
  line.cycles(400);
  EXPECT_NEAR(line.axes().axis_report(0).position, from + direction * 6.0, 0.05);
  EXPECT_NEAR(line.drives.drive(0).position_rad(), direction * (2048.0 * kEndlessTurn + 3.0), 0.05);
  line.expect_obedience();
}

INSTANTIATE_TEST_SUITE_P(InEachMode, EndlessAxis,
                         testing::Combine(testing::Values(Mode::kCyclicPosition, Mode::kCyclicVelocity,
                                                          Mode::kCyclicTorque),
                                          testing::Values(1.0, -1.0)),
                         [](const auto& row) {
                           return std::string(to_text(std::get<0>(row.param))) +
                                  (std::get<1>(row.param) > 0.0 ? "Upwards" : "Downwards");
                         });

/// A reversed axis: the ends of the range are those of the drive.
TEST(EndlessReversedAxis, TurnsOnOverThreeEndsOfItsRange) {
  for (const double direction : {1.0, -1.0}) {
    auto options = endless(Mode::kCyclicPosition, 0, kEndlessRange - 1);
    options.reversed = true;
    Enabled<SingleLine> line(1, options, {}, 0.3);
    const double from = line.setpoint();
    const double shaft = line.drives.drive(0).position_rad();
    Rounds rounds;
    line.submit(request(AxisCommand::kMoveVelocity, 30.0 * direction));
    for (int i = 0; i < 6500; ++i) {
      line.cycle();
      rounds.look(line);
    }
    EXPECT_GE(rounds.count(), 3);
    EXPECT_EQ(line.ask(request(AxisCommand::kHalt)).phase, RequestPhase::kDone);
    line.cycles(800);
    EXPECT_GT((line.setpoint() - from) * direction, 3.0 * kEndlessTurn);
    EXPECT_NEAR(line.drives.drive(0).position_rad() - shaft, from - line.setpoint(), 0.05);
    line.expect_obedience();
  }
}

}  // namespace
}  // namespace driveline::bus_test
