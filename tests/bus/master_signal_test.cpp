// Encoders and actual positions as masters, compared with the positions of the simulated shafts at the same instant.
#include "driveline/motion/single_axis/master_signal.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <limits>
#include <memory>
#include <random>
#include <vector>

#include "driveline/motion/single_axis/couplings.hpp"
#include "single_line.hpp"

namespace driveline::bus_test {
namespace {

using motion::Couplings;
using motion::MasterSignal;
using trajectory::CatchUp;
using trajectory::CouplingLaw;
using trajectory::CouplingState;

constexpr double kPeriod = 125e-6;
constexpr double kIncrement = 1.0 / kDemandIncrements;
/// Offset of 6064h in the inputs of a drive.
constexpr std::size_t kPositionOffset = 3;

trajectory::TrackerSettings tracker_settings() {
  trajectory::TrackerSettings settings;
  settings.period_s = kPeriod;
  settings.noise = kIncrement;
  settings.max_velocity = 60.0;
  return settings;
}

/// The position of drive 1 is the encoder that drive 0 follows. The motor of drive 1 moves by requests to its axis.
class EncoderLine : public SingleLine {
 public:
  explicit EncoderLine(bool by_axis = false) : SingleLine(2) {
    const trajectory::FollowLimits bounds{{60.0, std::numeric_limits<double>::infinity()}};
    if (by_axis) {
      signal = std::make_unique<MasterSignal>(axes().axis(1), 1, tracker_settings(), bounds);
    } else {
      MasterSignal::Encoder encoder;
      const auto place = operation.master().image().places()[1].input_offset + kPositionOffset;
      encoder.entry = motion::PdoBits(8 * place, 32);
      encoder.slave = 1;
      encoder.increments_per_unit = kDemandIncrements;
      signal = std::make_unique<MasterSignal>(encoder, tracker_settings(), bounds);
    }
    Couplings::Pair pair;
    pair.slave = 0;
    pair.master = by_axis ? 1 : Couplings::Pair::kNoAxis;
    pair.signal = signal.get();
    couplings = std::make_unique<Couplings>(axes(), std::vector{pair}, kSinglePeriod);
    enable(0);
    enable(1);
    cycles(4000);
  }

  void couple(const trajectory::GearRatio& ratio = {}) {
    law = CouplingLaw::gear(ratio, signal->at(0.0).position, setpoint(0));
    ASSERT_NE(couplings->engage(0, law, CatchUp::kPosition), 0U);
    for (int i = 0; i < 4000 && coupled() != CouplingState::kInSync; ++i) cycle();
    ASSERT_EQ(coupled(), CouplingState::kInSync);
  }
  [[nodiscard]] CouplingState coupled() const { return couplings->report(0).state; }
  void run_master(double velocity, double acceleration = 200.0) {
    auto asked = request(AxisCommand::kMoveVelocity, velocity);
    asked.acceleration_si = acceleration;
    asked.jerk_si = 4000.0;
    ASSERT_NE(submit(asked, 1), 0U);
  }
  /// Difference between the positions that both drives have reported in the same frame.
  [[nodiscard]] double apart() {
    return std::abs(axes().axis_report(0).position - law.at(axes().axis_report(1).position).position);
  }
  [[nodiscard]] double worst_apart(int cycles) {
    double worst = 0.0;
    for (int i = 0; i < cycles; ++i) {
      cycle();
      worst = std::max(worst, apart());
    }
    return worst;
  }

  std::unique_ptr<MasterSignal> signal;
  std::unique_ptr<Couplings> couplings;
  CouplingLaw law;
};

// Without prediction the slave would be three cycles and two filters late: 20 rad/s * 0.375 ms are 7.5 mrad.
TEST(MasterSignal, ASlaveIsWhereItsEncoderIsAtTheSameInstant) {
  EncoderLine line;
  line.couple();
  for (const double velocity : {20.0, -35.0, 3.0}) {
    line.run_master(velocity);
    line.cycles(4000);
    EXPECT_LT(line.worst_apart(2000), 3e-4) << velocity;
  }
  EXPECT_EQ(line.coupled(), CouplingState::kInSync);
  EXPECT_EQ(line.couplings->report(0).losses, 0U);
  line.expect_obedience();
}

TEST(MasterSignal, AChangeOfItsVelocityIsFollowedWithoutMuchDelay) {
  EncoderLine line;
  line.couple(trajectory::GearRatio::make(1, 2).value());
  line.run_master(30.0);
  EXPECT_LT(line.worst_apart(4000), 5e-3);
  line.run_master(-30.0);
  EXPECT_LT(line.worst_apart(6000), 5e-3);
  line.expect_obedience();
}

TEST(MasterSignal, AStandstillDoesNotCreep) {
  EncoderLine line;
  line.run_master(10.0);
  line.cycles(2000);
  line.couple();
  ASSERT_EQ(line.ask(request(AxisCommand::kHalt), 1).phase, RequestPhase::kDone);
  line.cycles(16000);
  const double stands = line.setpoint(0);
  for (int i = 0; i < 16000; ++i) {
    line.cycle();
    ASSERT_EQ(line.setpoint(0), stands) << i;
  }
  EXPECT_LT(line.apart(), 4.0 * kIncrement);
  line.expect_obedience();
}

TEST(MasterSignal, LostFramesAndMissedPeriodsMakeNoLeap) {
  std::mt19937_64 random(20240611);
  const auto any = [&random](int low, int high) { return std::uniform_int_distribution<int>(low, high)(random); };
  EncoderLine line;
  line.couple();
  line.run_master(25.0);
  line.cycles(3000);
  for (int round = 0; round < 60; ++round) {
    switch (any(0, 2)) {
      case 0:
        lose_inputs(line, any(1, 7));
        break;
      case 1:
        lose_outputs(line, any(1, 7));
        break;
      default:
        line.stall(any(1, 7));
        break;
    }
    line.cycles(any(1, 300));
    ASSERT_EQ(line.state(0), PlcopenState::kSynchronizedMotion) << round;
  }
  line.cycles(2000);
  EXPECT_EQ(line.coupled(), CouplingState::kInSync);
  EXPECT_LT(line.worst_apart(1000), 3e-4);
  line.expect_obedience();
}

TEST(MasterSignal, AnEncoderThatIsNotSeenAnyMoreBringsTheSlaveToRest) {
  EncoderLine line;
  line.couple();
  line.run_master(25.0);
  line.cycles(3000);
  line.drives.line().set_power(1, false);
  line.cycles(4000);
  EXPECT_FALSE(line.signal->leads());
  EXPECT_NE(line.state(0), PlcopenState::kSynchronizedMotion);
  EXPECT_EQ(line.coupled(), CouplingState::kIdle);
  line.judges[0].expect_obedience();
}

TEST(MasterSignal, TheActualPositionOfAnAxisLeadsAlsoWithoutPower) {
  EncoderLine line(true);
  line.couple();
  line.run_master(20.0);
  line.cycles(4000);
  EXPECT_LT(line.worst_apart(1000), 3e-4);
  ASSERT_EQ(line.ask(power(false), 1).phase, RequestPhase::kDone);
  line.cycles(2000);
  EXPECT_EQ(line.state(1), PlcopenState::kDisabled);
  EXPECT_EQ(line.state(0), PlcopenState::kSynchronizedMotion);
  EXPECT_LT(line.apart(), 6.0 * kIncrement);
  line.expect_obedience();
}

TEST(MasterSignal, ARelativePhaseCountsFromTheOneThatThereIs) {
  EncoderLine line;
  line.couple();
  const auto limits = trajectory::ProfileLimits::symmetric(5.0, 100.0, 5000.0);
  const auto first = line.couplings->shift_phase_by(0, 0.25, limits);
  line.cycles(3000);
  EXPECT_EQ(line.couplings->report(0).phase_number, first);
  EXPECT_NEAR(line.couplings->report(0).phase, 0.25, 1e-12);
  ASSERT_GT(line.couplings->shift_phase_by(0, -0.05, limits), first);
  line.cycles(3000);
  EXPECT_NEAR(line.couplings->report(0).phase, 0.2, 1e-12);
  EXPECT_TRUE(line.couplings->report(0).phase_reached);
  EXPECT_EQ(line.couplings->shift_phase_by(1, 0.1, limits), 0U) << "it is no slave";
  line.expect_obedience();
}

// The position where the entry wraps around means nothing to the axis.
TEST(MasterSignal, GoesOnWhereTheEntryBeginsAnew) {
  MasterSignal::Encoder encoder;
  encoder.entry = motion::PdoBits(0, 12);
  encoder.range = 3600;
  encoder.increments_per_unit = -100.0;
  auto settings = tracker_settings();
  settings.noise = 0.0;
  MasterSignal signal(encoder, settings, {});
  std::array<std::byte, 2> image{};
  const std::array<bool, 1> valid{true};
  for (int i = 0; i < 20000; ++i) {
    const int counted = (2000 + i / 2) % 3600;
    encoder.entry.set(image, static_cast<std::uint32_t>(counted));
    signal.read_inputs(image, valid, {});
  }
  EXPECT_NEAR(signal.at(0.0).position, -0.01 * (2000.0 - 3600.0 + 19999 / 2.0), 0.02);
  EXPECT_EQ(signal.leaps(), 0U);
}

}  // namespace
}  // namespace driveline::bus_test
