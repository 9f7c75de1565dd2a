// Motions of many axes that wait for the end of others: number of plans per cycle, and the demands of the drives
// meanwhile.
#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

#include "single_line.hpp"

namespace driveline::bus_test {
namespace {

using testing::Each;
using testing::Ge;
using testing::Le;

constexpr std::size_t kMany = 64;
constexpr std::uint64_t kPlansInACycle = 4;

/// Enabled axes, and the number of their plans in each cycle.
class ManyAxes {
 public:
  explicit ManyAxes(std::size_t count) : line(count) {
    std::vector<std::uint64_t> asked;
    for (std::size_t i = 0; i < count; ++i) asked.push_back(line.submit(power(true), i));
    for (const auto id : asked) EXPECT_EQ(line.finish(id).phase, RequestPhase::kDone);
    for (std::size_t i = 0; i < count; ++i) from.push_back(line.setpoint(i));
  }

  /// Commands all axes in the same cycle: by `way` from their first positions.
  std::vector<std::uint64_t> ask_all(double way, double velocity, BufferMode buffer = BufferMode::kAborting) {
    std::vector<std::uint64_t> asked;
    for (std::size_t i = 0; i < from.size(); ++i)
      asked.push_back(line.axes().submit_in_cycle(i, move(from[i] + way, velocity, buffer)));
    return asked;
  }
  [[nodiscard]] std::uint64_t planned() {
    std::uint64_t sum = 0;
    for (std::size_t i = 0; i < from.size(); ++i) sum += line.axes().axis(i).planned();
    return sum;
  }
  [[nodiscard]] std::size_t in_phase(const std::vector<std::uint64_t>& asked, RequestPhase phase) {
    return static_cast<std::size_t>(
        std::count_if(asked.begin(), asked.end(), [&](std::uint64_t id) { return line.phase(id) == phase; }));
  }
  /// Runs until all are done; returns the number of plans in each cycle.
  std::vector<std::uint64_t> finish(const std::vector<std::uint64_t>& asked) {
    std::vector<std::uint64_t> plans;
    for (int i = 0; i < 8000 && in_phase(asked, RequestPhase::kDone) < asked.size(); ++i) {
      const auto before = planned();
      line.cycle();
      plans.push_back(planned() - before);
    }
    EXPECT_EQ(in_phase(asked, RequestPhase::kDone), asked.size());
    return plans;
  }

  SingleLine line;
  std::vector<double> from;
};

TEST(WaitingMotions, ThatBeginTogetherArePlannedFourInACycle) {
  ManyAxes many(kMany);
  many.ask_all(0.5, 10.0);
  const auto back = many.ask_all(0.0, 20.0, BufferMode::kBuffered);
  const auto plans = many.finish(back);
  EXPECT_THAT(plans, Each(Le(kPlansInACycle)));
  EXPECT_GE(std::count(plans.begin(), plans.end(), kPlansInACycle),
            static_cast<std::ptrdiff_t>(kMany / kPlansInACycle));
  for (std::size_t i = 0; i < kMany; ++i) EXPECT_NEAR(many.line.setpoint(i), many.from[i], 1e-12);
  many.line.expect_obedience();
}

TEST(WaitingMotions, ThatAreBlendedPassTheEndTogetherAndArePlannedFourInACycle) {
  ManyAxes many(kMany);
  const auto first = many.ask_all(1.0, 20.0);
  const auto second = many.ask_all(2.0, 20.0, BufferMode::kBlendingPrevious);
  const auto third = many.ask_all(3.0, 20.0, BufferMode::kBlendingPrevious);
  std::size_t together = 0;
  std::vector<double> slowest(kMany, 20.0);
  std::vector<double> before = many.from;
  many.line.each_period = [&] {
    together = std::max(
        together, std::min(many.in_phase(first, RequestPhase::kDone), many.in_phase(second, RequestPhase::kActive)));
    for (std::size_t i = 0; i < kMany; ++i) {
      const double now = many.line.setpoint(i);
      const double way = now - many.from[i];
      if (way > 0.9 && way < 2.1) slowest[i] = std::min(slowest[i], (now - before[i]) / 125e-6);
      before[i] = now;
    }
  };
  EXPECT_THAT(many.finish(third), Each(Le(kPlansInACycle)));
  EXPECT_EQ(together, kMany);
  EXPECT_THAT(slowest, Each(Ge(19.9))) << "both ends are passed";
  for (std::size_t i = 0; i < kMany; ++i) EXPECT_NEAR(many.line.setpoint(i), many.from[i] + 3.0, 1e-12);
  many.line.expect_obedience();
}

TEST(WaitingMotions, RequestsAndAStopFindRoomBesideThem) {
  ManyAxes many(kMany);
  const auto first = many.ask_all(0.5, 10.0);
  many.ask_all(0.0, 20.0, BufferMode::kBuffered);
  many.finish(first);
  const auto last = kMany - 1;
  std::vector<std::uint64_t> asked;
  for (const double factor : {0.9, 1.0, 0.9, 1.0})
    asked.push_back(many.line.submit(request(AxisCommand::kSetOverride, factor), last));
  const auto stop = many.line.submit(request(AxisCommand::kStop), last);
  many.line.cycle();
  EXPECT_EQ(many.line.state(last), PlcopenState::kStopping) << "others have waited for longer";
  EXPECT_EQ(many.in_phase(asked, RequestPhase::kDone), 2U) << "half of the plans are theirs";
  EXPECT_EQ(many.line.finish(stop).phase, RequestPhase::kDone);
  many.line.expect_obedience();
}

TEST(WaitingMotions, AMotionThatIsAskedForMeanwhileWaitsBehindThem) {
  ManyAxes many(kMany);
  const auto first = many.ask_all(0.5, 10.0);
  const auto second = many.ask_all(0.0, 20.0, BufferMode::kBuffered);
  many.finish(first);
  const auto last = kMany - 1;
  EXPECT_EQ(many.line.phase(second[last]), RequestPhase::kWaiting);
  const auto third = many.line.submit(move(many.from[last] + 0.25, 10.0, BufferMode::kBuffered), last);
  EXPECT_EQ(many.line.finish(second[last]).phase, RequestPhase::kDone);
  EXPECT_NEAR(many.line.setpoint(last), many.from[last], 1e-3);
  EXPECT_EQ(many.line.finish(third).phase, RequestPhase::kDone);
  EXPECT_NEAR(many.line.setpoint(last), many.from[last] + 0.25, 1e-12);
  many.line.expect_obedience();
}

/// The plan for the end of the present motion is no longer valid.
TEST(WaitingMotions, ABlendedOneGoesWhereItsPositionIsCalledNow) {
  Enabled<SingleLine> line;
  const double from = line.setpoint();
  line.submit(move(from + 2.0, 20.0));
  const auto second = line.submit(move(from + 4.0, 20.0, BufferMode::kBlendingPrevious));
  line.cycles(400);
  line.submit(request(AxisCommand::kSetPosition, line.setpoint() + 1.0));
  EXPECT_EQ(line.finish(second).phase, RequestPhase::kDone);
  EXPECT_NEAR(line.setpoint(), from + 4.0, 1e-12);
  EXPECT_NEAR(line.axes().axis_report(0).position_offset, 1.0, 0.05);
  line.expect_obedience();
}

TEST(WaitingMotions, ABlendedOneObeysAnOverrideThatComesBeforeIt) {
  Enabled<SingleLine> line;
  const double from = line.setpoint();
  line.submit(move(from + 2.0, 20.0));
  const auto second = line.submit(move(from + 4.0, 20.0, BufferMode::kBlendingPrevious));
  line.cycles(400);
  line.submit(request(AxisCommand::kSetOverride, 0.5));
  double fastest = 0.0;
  double before = line.setpoint();
  for (int cycle = 0; cycle < 8000 && !line.axes().report(second).over(); ++cycle) {
    line.cycle();
    const double now = line.setpoint();
    if (now > from + 2.0) fastest = std::max(fastest, (now - before) / 125e-6);
    before = now;
  }
  EXPECT_NEAR(fastest, 10.0, 0.01);
  line.expect_obedience();
}

/// The end is passed while no frame reaches the drive, or the master is away.
TEST(WaitingMotions, ABlendedOneGoesOnBehindAGap) {
  for (const bool lost : {true, false}) {
    Enabled<SingleLine> line;
    const double from = line.setpoint();
    const auto first = line.submit(move(from + 2.0, 20.0));
    const auto second = line.submit(move(from + 4.0, 20.0, BufferMode::kBlendingPrevious));
    for (int i = 0; i < 8000 && line.setpoint() < from + 1.995; ++i) line.cycle();
    if (lost) {
      lose_outputs(line, 4);
    } else {
      line.stall(4);
    }
    EXPECT_EQ(line.finish(first).phase, RequestPhase::kDone);
    EXPECT_EQ(line.finish(second).phase, RequestPhase::kDone);
    EXPECT_NEAR(line.setpoint(), from + 4.0, 1e-12);
    line.expect_obedience();
  }
}

}  // namespace
}  // namespace driveline::bus_test
