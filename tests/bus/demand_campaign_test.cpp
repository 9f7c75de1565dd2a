// Random sequences of all requests, faults, lost frames and missed periods: the demands of simulated drives obey the
// limits of their axes in any case, also while a coasting axis is switched on and while its mode changes. Commands to
// drives are judged in tests/unit, without drives.
//
// Judged are (margins and their reasons: see DemandWatch): 6062h while the drive follows positions, 606Bh while it has
// power, and in torque mode, without a velocity demand, the velocity of the shaft. Not judged is what is no demand: a
// motor without power, a stop at full torque, and 606Bh of a blocked axis.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <limits>
#include <memory>
#include <random>
#include <span>
#include <string>
#include <vector>

#include "demand_judge.hpp"
#include "demand_sequence.hpp"
#include "drive_line.hpp"
#include "fault_ports.hpp"
#include "startup_objects.hpp"
#include "support/campaign.hpp"

namespace driveline::bus_test {
namespace {

using motion::cia402::Mode;
using slaves::msd::Input;
using slaves::msd::MachineSwitch;
using slaves::msd::Variant;

constexpr double kTurn = 6.283185307179586;

/// The configuration of the line of a sequence.
struct Scene {
  RunOptions options;
  std::vector<MachineSwitch> switches;
  bool interpolates = false;  ///< 60C1h is mapped, instead of 6081h and 6083h
};

/// All objects that the requests need, in PDOs of at most 8 bytes each.
motion::PdoConfiguration pdos(bool interpolates) {
  motion::PdoConfiguration made{{{0x1600, {{0x6040, 0, 16}, {0x6060, 0, 8}, {0x607A, 0, 32}}},
                                 {0x1601, {{0x60FF, 0, 32}, {0x60B1, 0, 32}}},
                                 {0x1602, {{0x6071, 0, 16}, {0x60B2, 0, 16}, {0x60B8, 0, 16}, {0x6042, 0, 16}}}},
                                {{0x1A00, {{0x6041, 0, 16}, {0x6061, 0, 8}, {0x6064, 0, 32}}},
                                 {0x1A01, {{0x606C, 0, 32}, {0x60BA, 0, 32}}},
                                 {0x1A02, {{0x6077, 0, 16}, {0x603F, 0, 16}, {0x60B9, 0, 16}}},
                                 {0x1A03, {{0x60BB, 0, 32}, {0x60BC, 0, 32}}}}};
  if (interpolates) {
    made.outputs.push_back({0x1603, {{0x60C1, 1, 32}}});
  } else {
    made.outputs.push_back({0x1603, {{0x6081, 0, 32}, {0x6083, 0, 32}}});
  }
  return made;
}

/// Reactions of a drive on its own are set no harder than the limits of its axis; its slow down ramp is its own.
Scene make_scene(std::mt19937& random, motion::SetpointFeed& feed) {
  static constexpr std::array kMethods{24, 33, 34, 35, 37};
  static constexpr std::array kModes{Mode::kCyclicPosition, Mode::kCyclicPosition, Mode::kCyclicVelocity,
                                     Mode::kCyclicTorque};
  const auto increments = [](double value) { return static_cast<std::uint32_t>(value * kDemandIncrements); };
  Scene scene;
  auto& options = scene.options;
  options.single_axes = true;
  options.samples = false;
  options.feed = &feed;
  options.variant = random() % 4 == 0 ? Variant::kServoOne : Variant::kMsd;
  scene.interpolates = random() % 3 == 0;
  options.pdos = pdos(scene.interpolates);
  options.mode = kModes[random() % kModes.size()];
  set_object(options, 0x6081, 0, increments(20.0));
  set_object(options, 0x6083, 0, increments(700.0));
  set_object(options, 0x6084, 0, increments(800.0));
  set_object(options, 0x6085, 0, increments(kDemandLimits.max_acceleration));
  count_in_rpm(options);
  set_object(options, 0x6098, 0, static_cast<std::int8_t>(kMethods[random() % kMethods.size()]));
  set_object(options, 0x6099, 1, increments(4.0 * kTurn));
  set_object(options, 0x6099, 2, increments(1.0 * kTurn));
  set_object(options, 0x609A, 0, increments(900.0));
  set_object<std::uint16_t>(options, 0x2067, 0, 10);  // ISD02: reference switch
  set_object<std::uint16_t>(options, 0x206A, 0, 15);  // ISD05 and ISD06: touch probes
  set_object<std::uint16_t>(options, 0x206B, 0, 15);
  constexpr double kEndless = std::numeric_limits<double>::infinity();
  scene.switches = {{Input::kIsd05, 2.0, 3.5}, {Input::kIsd06, 2.6, kEndless}, {Input::kIsd02, 1.0, 2.0}};
  return scene;
}

/// Three drives on EtherCAT.
class EtherCatDemandLine {
 public:
  static constexpr nanoseconds kPeriod = microseconds{125};
  static constexpr int kCycles = 8000;  ///< one second
  static constexpr DemandWatch::Margins kMargins{};

  EtherCatDemandLine(std::mt19937& random, motion::SetpointFeed& feed)
      : scene_(make_scene(random, feed)),
        drives_(kDemandAxes, {}, {}, std::nullopt, scene_.options.variant, 0.0, scene_.switches),
        outwards_(drives_.line(), LossyPort::Direction::kOut, [this](auto, auto) { return lose_out_; }),
        port_(outwards_, LossyPort::Direction::kBack, [this](auto, auto) { return lose_back_; }),
        operation_(drives_, port_, scene_.options) {}

  [[nodiscard]] std::string start() { return sentence(operation_.to_op()); }
  void cycle() {
    operation_.cycle();
    // Advance to a fixed point in the period at which neither a control step of the drives nor a frame is due.
    const auto place = now() / kPeriod * kPeriod + microseconds{110};
    drives_.leave_alone(std::max(place - now(), nanoseconds{0}));
  }
  void stay_away() { drives_.leave_alone(kPeriod); }
  void come_late() { drives_.leave_alone(microseconds{15}); }
  void lose(bool out, bool back) {
    lose_out_ = out;
    lose_back_ = back;
  }
  [[nodiscard]] bool takes_profile_settings() const { return !scene_.interpolates; }
  [[nodiscard]] slaves::msd::DriveCore& drive(std::size_t axis) { return drives_.drive(axis); }
  [[nodiscard]] motion::SingleAxes& axes() { return operation_.single_axes(); }
  [[nodiscard]] nanoseconds now() { return drives_.clock.now(); }

 private:
  Scene scene_;
  DriveLine drives_;
  bool lose_out_ = false;
  bool lose_back_ = false;
  LossyPort outwards_;
  LossyPort port_;
  LineOperation operation_;
};
using Sequence = DemandSequence<EtherCatDemandLine>;

/// Number of sequences that cover all requests.
constexpr unsigned kCovering = 60;

TEST(DemandCampaign, DrivesDemandNoMoreThanTheirAxesMay) {
  const auto runs = test::environment("DRIVELINE_CAMPAIGN_RUNS", test::share_of(kCovering));
  const auto first = test::environment("DRIVELINE_CAMPAIGN_SEED", 1);
  constexpr int kEnough = 20;  // failures to report
  DemandCoverage coverage;
  int failed = 0;
  for (unsigned seed = first; seed < first + runs && failed < kEnough; ++seed) {
    Sequence sequence(seed, coverage);
    const auto finding = sequence.execute();
    EXPECT_EQ(finding, "") << "seed " << seed;
    if (!finding.empty()) ++failed;
    tell_progress(seed - first + 1, runs);
  }
  if (runs < kCovering || failed > 0) return;
  for (std::size_t i = 0; i < kAllCommands; ++i)
    EXPECT_GT(coverage.taken[i], 0U) << to_text(static_cast<AxisCommand>(i)) << ": always refused";
  for (const auto mode : {1U, 2U, 3U, 6U, 7U, 8U, 9U, 10U}) EXPECT_GT(coverage.modes[mode], 0U) << "mode " << mode;
  EXPECT_GT(coverage.judged, std::uint64_t{runs} * EtherCatDemandLine::kCycles)
      << "the axes hardly moved: nothing was judged";
}

/// Seeds of former violations. Frames lost while an axis returned to its setpoints after a change of mode; a master
/// away when a drive was to be told to change; drives that had extrapolated missing setpoints; periods missed and
/// frames lost just when a coasting axis was switched on (3367 to 16028, the last one in interpolated position mode;
/// 17918); a frame lost while an axis braked in CSV (30041).
/// A motion superimposed on a velocity that was raised (10607 to 12231), also during a change of mode (16721), and
/// after a gap (13163); periods missed in the first cycle of a change from CST (13489), and twice where a torque ended
/// (103961); a change of mode while an axis braked to be switched off (102035). A frame lost while the sum of two
/// motions required more acceleration than available (7595).
/// Frames lost in the first cycles of an axis that was switched on while it coasted, after missed periods (42441), and
/// a torque that ended long after a fault had cut off a change of mode out of CSP (83452). Periods missed when a
/// coasting axis was switched on in CSV, and in the following cycles (3000182). A torque that ended in a cycle whose
/// frame was lost, followed by missed periods (3004887). An axis that had coasted and stood still just when it was
/// switched on, after missed periods (4081424, 5075995). A motion requested when a drive had just entered velocity
/// mode, under a load (4191686).
TEST(DemandCampaign, WhatWasOnceBeyondTheLimitsIsNotAnyMore) {
  DemandCoverage coverage;
  constexpr std::array kSeeds{1731U,   2452U,  3224U,  3433U,    6446U,    1732U,    3367U,    4663U,
                              10491U,  10845U, 13372U, 14484U,   16028U,   30041U,   17918U,   7595U,
                              10607U,  10889U, 11368U, 12231U,   16721U,   13163U,   13489U,   102035U,
                              103961U, 42441U, 83452U, 3000182U, 3004887U, 4081424U, 4191686U, 5075995U};
  for (const auto seed : std::span(kSeeds).first(test::share_of(kSeeds.size()))) {
    Sequence sequence(seed, coverage);
    EXPECT_EQ(sequence.execute(), "") << "seed " << seed;
  }
}

}  // namespace
}  // namespace driveline::bus_test
