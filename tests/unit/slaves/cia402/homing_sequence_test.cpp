// The homing methods as a sequence of edges and pulses, one control cycle at a time.
#include "driveline/slaves/cia402/homing_sequence.hpp"

#include <gtest/gtest.h>

namespace driveline::slaves {
namespace {

using std::chrono::microseconds;
using std::chrono::seconds;
using State = HomingSequence::State;

/// An axis whose switches the test sets step by step.
struct HomingBench {
  HomingSequence homing;
  HomingInputs inputs;

  explicit HomingBench(std::int8_t method) { homing.start(method, inputs); }
  void move(int travel, std::int64_t position, std::optional<std::int64_t> index_pulse = std::nullopt) {
    inputs.travel = travel;
    inputs.position = position;
    inputs.index_pulse = index_pulse;
    homing.step(inputs, microseconds{63}, seconds{10});
  }
};

/// CiA 402: methods 7 to 10 and 23 to 26 search in the positive direction; 11 to 14 and 27 to 30 are their mirror
/// images.
TEST(HomingSequence, EveryMethodBeginsInItsDirection) {
  struct Expected {
    int first;
    int last;
    int direction;
  };
  for (const auto& e :
       {Expected{1, 1, -1}, Expected{2, 2, 1}, Expected{3, 4, 1}, Expected{5, 6, -1}, Expected{7, 10, 1},
        Expected{11, 14, -1}, Expected{17, 17, -1}, Expected{18, 18, 1}, Expected{19, 20, 1}, Expected{21, 22, -1},
        Expected{23, 26, 1}, Expected{27, 30, -1}, Expected{33, 33, -1}, Expected{34, 34, 1}}) {
    for (int method = e.first; method <= e.last; ++method) {
      EXPECT_EQ(HomingBench(static_cast<std::int8_t>(method)).homing.demand().direction, e.direction) << method;
    }
  }
}

/// Method 1: onto the negative limit switch, off it again, and then the first index pulse.
TEST(HomingSequence, AnIndexPulseInFrontOfTheEdgeDoesNotCount) {
  HomingBench bench(1);
  bench.inputs.negative_limit = true;
  bench.move(-1, -1000);
  ASSERT_EQ(bench.homing.demand().direction, 1);
  bench.inputs.negative_limit = false;
  bench.move(1, -900);
  bench.move(1, -890, -901);
  EXPECT_EQ(bench.homing.state(), State::kSearching) << "passed before the switch was left";
  bench.move(1, -490, -500);
  EXPECT_EQ(bench.homing.state(), State::kStopping);
  EXPECT_EQ(bench.homing.home(), -500);
}

TEST(HomingSequence, AnIndexPulseThatIsPassedWhileTheAxisStillBrakesDoesNotCount) {
  HomingBench bench(34);
  bench.move(-1, -10, 5);
  EXPECT_EQ(bench.homing.state(), State::kSearching) << "it was still moving the other way";
  bench.move(1, 20, 15);
  EXPECT_EQ(bench.homing.home(), 15);
}

/// Method 17 leaves the switch at low speed; an axis that brakes on the switch may chatter across its edge.
TEST(HomingSequence, AnEdgeThatIsMetOnTheWayBackDoesNotCount) {
  HomingBench bench(17);
  bench.inputs.negative_limit = true;
  bench.move(-1, -1000);
  ASSERT_EQ(bench.homing.demand().direction, 1);
  bench.inputs.negative_limit = false;
  bench.move(-1, -1004);
  EXPECT_EQ(bench.homing.state(), State::kSearching) << "it still moves the other way";
  bench.inputs.negative_limit = true;
  bench.move(-1, -1006);
  bench.move(1, -1003);
  bench.inputs.negative_limit = false;
  bench.move(1, -999);
  EXPECT_EQ(bench.homing.state(), State::kStopping);
  EXPECT_EQ(bench.homing.home(), -999);
}

}  // namespace
}  // namespace driveline::slaves
