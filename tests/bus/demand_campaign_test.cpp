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
#include "demand_watch.hpp"
#include "drive_line.hpp"
#include "fault_ports.hpp"
#include "startup_objects.hpp"
#include "support/campaign.hpp"

namespace driveline::bus_test {
namespace {

using motion::AxisCommand;
using motion::AxisRequest;
using motion::BufferMode;
using motion::PlcopenState;
using motion::ProbeTrigger;
using motion::RequestPhase;
using motion::cia402::Mode;
using slaves::msd::Fault;
using slaves::msd::Input;
using slaves::msd::MachineInput;
using slaves::msd::MachineSwitch;
using slaves::msd::Variant;

constexpr std::size_t kAxes = 3;
constexpr int kCycles = 8000;  ///< one second
constexpr nanoseconds kPeriod = microseconds{125};
constexpr trajectory::AxisLimits kLimits{50.0, 1000.0};
constexpr std::size_t kCommands = static_cast<std::size_t>(AxisCommand::kDriveMoveVelocity) + 1;  // for random requests
constexpr std::size_t kAllCommands = static_cast<std::size_t>(AxisCommand::kDriveRun) + 1;
static_assert(kAllCommands == kCommands + 2, "kHaltSuperimposed and kDriveRun have times of their own");
constexpr double kMaxLoad = 0.08;  ///< Nm
constexpr double kTurn = 6.283185307179586;

/// Makes random steps, which no feed should.
class WildFeed final : public motion::SetpointFeed {
 public:
  explicit WildFeed(unsigned seed) : random_(seed) {}
  [[nodiscard]] std::size_t axis_count() const noexcept override { return at_.size(); }
  void join(std::size_t axis, const trajectory::AxisSetpoint& from) noexcept override { at_[axis] = from; }
  void leave(std::size_t) noexcept override {}
  [[nodiscard]] bool next(double period_s, std::span<trajectory::AxisSetpoint> setpoints) noexcept override {
    for (std::size_t i = 0; i < setpoints.size(); ++i) {
      if (random_() % 200 == 0) at_[i].velocity = static_cast<double>(random_() % 121) - 60.0;
      if (random_() % 500 == 0) at_[i].position += static_cast<double>(random_() % 21) - 10.0;
      at_[i].position += at_[i].velocity * period_s;
      setpoints[i] = at_[i];
    }
    return random_() % 2000 != 0;
  }

 private:
  std::mt19937 random_;
  std::array<trajectory::AxisSetpoint, 2> at_{};
};

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
  set_object(options, 0x6085, 0, increments(kLimits.max_acceleration));
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

/// Coverage of the campaign.
struct Coverage {
  std::array<std::uint64_t, kAllCommands> taken{};  ///< requests that were not refused, by command
  std::array<std::uint64_t, 11> modes{};            ///< cycles of enabled drives, by 6061h
  std::uint64_t judged = 0;
};

/// One second of motion of three axes.
class Sequence {
 public:
  Sequence(unsigned seed, Coverage& coverage)
      : random_(seed),
        halts_(seed + 2),
        runs_(seed + 3),
        feed_(seed + 1),
        scene_(make_scene(random_, feed_)),
        coverage_(coverage),
        drives_(kAxes, {}, {}, std::nullopt, scene_.options.variant, 0.0, scene_.switches),
        outwards_(drives_.line(), LossyPort::Direction::kOut,
                  [this](auto, auto) { return lost_ > 0 && lost_outwards_; }),
        port_(outwards_, LossyPort::Direction::kBack, [this](auto, auto) { return lost_ > 0; }),
        operation_(drives_, port_, scene_.options) {
    for (std::size_t i = 0; i < kAxes; ++i) {
      watches_.emplace_back(drives_.drive(i), kLimits);
      load_[i] = number(-kMaxLoad, kMaxLoad);
    }
  }

  /// The first finding; empty: there is none.
  [[nodiscard]] std::string execute() {
    if (const auto done = operation_.to_op(); !done) return sentence(done);
    for (int i = 0; i < 100; ++i) cycle();
    for (std::size_t axis = 0; axis < kAxes; ++axis) submit(axis, AxisCommand::kPower);
    for (int i = 0; i < kCycles; ++i) {
      if (chance(60)) ask();
      if (halt_at_ == now_) halt_on_top();
      if (runs_() % 300 == 0) run_by_frequency();
      harm();
      const bool missed = chance(150);
      if (missed) {
        miss(1 + static_cast<int>(pick(chance(4) ? 12 : 5)));
      } else {
        lost_ = chance(40) ? 1 + static_cast<int>(pick(chance(8) ? 12 : 4)) : std::max(lost_ - 1, 0);
        lost_outwards_ = chance(2);
        cycle();
      }
      for (std::size_t axis = 0; axis < kAxes; ++axis) {
        const auto& finding = watches_[axis].finding();
        if (!finding.empty()) return "axis " + std::to_string(axis) + ": " + finding;
      }
    }
    for (const auto& watch : watches_) coverage_.judged += watch.judged();
    return {};
  }

 private:
  [[nodiscard]] std::size_t pick(std::size_t of) { return random_() % of; }
  [[nodiscard]] bool chance(std::size_t one_in) { return pick(one_in) == 0; }
  [[nodiscard]] double number(double from, double to) { return std::uniform_real_distribution(from, to)(random_); }
  [[nodiscard]] motion::SingleAxes& axes() { return operation_.single_axes(); }

  void look() {
    for (std::size_t i = 0; i < kAxes; ++i) {
      watches_[i].look(drives_.clock.now());
      const auto& drive = drives_.drive(i);
      // Negative modes, which are not counted, become large.
      const auto mode = static_cast<unsigned char>(drive.dictionary().get(slaves::msd::kValue.mode_display));
      if (drive.power_on() && mode < coverage_.modes.size()) ++coverage_.modes[mode];
    }
  }
  void cycle() {
    operation_.cycle();
    // Advance to a fixed point in the period at which neither a control step of the drives nor a frame is due.
    const auto place = drives_.clock.now() / kPeriod * kPeriod + microseconds{110};
    drives_.leave_alone(std::max(place - drives_.clock.now(), nanoseconds{0}));
    look();
    ++now_;
    note_taken(asked_);
    note_taken(halted_);
    note_taken(ran_);
    load();
    for (std::size_t i = 0; i < kAxes; ++i) {
      if (blocked_[i] == 0 || --blocked_[i] > 0) continue;
      drives_.drive(i).set_machine_input(MachineInput::kAxisBlocked, 0.0);
    }
  }
  void miss(int periods) {
    for (int i = 0; i < periods; ++i) {
      drives_.leave_alone(kPeriod);
      look();
    }
    drives_.leave_alone(microseconds{15});
    cycle();
  }

  /// A weight that the drive takes over from a brake, and returns to it.
  void load() {
    constexpr double kStep = kMaxLoad / 400;
    for (std::size_t i = 0; i < kAxes; ++i) {
      auto& drive = drives_.drive(i);
      const bool carries = drive.motion().command() != slaves::MotionCommand::kOff;
      carried_[i] = carries ? carried_[i] + std::clamp(load_[i] - carried_[i], -kStep, kStep) : 0.0;
      drive.set_machine_input(MachineInput::kLoad, carried_[i]);
    }
  }

  /// Random faults of a drive.
  void harm() {
    static constexpr std::array kFaults{Fault::kFollowingError, Fault::kMotorTemperature, Fault::kOvercurrent,
                                        Fault::kPositiveLimitSwitch, Fault::kAmplifierTemperature};
    if (!chance(1200)) return;
    const auto axis = pick(kAxes);
    auto& drive = drives_.drive(axis);
    if (chance(3)) {
      // Blocked for some cycles; not judged until it has reached its setpoint again.
      blocked_[axis] = 1 + static_cast<int>(pick(400));
      drive.set_machine_input(MachineInput::kAxisBlocked, 1.0);
      watches_[axis].disturb(drives_.clock.now() + blocked_[axis] * kPeriod + milliseconds{400});
      return;
    }
    drive.raise(kFaults[pick(kFaults.size())]);
  }

  std::uint64_t submit(std::size_t axis, AxisCommand command) {
    AxisRequest request;
    request.command = command;
    return axes().submit(axis, request);
  }

  /// Requests that start at standstill are rare among all requests, and so are axes at standstill.
  [[nodiscard]] AxisCommand any_command(PlcopenState state) {
    static constexpr std::array kAtRest{AxisCommand::kHome, AxisCommand::kHomeByProbe, AxisCommand::kDriveMoveAbsolute,
                                        AxisCommand::kDriveMoveRelative, AxisCommand::kDriveMoveVelocity};
    if (state == PlcopenState::kStandstill && chance(2)) return kAtRest[pick(kAtRest.size())];
    return static_cast<AxisCommand>(pick(kCommands));
  }

  void ask() {
    const auto axis = pick(kAxes);
    AxisRequest request;
    request.command = any_command(axes().axis_report(axis).state);
    request.buffer = static_cast<BufferMode>(pick(6));
    request.on = !chance(4);
    request.target_si = number(-30.0, 30.0);
    if (request.command == AxisCommand::kSetOverride) request.target_si = number(-0.1, 2.1);
    // With its load, the acceleration stays within the limits.
    if (request.command == AxisCommand::kTorque) request.target_si = number(-0.15, 0.15);
    request.mode = static_cast<std::int8_t>(7 + pick(4));
    request.trigger = std::array{ProbeTrigger::kFirstRising, ProbeTrigger::kFirstFalling, ProbeTrigger::kSecondRising,
                                 ProbeTrigger::kZeroPulse}[pick(4)];
    request.distance_si = number(-8.0, 8.0);
    const bool by_drive = request.command >= AxisCommand::kDriveMoveAbsolute;
    if (chance(2)) request.velocity_si = number(0.01, 50.0);
    if (chance(3)) request.acceleration_si = number(50.0, 1000.0);
    if (!by_drive && chance(3)) request.deceleration_si = number(50.0, 1000.0);
    if (!by_drive && chance(3)) request.jerk_si = std::exp(number(8.0, 14.0));
    // A drive stops at each of its targets.
    if (by_drive && blends(request.buffer)) request.buffer = BufferMode::kBuffered;
    if (by_drive && scene_.interpolates) request.velocity_si = request.acceleration_si = 0.0;
    asked_ = {axes().submit(axis, request), now_, request.command};
    if (request.command == AxisCommand::kMoveSuperimposed) may_halt_on_top(axis);
    keep_going();
  }

  /// Halts superimposed motions sometimes, with its own random numbers, so that existing seeds keep their sequences.
  void may_halt_on_top(std::size_t axis) {
    if (halts_() % 3 != 0) return;
    halt_axis_ = axis;
    halt_at_ = now_ + 10 + static_cast<std::int64_t>(halts_() % 400);
  }
  void halt_on_top() {
    halted_ = {submit(halt_axis_, AxisCommand::kHaltSuperimposed), now_, AxisCommand::kHaltSuperimposed};
    halt_at_ = -1;
  }

  /// Uses velocity mode, also with its own random numbers, from standstill and on to another velocity.
  void run_by_frequency() {
    const auto axis = runs_() % kAxes;
    AxisRequest request;
    request.command = AxisCommand::kDriveRun;
    request.target_si = std::uniform_real_distribution(-40.0, 40.0)(runs_);
    ran_ = {axes().submit(axis, request), now_, request.command};
  }

  /// Re-enables axes, because a campaign whose axes are off has nothing to judge.
  void keep_going() {
    const auto axis = pick(kAxes);
    const auto state = axes().axis_report(axis).state;
    if (state == PlcopenState::kErrorStop) submit(axis, AxisCommand::kReset);
    if (state == PlcopenState::kDisabled) submit(axis, AxisCommand::kPower);
    if (state == PlcopenState::kStopping && chance(3)) submit(axis, AxisCommand::kReleaseStop);
  }
  struct Asked {
    std::uint64_t id = 0;
    std::int64_t cycle = 0;
    AxisCommand command{};
  };
  void note_taken(Asked& asked) {
    if (asked.id == 0 || now_ < asked.cycle + 3) return;
    const auto phase = axes().report(asked.id).phase;
    if (phase != RequestPhase::kError && phase != RequestPhase::kUnknown)
      ++coverage_.taken[static_cast<std::size_t>(asked.command)];
    asked.id = 0;
  }

  std::mt19937 random_;
  std::mt19937 halts_;
  std::mt19937 runs_;
  WildFeed feed_;
  Scene scene_;
  Coverage& coverage_;
  DriveLine drives_;
  LossyPort outwards_;
  LossyPort port_;
  LineOperation operation_;
  std::vector<DemandWatch> watches_;
  std::array<double, kAxes> load_{};     ///< Nm
  std::array<double, kAxes> carried_{};  ///< present part of it, Nm
  std::array<int, kAxes> blocked_{};
  Asked asked_{};
  Asked halted_{};
  Asked ran_{};
  std::size_t halt_axis_ = 0;
  std::int64_t halt_at_ = -1;
  std::int64_t now_ = 0;
  int lost_ = 0;
  bool lost_outwards_ = false;
};

/// Prints progress if there are many runs.
void tell_progress(unsigned done, unsigned runs) {
  constexpr unsigned kMany = 2000;
  if (runs < kMany || done % (runs / 20) != 0) return;
  std::fprintf(stderr, "%u of %u sequences\n", done, runs);
}

/// Number of sequences that cover all requests.
constexpr unsigned kCovering = 60;

TEST(DemandCampaign, DrivesDemandNoMoreThanTheirAxesMay) {
  const auto runs = test::environment("DRIVELINE_CAMPAIGN_RUNS", test::share_of(kCovering));
  const auto first = test::environment("DRIVELINE_CAMPAIGN_SEED", 1);
  constexpr int kEnough = 20;  // failures to report
  Coverage coverage;
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
  EXPECT_GT(coverage.judged, std::uint64_t{runs} * kCycles) << "the axes hardly moved: nothing was judged";
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
  Coverage coverage;
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
