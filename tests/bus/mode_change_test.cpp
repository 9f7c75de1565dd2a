// Changes of the cyclic mode while the axes move, judged by the demands of the drives.
#include <gmock/gmock.h>

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <random>
#include <span>
#include <string>

#include "drive_line.hpp"
#include "late_line.hpp"
#include "support/campaign.hpp"

namespace driveline::bus_test {
namespace {

using motion::Axis;
using motion::MotionFailure;
using motion::cia402::Mode;

/// Keeps the old mode in the process data for some cycles, like a slow drive.
class SlowMode final : public motion::CycleTask {
 public:
  void update(const motion::TaskCycle& cycle) noexcept override {
    const auto wanted = cycle.outputs[kModeOffset];
    waited_ = wanted == shown_ ? 0 : waited_ + 1;
    if (waited_ > slowness) shown_ = wanted;
    cycle.outputs[kModeOffset] = shown_;
  }
  std::uint32_t slowness = 0;

 private:
  static constexpr std::size_t kModeOffset = 2;
  std::byte shown_{8};
  std::uint32_t waited_ = 0;
};

RunOptions offsets_added(RunOptions options, bool added) {
  options.adds_offsets = added;
  if (!added) return options;
  // P 379: feed-forward from the bus, of velocity and torque.
  for (const auto part : {std::uint8_t{1}, std::uint8_t{2}})
    options.startup.push_back({0x217B, part, {std::byte{1}, std::byte{0}}});
  return options;
}

class ModeLine : public LateLine {
 public:
  explicit ModeLine(const RunOptions& options = fast_path()) : LateLine(options) {}

  [[nodiscard]] Axis& axis() {
    // NOLINTNEXTLINE(cppcoreguidelines-pro-type-const-cast): requests to an axis are not the motion's
    return const_cast<Axis&>(operation.motion().axes()[0]);
  }
  void load(double torque_nm) { drives.drive(0).set_machine_input(slaves::msd::MachineInput::kLoad, torque_nm); }
  /// Changes the mode; returns the cycles until the drive shows it, at most `most`.
  int change(Mode mode, int most = 100) {
    EXPECT_TRUE(axis().set_mode(mode));
    EXPECT_EQ(axis().mode(), mode);
    int cycles_taken = 0;
    while (!axis().mode_ready() && cycles_taken < most) {
      cycle();
      ++cycles_taken;
    }
    EXPECT_TRUE(axis().mode_ready());
    EXPECT_EQ(operation.motion().failure().cause, MotionFailure::Cause::kNone);
    return cycles_taken;
  }
};

/// The feed-forward: of the inertia only; the same with a drive that adds offsets in every mode; also of friction and a
/// weight.
enum class Feed : std::uint8_t { kInertia, kAdded, kLoad };

struct Change {
  Mode from;
  Mode to;
  Feed feed = Feed::kInertia;
};

class EveryChange : public testing::TestWithParam<Change> {};

TEST_P(EveryChange, LeavesTheDemandWithinTheLimits) {
  const auto& [from, to, feed] = GetParam();
  for (const double load_nm : {0.0, 0.3, -0.3}) {
    SCOPED_TRACE(load_nm);
    // At standstill, at speed, at the peak, in between.
    for (const int place : {10, 150, 700, 1100, 1350, 1600, 1800, 2200, 2500, 2700}) {
      SCOPED_TRACE(place);
      auto options = offsets_added(ModeLine::fast_path(), feed == Feed::kAdded);
      options.mode = from;
      if (feed == Feed::kLoad) {
        options.feed_forward = {.viscous_friction = 2e-4, .coulomb_friction = 0.03, .gravity = 0.3};
      }
      // Up to 39 rad/s and 620 rad/s^2: the return to the path takes a tenth of the limits.
      options.amplitude_rad = 5.0;
      ModeLine line(options);
      line.load(load_nm);
      line.cycles(3200 + place);
      for (auto& judge : line.judges) judge.forget();
      line.cycles(20);
      // The drive is told to change when the axis follows its last setpoint: at a reversal that takes some cycles.
      EXPECT_LE(line.change(to), 60);
      line.cycles(2500);
      line.expect_obedience();
    }
  }
}

std::string name_of(const testing::TestParamInfo<Change>& row) {
  return std::string(to_text(row.param.from)) + "To" + std::string(to_text(row.param.to)) +
         (row.param.feed == Feed::kAdded  ? "WithOffsets"
          : row.param.feed == Feed::kLoad ? "WithLoad"
                                          : "");
}

INSTANTIATE_TEST_SUITE_P(Changes, EveryChange,
                         testing::Values(Change{Mode::kCyclicPosition, Mode::kCyclicVelocity},
                                         Change{Mode::kCyclicVelocity, Mode::kCyclicPosition},
                                         Change{Mode::kCyclicPosition, Mode::kCyclicTorque},
                                         Change{Mode::kCyclicTorque, Mode::kCyclicPosition},
                                         Change{Mode::kCyclicVelocity, Mode::kCyclicTorque},
                                         Change{Mode::kCyclicTorque, Mode::kCyclicVelocity},
                                         Change{Mode::kCyclicPosition, Mode::kCyclicVelocity, Feed::kAdded},
                                         Change{Mode::kCyclicVelocity, Mode::kCyclicPosition, Feed::kAdded},
                                         Change{Mode::kCyclicPosition, Mode::kCyclicTorque, Feed::kAdded},
                                         Change{Mode::kCyclicTorque, Mode::kCyclicPosition, Feed::kAdded},
                                         Change{Mode::kCyclicVelocity, Mode::kCyclicTorque, Feed::kAdded},
                                         Change{Mode::kCyclicTorque, Mode::kCyclicVelocity, Feed::kAdded},
                                         Change{Mode::kCyclicPosition, Mode::kCyclicVelocity, Feed::kLoad},
                                         Change{Mode::kCyclicVelocity, Mode::kCyclicPosition, Feed::kLoad},
                                         Change{Mode::kCyclicPosition, Mode::kCyclicTorque, Feed::kLoad},
                                         Change{Mode::kCyclicTorque, Mode::kCyclicPosition, Feed::kLoad},
                                         Change{Mode::kCyclicVelocity, Mode::kCyclicTorque, Feed::kLoad},
                                         Change{Mode::kCyclicTorque, Mode::kCyclicVelocity, Feed::kLoad}),
                         name_of);

TEST(ModeChange, OfASlowDriveIsWithinTheLimitsMeanwhile) {
  for (const auto to : {Mode::kCyclicVelocity, Mode::kCyclicTorque}) {
    for (const std::uint32_t slowness : {3U, 80U, 1500U}) {
      SCOPED_TRACE(slowness);
      SlowMode slow;
      slow.slowness = slowness;
      auto options = ModeLine::fast_path();
      options.task = &slow;
      options.task_order = motion::TaskTiming::Order::kAfterMotion;
      ModeLine line(options);
      line.load(0.2);
      line.cycles(3400);
      EXPECT_GE(line.change(to, 2000), static_cast<int>(slowness));
      line.cycles(1000);
      EXPECT_GE(line.change(Mode::kCyclicPosition, 2000), static_cast<int>(slowness));
      line.cycles(2000);
      line.expect_obedience();
    }
  }
}

/// The caller decides when it takes too long, and withdraws the request.
TEST(ModeChange, ThatTheDriveNeverMakesCanBeTakenBack) {
  SlowMode slow;
  slow.slowness = 1'000'000;
  auto options = ModeLine::fast_path();
  options.task = &slow;
  options.task_order = motion::TaskTiming::Order::kAfterMotion;
  ModeLine line(options);
  line.cycles(3400);
  EXPECT_TRUE(line.axis().set_mode(Mode::kCyclicTorque));
  line.cycles(4000);
  EXPECT_FALSE(line.axis().mode_ready());
  EXPECT_TRUE(line.axis().enabled());
  EXPECT_TRUE(line.axis().set_mode(Mode::kCyclicPosition));
  line.cycles(3000);
  EXPECT_TRUE(line.axis().mode_ready());
  EXPECT_EQ(line.operation.motion().failure().cause, MotionFailure::Cause::kNone);
  line.expect_obedience();
}

/// A drive may change in any cycle after it has received the command.
TEST(ModeChange, TakenBackInTheCycleInWhichTheDriveMakesItIsWithinTheLimits) {
  constexpr std::array kModes{Mode::kCyclicPosition, Mode::kCyclicVelocity, Mode::kCyclicTorque};
  for (const auto from : kModes) {
    for (const auto to : kModes) {
      if (from == to) continue;
      const int told = from == Mode::kCyclicTorque ? 32 : 8;
      for (int moment = told - 2; moment < told + 12; ++moment) {
        SCOPED_TRACE(testing::Message() << to_text(from) << " to " << to_text(to) << ", " << moment << " cycles");
        auto options = ModeLine::fast_path();
        options.mode = from;
        options.amplitude_rad = 5.0;
        ModeLine line(options);
        line.load(0.2);
        line.cycles(3700);
        for (auto& judge : line.judges) judge.forget();
        line.cycles(20);
        EXPECT_TRUE(line.axis().set_mode(to));
        line.cycles(moment);
        line.change(from);
        line.cycles(400);
        line.expect_obedience();
      }
    }
  }
}

/// The drive would start with a predicted position, and then get another one.
TEST(ModeChange, WithAMasterThatIsAwayWhenItIsToldIsWithinTheLimits) {
  constexpr int kTold = 8;
  for (int moment = kTold - 3; moment < kTold + 4; ++moment) {
    SCOPED_TRACE(testing::Message() << moment << " cycles");
    auto options = ModeLine::fast_path();
    options.mode = Mode::kCyclicVelocity;
    options.amplitude_rad = 5.0;
    ModeLine line(options);
    line.load(0.2);
    line.cycles(3700);
    for (auto& judge : line.judges) judge.forget();
    line.cycles(20);
    EXPECT_TRUE(line.axis().set_mode(Mode::kCyclicPosition));
    line.cycles(moment);
    line.stall(7);
    line.change(Mode::kCyclicPosition, 400);
    line.cycles(400);
    line.expect_obedience();
  }
}

/// During a gap a drive continues in CST with its last torque, in CSV with its velocity, in CSP with its positions.
TEST(ModeChange, WithPeriodsMissedAtAnyMomentIsWithinTheLimits) {
  constexpr std::array kModes{Mode::kCyclicPosition, Mode::kCyclicVelocity, Mode::kCyclicTorque};
  for (const auto from : kModes) {
    for (const auto to : kModes) {
      const int told = from == Mode::kCyclicTorque ? 32 : 8;
      for (const double load_nm : {0.2, -0.2}) {
        for (const int periods : {4, 7}) {
          for (int moment = told - 8; moment < told + 12; moment += 3) {
            // Where the axis brakes hard at speed, and where it is about to reverse.
            for (const int place : {3700, 4500}) {
              SCOPED_TRACE(testing::Message() << to_text(from) << " to " << to_text(to) << ", " << load_nm << " Nm, "
                                              << periods << " periods, " << moment << " cycles, at " << place);
              auto options = ModeLine::fast_path();
              options.mode = from;
              options.amplitude_rad = 5.0;
              ModeLine line(options);
              line.load(load_nm);
              line.cycles(place);
              for (auto& judge : line.judges) judge.forget();
              line.cycles(20);
              EXPECT_TRUE(line.axis().set_mode(to));
              line.cycles(moment);
              line.stall(periods);
              line.change(to, 400);
              line.cycles(400);
              line.expect_obedience();
            }
          }
        }
      }
    }
  }
}

/// Until the change is known to be complete, the drive gets predicted positions, advanced by the motion meanwhile.
TEST(ModeChange, GoesOnThroughPeriodsMissedByADriveThatHasJustGotIntoCsp) {
  auto options = ModeLine::fast_path();
  options.mode = Mode::kCyclicVelocity;
  options.amplitude_rad = 5.0;
  ModeLine line(options);
  line.cycles(3700);
  EXPECT_TRUE(line.axis().set_mode(Mode::kCyclicPosition));
  const auto& drive = line.drives.drive(0);
  const auto& values = drive.dictionary();
  const auto in_csp = static_cast<std::int8_t>(Mode::kCyclicPosition);
  for (int i = 0; i < 100 && values.get(slaves::msd::kValue.mode_display) != in_csp; ++i) line.cycle();
  line.cycles(3);
  EXPECT_FALSE(line.axis().mode_ready()) << "it is still on its way";
  const auto lead = [&] {
    const auto told = values.get(slaves::msd::kValue.target_position);
    return (told - values.get(slaves::msd::kValue.position_demand)) / kDemandIncrements;
  };
  const double before = lead();
  const double step = drive.velocity_rad_s() * 125e-6;
  EXPECT_GT(std::abs(step), 2e-3) << "it moves";
  line.stall(6);
  line.cycle();
  EXPECT_NEAR(lead(), before, std::abs(step));
}

/// Runs cycles in which the master is sometimes away, or frames are lost, never for longer than can be bridged.
class Unsteady {
 public:
  Unsteady(ModeLine& line, std::mt19937& random) : line_(line), random_(random) {}

  void cycle() {
    if (random_() % kOneIn == 0) return disturb();
    line_.cycle();
  }
  void cycles(int count) {
    for (int i = 0; i < count; ++i) cycle();
  }

 private:
  static constexpr unsigned kOneIn = 100;
  static constexpr unsigned kMaxBridgedPeriods = 7;  ///< periods that can be bridged
  static constexpr int kBetween = 2;                 ///< cycles until the next gap, so that two gaps are not one

  /// Loses frames, then misses periods: a single gap for the drives.
  void disturb() {
    const int periods = 1 + static_cast<int>(random_() % kMaxBridgedPeriods);
    const int frames = random_() % 3 == 0 ? static_cast<int>(random_() % static_cast<unsigned>(periods + 1)) : 0;
    if (frames > 0) line_.lose(frames, random_() % 2 == 0);
    if (periods > frames) line_.stall(periods - frames);
    line_.cycles(kBetween);
  }

  ModeLine& line_;
  std::mt19937& random_;
};

/// Random changes at any time, also before the previous one has completed, under an unknown load, while periods are
/// missed and frames are lost.
void random_changes(unsigned seed) {
  constexpr std::array kModes{Mode::kCyclicPosition, Mode::kCyclicVelocity, Mode::kCyclicTorque};
  std::mt19937 random(seed);
  const auto pick = [&random](unsigned of) { return static_cast<int>(random() % of); };
  auto options = offsets_added(ModeLine::fast_path(), pick(4) == 0);
  options.mode = kModes[random() % kModes.size()];
  options.amplitude_rad = 5.0;
  ModeLine line(options);
  Unsteady unsteady(line, random);
  line.load(std::uniform_real_distribution(-0.3, 0.3)(random));
  line.cycles(3200);
  for (auto& judge : line.judges) judge.forget();
  line.cycles(20);
  for (int change = 0; change < 12; ++change) {
    unsteady.cycles(pick(pick(2) == 0 ? 30 : 2000));
    EXPECT_TRUE(line.axis().set_mode(kModes[random() % kModes.size()]));
    if (pick(4) == 0) continue;
    for (int i = 0; i < 800 && !line.axis().mode_ready(); ++i) unsteady.cycle();
    EXPECT_TRUE(line.axis().mode_ready());
  }
  unsteady.cycles(2500);
  EXPECT_EQ(line.operation.motion().failure().cause, MotionFailure::Cause::kNone);
  line.expect_obedience();
}

TEST(ModeChangeCampaign, InAnyOrderAtAnyTimeLeavesTheDemandWithinTheLimits) {
  const auto runs = test::environment("DRIVELINE_CAMPAIGN_RUNS", test::share_of(20U));
  const auto first = test::environment("DRIVELINE_CAMPAIGN_SEED", 1);
  for (unsigned seed = first; seed < first + runs; ++seed) {
    random_changes(seed);
    ASSERT_FALSE(testing::Test::HasFailure()) << "seed " << seed;
  }
}

/// Seeds of former violations. Frames lost when a drive in CST was to be told to change, so that it did not get the
/// command (127, 318, 445, 690); a gap while the axis returned to its setpoints, on top of their own return to the path
/// (785); periods missed, also after a lost frame (1171), when a drive that had entered CSV held its velocity while its
/// setpoints were still in flight (885); answers lost while a drive that was still led by positions entered CST (119),
/// and periods missed before, with the torque of a step (3524); periods missed by a drive that had just entered CSP
/// (9911, 11232), or that may have entered CSV without an answer (3642, 4234, 10164, 10898), or in the first cycle of a
/// change from CST (5758), or by a drive that had not got the command from CSV to CSP (13302, 14031); gaps just before
/// and after a change.
TEST(ModeChangeCampaign, WhatWasOnceBeyondTheLimitsIsNotAnyMore) {
  constexpr std::array kSeeds{67U,   119U,  127U,  142U,  220U,  318U,  445U,   560U,   574U,   690U,   691U,
                              713U,  752U,  785U,  873U,  882U,  885U,  893U,   906U,   964U,   1171U,  3524U,
                              3642U, 4234U, 5687U, 5758U, 9013U, 9911U, 10164U, 10898U, 11232U, 13302U, 14031U};
  for (const auto seed : std::span(kSeeds).first(test::share_of(kSeeds.size()))) {
    random_changes(seed);
    ASSERT_FALSE(testing::Test::HasFailure()) << "seed " << seed;
  }
}

TEST(ModeChange, IsRefusedWithoutTheObjects) {
  RunOptions options;
  options.pdos = motion::PdoConfiguration{{{0x1600, {{0x6040, 0, 16}, {0x6060, 0, 8}, {0x607A, 0, 32}}}},
                                          {{0x1A00, {{0x6041, 0, 16}, {0x6061, 0, 8}, {0x6064, 0, 32}}}}};
  ModeLine line(options);
  EXPECT_FALSE(line.axis().set_mode(Mode::kCyclicVelocity));
  EXPECT_FALSE(line.axis().set_mode(Mode::kInterpolatedPosition));
  EXPECT_TRUE(line.axis().set_mode(Mode::kCyclicPosition));
  EXPECT_EQ(line.axis().mode(), Mode::kCyclicPosition);
  EXPECT_TRUE(line.axis().mode_ready());
}

}  // namespace
}  // namespace driveline::bus_test
