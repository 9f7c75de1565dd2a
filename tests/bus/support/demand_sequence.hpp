#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <random>
#include <span>
#include <string>
#include <vector>

#include "demand_watch.hpp"
#include "driveline/motion/single_axis/single_axes.hpp"

/// Random sequences of all requests, faults, lost frames and missed periods, on any bus, with a judge of what the
/// drives demand.
namespace driveline::bus_test {

using motion::AxisCommand;
using motion::AxisRequest;
using motion::BufferMode;
using motion::PlcopenState;
using motion::ProbeTrigger;
using motion::RequestPhase;
using slaves::msd::Fault;
using slaves::msd::MachineInput;
using std::chrono::milliseconds;
using std::chrono::nanoseconds;

inline constexpr std::size_t kDemandAxes = 3;
inline constexpr trajectory::AxisLimits kDemandLimits{50.0, 1000.0};
/// Commands for random requests, and all of them.
inline constexpr std::size_t kCommands = static_cast<std::size_t>(motion::AxisCommand::kDriveMoveVelocity) + 1;
inline constexpr std::size_t kAllCommands = static_cast<std::size_t>(motion::AxisCommand::kDriveRun) + 1;
static_assert(kAllCommands == kCommands + 2, "kHaltSuperimposed and kDriveRun have times of their own");
inline constexpr double kMaxLoad = 0.08;  ///< Nm

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

/// Coverage of the campaign.
struct DemandCoverage {
  std::array<std::uint64_t, kAllCommands> taken{};  ///< requests that were not refused, by command
  std::array<std::uint64_t, 11> modes{};            ///< cycles of enabled drives, by 6061h
  std::uint64_t judged = 0;
};

/// Motion of three axes of a line for a while. `Line` is the bus with its drives and its master:
///
///     Line(std::mt19937&, motion::SetpointFeed&)  of kDemandAxes axes, the first two of which can follow the feed
///     kPeriod, kCycles                            cycle time, and cycles of a sequence
///     kMargins                                    of DemandWatch
///     takes_profile_settings()                    requests to drives may name velocity and acceleration
///     start()                                     to operation; the error as a sentence
///     cycle()                                     one cycle, up to a fixed point in the period
///     stay_away(), come_late()                    a period without a cycle, and a part of one
///     lose(out, back)                             frames to the drives, and from them, from now on
///     drive(axis), axes(), now()                  DriveCore, motion::SingleAxes, time
template <typename Line>
class DemandSequence {
 public:
  DemandSequence(unsigned seed, DemandCoverage& coverage)
      : random_(seed), halts_(seed + 2), runs_(seed + 3), feed_(seed + 1), line_(random_, feed_), coverage_(coverage) {
    for (std::size_t i = 0; i < kDemandAxes; ++i) {
      watches_.emplace_back(line_.drive(i), kDemandLimits, Line::kMargins);
      load_[i] = number(-kMaxLoad, kMaxLoad);
    }
  }

  /// The first finding; empty: there is none.
  [[nodiscard]] std::string execute() {
    if (auto failure = line_.start(); !failure.empty()) return failure;
    for (int i = 0; i < 100; ++i) cycle();
    for (std::size_t axis = 0; axis < kDemandAxes; ++axis) submit(axis, AxisCommand::kPower);
    for (int i = 0; i < Line::kCycles; ++i) {
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
      for (std::size_t axis = 0; axis < kDemandAxes; ++axis) {
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
  [[nodiscard]] motion::SingleAxes& axes() { return line_.axes(); }

  void look() {
    for (std::size_t i = 0; i < kDemandAxes; ++i) {
      watches_[i].look(line_.now());
      const auto& drive = line_.drive(i);
      // Negative modes, which are not counted, become large.
      const auto mode = static_cast<unsigned char>(drive.dictionary().get(slaves::msd::kValue.mode_display));
      if (drive.power_on() && mode < coverage_.modes.size()) ++coverage_.modes[mode];
    }
  }
  void cycle() {
    line_.lose(lost_ > 0 && lost_outwards_, lost_ > 0);
    line_.cycle();
    look();
    ++now_;
    note_taken(asked_);
    note_taken(halted_);
    note_taken(ran_);
    load();
    for (std::size_t i = 0; i < kDemandAxes; ++i) {
      if (blocked_[i] == 0 || --blocked_[i] > 0) continue;
      line_.drive(i).set_machine_input(MachineInput::kAxisBlocked, 0.0);
    }
  }
  void miss(int periods) {
    for (int i = 0; i < periods; ++i) {
      line_.stay_away();
      look();
    }
    line_.come_late();
    cycle();
  }

  /// A weight that the drive takes over from a brake, and returns to it.
  void load() {
    constexpr double kStep = kMaxLoad / 400;
    for (std::size_t i = 0; i < kDemandAxes; ++i) {
      auto& drive = line_.drive(i);
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
    const auto axis = pick(kDemandAxes);
    auto& drive = line_.drive(axis);
    if (chance(3)) {
      // Blocked for some cycles; not judged until it has reached its setpoint again.
      blocked_[axis] = 1 + static_cast<int>(pick(400));
      drive.set_machine_input(MachineInput::kAxisBlocked, 1.0);
      watches_[axis].disturb(line_.now() + blocked_[axis] * Line::kPeriod + milliseconds{400});
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
    const auto axis = pick(kDemandAxes);
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
    if (by_drive && !line_.takes_profile_settings()) request.velocity_si = request.acceleration_si = 0.0;
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
    const auto axis = runs_() % kDemandAxes;
    AxisRequest request;
    request.command = AxisCommand::kDriveRun;
    request.target_si = std::uniform_real_distribution(-40.0, 40.0)(runs_);
    ran_ = {axes().submit(axis, request), now_, request.command};
  }

  /// Re-enables axes, because a campaign whose axes are off has nothing to judge.
  void keep_going() {
    const auto axis = pick(kDemandAxes);
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
  Line line_;
  DemandCoverage& coverage_;
  std::vector<DemandWatch> watches_;
  std::array<double, kDemandAxes> load_{};     ///< Nm
  std::array<double, kDemandAxes> carried_{};  ///< present part of it, Nm
  std::array<int, kDemandAxes> blocked_{};
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
inline void tell_progress(unsigned done, unsigned runs) {
  constexpr unsigned kMany = 2000;
  if (runs < kMany || done % (runs / 20) != 0) return;
  std::fprintf(stderr, "%u of %u sequences\n", done, runs);
}

}  // namespace driveline::bus_test
