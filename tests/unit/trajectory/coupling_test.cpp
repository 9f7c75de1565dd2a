#include "driveline/trajectory/coupling.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <sstream>
#include <string>
#include <vector>

#include "driveline/rt_guard/rt_guard.hpp"
#include "driveline/trajectory/position_profile.hpp"
#include "driveline/trajectory/velocity_profile.hpp"
#include "support.hpp"

namespace driveline::trajectory {
namespace {

constexpr double kPeriod = 125e-6;
constexpr FollowLimits kSlave{{10.0, 100.0}, 4000.0};
constexpr FollowLimits kCalm{{6.0, 40.0}, 1500.0};
constexpr double kTurn = 2.0 * std::numbers::pi;

ProfileLimits profile_limits(const FollowLimits& limits) {
  return ProfileLimits::symmetric(limits.motion.max_velocity, limits.motion.max_acceleration, limits.max_jerk);
}

/// A master that goes from one random velocity to the next within its limits, and holds each for a while.
class RandomMaster {
 public:
  RandomMaster(test::Random& random, const FollowLimits& limits) : random_(&random), limits_(profile_limits(limits)) {
    aim();
  }

  AxisSetpoint step() {
    if (rest_ > 0) {
      --rest_;
      now_ = {now_.position + now_.velocity * kPeriod, now_.velocity, 0.0};
      if (rest_ == 0 && !steady_) aim();
      return now_;
    }
    elapsed_s_ += kPeriod;
    now_ = profile_.evaluate(elapsed_s_);
    if (profile_.finished(elapsed_s_)) rest_ = 1 + static_cast<int>(random_->index(0, 800));
    return now_;
  }
  /// From its next standstill on it keeps its velocity.
  void keep_velocity() { steady_ = true; }
  [[nodiscard]] const AxisSetpoint& now() const { return now_; }

 private:
  void aim() {
    const double most = limits_.max_velocity;
    profile_ = plan_to_velocity(now_, random_->real(-most, most), 0.0, limits_).value();
    elapsed_s_ = 0.0;
  }

  test::Random* random_;
  ProfileLimits limits_;
  AxisSetpoint now_{};
  Profile profile_{};
  double elapsed_s_ = 0.0;
  int rest_ = 0;
  bool steady_ = false;
};

/// Differentiates the setpoints of a drive, and compares them with limits. Independent of couplings.
class Judge {
 public:
  explicit Judge(const FollowLimits& limits) : limits_(limits) {}

  /// `with_jerk`: the jerk of the last three steps is judged, too.
  void look(double position, bool with_jerk = true) {
    std::rotate(places_.begin(), places_.begin() + 1, places_.end());
    places_.back() = position;
    ++seen_;
    const auto& p = places_;
    const double rounding = 4e-15 * (1.0 + std::abs(position));
    compare("velocity", 2, p[3] - p[2], kPeriod, limits_.motion.max_velocity, rounding);
    compare("acceleration", 3, p[3] - 2.0 * p[2] + p[1], kPeriod * kPeriod, limits_.motion.max_acceleration, rounding);
    if (with_jerk)
      compare("jerk", 4, p[3] - 3.0 * (p[2] - p[1]) - p[0], kPeriod * kPeriod * kPeriod, limits_.max_jerk, rounding);
  }
  /// The first violation; empty: none.
  [[nodiscard]] const std::string& complaint() const { return complaint_; }

 private:
  void compare(const char* what, int needed, double difference, double unit, double limit, double rounding) {
    if (seen_ < needed || !complaint_.empty()) return;
    if (std::abs(difference) <= limit * unit * (1.0 + 1e-6) + rounding) return;
    std::ostringstream text;
    text << what << " " << difference / unit << " at step " << seen_ << ", " << limit << " is allowed";
    complaint_ = text.str();
  }

  FollowLimits limits_;
  std::array<double, 4> places_{};
  int seen_ = 0;
  std::string complaint_;
};

/// A moving slave inside its limits.
AxisSetpoint random_slave(test::Random& random) {
  const auto profile =
      plan_to_position({random.real(-3.0, 3.0), 0.0, 0.0}, {random.real(-3.0, 3.0), 0.0, 0.0}, profile_limits(kSlave));
  return profile->evaluate(random.real(0.0, profile->duration_s()));
}

Coupling coupling_of(const FollowLimits& limits, const FollowLimits& bounds = kCalm) {
  Coupling coupling(limits, kPeriod);
  coupling.set_master_bounds(bounds);
  return coupling;
}

CouplingLaw gear(std::int64_t numerator, std::int64_t denominator, double slave = 0.0) {
  return CouplingLaw::gear(GearRatio::make(numerator, denominator).value(), 0.0, slave);
}

AxisSetpoint cruise(double position, double velocity, int step) {
  return {position + velocity * kPeriod * step, velocity, 0.0};
}

// The whole campaign: any state of the slave, any motion of the master within its bounds, caught up at any time.
std::string random_campaign(const FollowLimits& limits, int rounds, bool known_bounds) {
  test::Random random;
  for (int round = 0; round < rounds; ++round) {
    RandomMaster master(random, kCalm);
    const auto numerator = static_cast<std::int64_t>(random.index(1, 5)) * (round % 3 == 0 ? -1 : 1);
    const auto law = gear(numerator, 5, random.real(-2.0, 2.0));
    for (auto wait = random.index(0, 3000); wait > 0; --wait) (void)master.step();
    const auto slave = random_slave(random);
    auto coupling = coupling_of(limits, known_bounds ? kCalm : FollowLimits{});
    const auto how = round % 4 == 0 ? CatchUp::kVelocity : CatchUp::kPosition;
    if (coupling.engage(law, how, slave, master.now()) != CouplingRefusal::kNone) return "refused";
    Judge judge(kSlave);
    judge.look(slave.position);
    int step = 0;
    for (; step < 40000 && !coupling.in_sync(); ++step) {
      if (step == 20000) master.keep_velocity();
      judge.look(coupling.step(master.step()).position);
    }
    for (int more = 0; more < 4000; ++more) judge.look(coupling.step(master.step()).position);
    std::ostringstream where;
    where << " in round " << round;
    if (!judge.complaint().empty()) return judge.complaint() + where.str();
    if (!coupling.in_sync() || coupling.losses() != 0) return "not in synchronism" + where.str();
  }
  return "";
}

TEST(CouplingLimits, HoldWhateverTheMasterDoesWhileItIsCaughtUpWith) {
  EXPECT_EQ(random_campaign(kSlave, 60, true), "");
}

TEST(CouplingLimits, HoldWithoutKnowingWhatTheMasterMayDo) {
  EXPECT_EQ(random_campaign(kSlave, 60, false), "");
}

// The oracle must detect each of the three limits if it is one percent too large.
TEST(CouplingLimits, AnExcessOfOnePercentIsCaught) {
  EXPECT_EQ(random_campaign({{10.1, 100.0}, 4000.0}, 60, true).substr(0, 8), "velocity");
  EXPECT_EQ(random_campaign({{10.0, 101.0}, 4000.0}, 60, true).substr(0, 12), "acceleration");
  EXPECT_EQ(random_campaign({{10.0, 100.0}, 4040.0}, 60, true).substr(0, 4), "jerk");
}

// Steps of the master's velocity, of any size: velocity and acceleration of the slave are limited in every step, and it
// is back in synchronism when the master is calm.
TEST(CouplingLimits, VelocityAndAccelerationHoldForAMasterThatLeaps) {
  test::Random random;
  for (int round = 0; round < 40; ++round) {
    DRIVELINE_TRACE_SEED(random, round);
    auto coupling = coupling_of(kSlave, {});
    AxisSetpoint master{};
    const auto slave = random_slave(random);
    ASSERT_EQ(coupling.engage(gear(1, 1), CatchUp::kPosition, slave, master), CouplingRefusal::kNone);
    Judge judge(kSlave);
    judge.look(slave.position, false);
    for (int leap = 0; leap < 12; ++leap) {
      master.velocity = leap == 11 ? random.real(-5.0, 5.0) : random.real(-20.0, 20.0);
      if (random.index(0, 3) == 0) master.position += random.real(-1.0, 1.0);
      const auto steps = leap == 11 ? 200000 : static_cast<int>(random.index(1, 2000));
      for (int i = 0; i < steps && !(leap == 11 && coupling.in_sync()); ++i) {
        master.position += master.velocity * kPeriod;
        judge.look(coupling.step(master).position, false);
      }
    }
    ASSERT_EQ(judge.complaint(), "");
    ASSERT_TRUE(coupling.in_sync());
  }
}

TEST(Coupling, InSynchronismTheSlaveIsWhereTheLawHasItToTheLastBit) {
  test::Random random;
  RandomMaster master(random, kCalm);
  auto coupling = coupling_of(kSlave);
  const auto law = gear(3, 7, 1.0);
  ASSERT_EQ(coupling.engage(law, CatchUp::kPosition, {}, master.now()), CouplingRefusal::kNone);
  EXPECT_EQ(coupling.state(), CouplingState::kCatchingUp);
  int in_sync = 0;
  for (int i = 0; i < 80000; ++i) {
    const auto now = master.step();
    const auto slave = coupling.step(now);
    if (!coupling.in_sync()) continue;
    ++in_sync;
    ASSERT_EQ(slave.position, law.at(now.position).position);
    ASSERT_EQ(slave.velocity, now.velocity * (3.0 / 7.0));
  }
  EXPECT_GT(in_sync, 60000);
  EXPECT_EQ(coupling.losses(), 0U);
}

// A master with a counter, at the last of 10^9 increments.
TEST(Coupling, AGearIsExactAfterAThousandMillionIncrements) {
  constexpr double kIncrement = kTurn / 1048576.0;
  auto coupling = coupling_of(kSlave);
  const auto ratio = GearRatio::make(355, 113).value();
  const auto master_at = [](std::int64_t count) {
    return AxisSetpoint{static_cast<double>(count) * kIncrement, 40.0 * kIncrement / kPeriod, 0.0};
  };
  constexpr std::int64_t kEnd = 1'000'000'000;
  const std::int64_t begin = kEnd - 40 * 40000;
  const auto law = CouplingLaw::gear(ratio, 0.0, 0.0);
  AxisSetpoint slave = along(law.at(master_at(begin).position), master_at(begin));
  ASSERT_EQ(coupling.engage(law, CatchUp::kPosition, slave, master_at(begin)), CouplingRefusal::kNone);
  for (std::int64_t count = begin + 40; count <= kEnd; count += 40) slave = coupling.step(master_at(count));
  ASSERT_TRUE(coupling.in_sync());
  const auto [whole, remainder] = ratio.travel(kEnd);
  const double exact = static_cast<double>(whole) + static_cast<double>(remainder) / 113.0;
  EXPECT_NEAR(slave.position / kIncrement, exact, 1e-5);
}

// MC_GearIn: only the velocities are matched, and the positions at that moment stay related.
TEST(Coupling, CatchesUpWithTheVelocityAloneWhenAsked) {
  auto coupling = coupling_of(kSlave);
  ASSERT_EQ(coupling.engage(gear(1, 2), CatchUp::kVelocity, {5.0, 0.0, 0.0}, cruise(0.0, 4.0, 0)),
            CouplingRefusal::kNone);
  double fastest = 0.0;
  int steps = 0;
  while (!coupling.in_sync() && steps < 10000)
    fastest = std::max(fastest, coupling.step(cruise(0.0, 4.0, ++steps)).velocity);
  EXPECT_LE(fastest, 2.0 * (1.0 + 1e-12));
  const double apart = coupling.setpoint().position - 0.5 * 4.0 * kPeriod * steps;
  for (int i = 0; i < 1000; ++i) (void)coupling.step(cruise(0.0, 4.0, ++steps));
  EXPECT_NEAR(coupling.setpoint().position - 0.5 * 4.0 * kPeriod * steps, apart, 1e-12);
  EXPECT_LT(apart, 5.0);
}

TEST(Coupling, ComesIntoSynchronismAtAPlaceWhateverTheMasterDoesOnTheWay) {
  for (const double velocity : {0.5, 2.0, 4.0}) {
    auto coupling = coupling_of(kSlave);
    const auto law = gear(1, 1, -3.0);  // at 0.5 when the master is at 3.5
    ASSERT_EQ(coupling.engage_at(law, {3.5, 0.0}, {}, cruise(0.0, velocity, 0)), CouplingRefusal::kNone);
    Judge judge(kSlave);
    judge.look(0.0);
    AxisSetpoint master = cruise(0.0, velocity, 0);
    double waited_until = 0.0;
    double in_sync_from = 0.0;
    while (master.position < 4.0) {
      // Half as fast in the middle of the run-in, with a smooth change.
      const double part = std::clamp((master.position - 2.8) / 0.4, 0.0, 1.0);
      const double slow = 1.0 - 0.5 * part * part * (3.0 - 2.0 * part);
      const double slope = part > 0.0 && part < 1.0 ? -0.5 * 6.0 * part * (1.0 - part) / 0.4 : 0.0;
      master = {master.position + velocity * slow * kPeriod, velocity * slow, velocity * slow * velocity * slope};
      judge.look(coupling.step(master).position);
      if (coupling.state() == CouplingState::kWaiting) waited_until = master.position;
      if (coupling.in_sync() && in_sync_from <= 0.0) in_sync_from = master.position;
    }
    EXPECT_EQ(judge.complaint(), "") << velocity;
    EXPECT_NEAR(waited_until, 2.5, 2.0 * velocity * kPeriod);
    EXPECT_NEAR(in_sync_from, 3.5, 2.0 * velocity * kPeriod);
    EXPECT_EQ(coupling.setpoint().position, law.at(master.position).position);
  }
}

TEST(Coupling, APlaceThatCannotBeIsRefusedWithItsReason) {
  auto coupling = coupling_of(kSlave);
  const auto law = gear(1, 1);
  const auto moving = cruise(2.0, 4.0, 0);
  EXPECT_EQ(coupling.engage_at(law, {2.2, 1.0}, {}, moving), CouplingRefusal::kTooLate);
  EXPECT_EQ(coupling.engage_at(law, {2.5, 0.0}, {}, moving), CouplingRefusal::kTooLate);
  EXPECT_EQ(coupling.engage_at(law, {3.0, 0.0}, {4.0, 0.0, 0.0}, moving), CouplingRefusal::kNoWay);
  EXPECT_EQ(coupling.engage_at(law, {2.0, 0.0}, {}, moving), CouplingRefusal::kNoWay);
  EXPECT_EQ(coupling.engage_at(law, {8.0, 0.01}, {}, moving), CouplingRefusal::kTooSteep);
  EXPECT_EQ(coupling.engage_at(law, {NAN, 0.0}, {}, moving), CouplingRefusal::kNotFinite);
  EXPECT_EQ(coupling.engage_at(law, {8.0, -1.0}, {}, moving), CouplingRefusal::kNotFinite);
  EXPECT_EQ(coupling.engage(law, CatchUp::kPosition, {NAN, 0.0, 0.0}, moving), CouplingRefusal::kNotFinite);
  EXPECT_EQ(coupling.engage(law, CatchUp::kPosition, {}, {0.0, INFINITY, 0.0}), CouplingRefusal::kNotFinite);
  EXPECT_EQ(coupling.state(), CouplingState::kIdle);
  for (int reason = 0; reason <= static_cast<int>(CouplingRefusal::kTooSteep); ++reason)
    EXPECT_NE(to_text(static_cast<CouplingRefusal>(reason)), "?");
}

TEST(Coupling, ASlaveThatMovesComesToRestBeforeItWaits) {
  auto coupling = coupling_of(kSlave);
  const AxisSetpoint slave{0.0, -3.0, 20.0};
  ASSERT_EQ(coupling.engage_at(gear(1, 1, -6.0), {6.0, 2.0}, slave, cruise(0.0, 2.0, 0)), CouplingRefusal::kNone);
  Judge judge(kSlave);
  judge.look(slave.position);
  int step = 0;
  for (; step < 8000; ++step) judge.look(coupling.step(cruise(0.0, 2.0, step + 1)).position);
  EXPECT_EQ(coupling.state(), CouplingState::kWaiting);
  EXPECT_EQ(coupling.setpoint().velocity, 0.0);
  for (; step < 26000; ++step) judge.look(coupling.step(cruise(0.0, 2.0, step + 1)).position);
  EXPECT_TRUE(coupling.in_sync());
  EXPECT_EQ(judge.complaint(), "");
}

TEST(Coupling, APeriodicCamIsFollowedOverManyTurnsAndDirections) {
  CamTable table;
  for (int i = 0; i <= 24; ++i)
    table.points.push_back({kTurn * i / 24.0, 0.4 * (1.0 - std::cos(kTurn * (i % 24) / 24.0)), 0.0, 0.0, 0});
  const auto cam = Cam::make(table, CamMethod::kSpline, CamKind::kPeriodic).value();
  auto coupling = coupling_of(kSlave);
  test::Random random;
  RandomMaster master(random, kCalm);
  const auto law = CouplingLaw::cam(cam, 0.3, -1.0);
  ASSERT_EQ(coupling.engage(law, CatchUp::kPosition, {2.0, 0.0, 0.0}, master.now()), CouplingRefusal::kNone);
  Judge judge(kSlave);
  judge.look(2.0);
  for (int i = 0; i < 200000; ++i) {
    const auto now = master.step();
    judge.look(coupling.step(now).position, !coupling.in_sync());
    if (!coupling.in_sync()) continue;
    ASSERT_EQ(coupling.setpoint().position, law.at(now.position).position);
  }
  EXPECT_TRUE(coupling.in_sync());
  EXPECT_EQ(coupling.losses(), 0U);
  EXPECT_EQ(judge.complaint(), "");
}

TEST(Coupling, APhaseMovesTheMasterAsTheSlaveSeesIt) {
  auto coupling = coupling_of(kSlave);
  ASSERT_EQ(coupling.engage(gear(2, 1), CatchUp::kPosition, {}, cruise(0.0, 2.0, 0)), CouplingRefusal::kNone);
  Judge judge(kSlave);
  judge.look(0.0);
  int step = 0;
  while (!coupling.in_sync() && step < 20000) judge.look(coupling.step(cruise(0.0, 2.0, ++step)).position);
  ASSERT_TRUE(coupling.in_sync());
  // Half of what the slave's limits leave, as a distance of the master.
  ASSERT_TRUE(coupling.shift_phase_to(-0.7, ProfileLimits::symmetric(1.0, 20.0, 900.0)));
  EXPECT_FALSE(coupling.phase_reached());
  EXPECT_FALSE(coupling.shift_phase_to(NAN, ProfileLimits::symmetric(1.0, 20.0, 900.0)));
  EXPECT_FALSE(coupling.shift_phase_to(1.0, ProfileLimits::symmetric(0.0, 20.0, 900.0)));
  while (!coupling.phase_reached() && step < 40000) {
    judge.look(coupling.step(cruise(0.0, 2.0, ++step)).position);
    ASSERT_TRUE(coupling.in_sync());
  }
  EXPECT_EQ(coupling.phase().position, -0.7);
  EXPECT_EQ(coupling.setpoint().position, 2.0 * (cruise(0.0, 2.0, step).position - 0.7));
  EXPECT_EQ(judge.complaint(), "");
}

TEST(Coupling, IsReleasedIntoItsVelocityOrToRestWithinItsLimits) {
  for (const auto how : {Release::kKeepVelocity, Release::kStop}) {
    auto coupling = coupling_of(kSlave);
    ASSERT_EQ(coupling.engage(gear(1, 1), CatchUp::kPosition, {}, {}), CouplingRefusal::kNone);
    Judge judge(kSlave);
    // Accelerates with 20 rad/s^2, which it reaches with a limited jerk; released at about 2 rad/s.
    const auto up = plan_to_velocity({}, 4.0, 0.0, ProfileLimits::symmetric(6.0, 20.0, 1000.0)).value();
    for (int step = 0; step < 1000; ++step) judge.look(coupling.step(up.evaluate((step + 1) * kPeriod)).position);
    ASSERT_TRUE(coupling.in_sync());
    const double velocity = coupling.setpoint().velocity;
    coupling.release(how);
    int steps = 0;
    while (!coupling.settled() && ++steps < 8000) judge.look(coupling.step({NAN, NAN, NAN}).position);
    judge.look(coupling.step({}).position);
    EXPECT_TRUE(coupling.settled());
    EXPECT_NEAR(coupling.setpoint().velocity, how == Release::kStop ? 0.0 : velocity, 1e-12);
    EXPECT_EQ(judge.complaint(), "");
  }
}

// A drive that missed commands for some cycles is off the law when it receives them again.
TEST(Coupling, FindsBackFromWhereItsSlaveWasMovedTo) {
  auto coupling = coupling_of(kSlave);
  ASSERT_EQ(coupling.engage(gear(1, 1), CatchUp::kPosition, {}, {}), CouplingRefusal::kNone);
  int step = 0;
  while (step < 4000) (void)coupling.step(cruise(0.0, 0.0, ++step));
  ASSERT_TRUE(coupling.in_sync());
  coupling.moved_to({0.02, 0.5, 0.0});
  EXPECT_FALSE(coupling.in_sync());
  Judge judge(kSlave);
  judge.look(0.02);
  while (!coupling.in_sync() && step < 8000) judge.look(coupling.step(cruise(0.0, 0.0, ++step)).position);
  EXPECT_TRUE(coupling.in_sync());
  EXPECT_EQ(coupling.setpoint().position, 0.0);
  EXPECT_EQ(coupling.losses(), 0U);
  EXPECT_EQ(judge.complaint(), "");
}

// The master accelerates to 15 rad/s, and back to 4: the limit of the slave is 10.
TEST(Coupling, AMasterThatIsTooFastIsFollowedWithinTheLimitsOrNotAnyMore) {
  for (const auto on_loss : {OnLoss::kFollow, OnLoss::kStop}) {
    auto coupling = coupling_of(kSlave, {});
    coupling.set_on_loss(on_loss);
    ASSERT_EQ(coupling.engage(gear(1, 1), CatchUp::kPosition, {}, {}), CouplingRefusal::kNone);
    Judge judge(kSlave);
    const auto limits = ProfileLimits::symmetric(20.0, 50.0, 2000.0);
    const auto up = plan_to_velocity({}, 15.0, 0.0, limits).value();
    const auto down = plan_to_velocity(up.evaluate(0.6), 4.0, 0.0, limits).value();
    for (int step = 1; step <= 16000; ++step) {
      const double now_s = step * kPeriod;
      judge.look(coupling.step(now_s < 0.6 ? up.evaluate(now_s) : down.evaluate(now_s - 0.6)).position, false);
    }
    EXPECT_EQ(judge.complaint(), "");
    EXPECT_EQ(coupling.losses(), 1U);
    const bool follows = on_loss == OnLoss::kFollow;
    EXPECT_EQ(coupling.in_sync(), follows);
    EXPECT_NEAR(coupling.setpoint().velocity, follows ? 4.0 : 0.0, 1e-9);
    EXPECT_NE(coupling.settled(), follows);
  }
}

TEST(Coupling, AMasterThatIsNoNumberBringsTheSlaveToRest) {
  auto coupling = coupling_of(kSlave);
  ASSERT_EQ(coupling.engage(gear(1, 1), CatchUp::kPosition, {0.0, 2.0, 0.0}, cruise(0.0, 2.0, 0)),
            CouplingRefusal::kNone);
  Judge judge(kSlave);
  for (int step = 0; step < 400; ++step) judge.look(coupling.step(cruise(0.0, 2.0, step + 1)).position);
  ASSERT_TRUE(coupling.in_sync());
  for (int step = 0; step < 4000; ++step) judge.look(coupling.step({NAN, 0.0, 0.0}).position);
  EXPECT_TRUE(coupling.settled());
  EXPECT_EQ(coupling.setpoint().velocity, 0.0);
  EXPECT_EQ(judge.complaint(), "");
}

TEST(Coupling, UsesNeitherHeapNorLocksInTheCycle) {
  if (!rt::RtGuard::available()) GTEST_SKIP() << "a sanitizer owns malloc in this build";
  test::Random random;
  CamTable table;
  for (int i = 0; i <= 12; ++i) table.points.push_back({0.5 * i, std::sin(kTurn * (i % 12) / 12.0), 0.0, 0.0, 0});
  const auto cam = Cam::make(table, CamMethod::kSpline, CamKind::kPeriodic).value();
  auto coupling = coupling_of(kSlave, {});
  double sum = 0.0;
  rt::RtGuard::enter();
  for (int round = 0; round < 20; ++round) {
    AxisSetpoint master{0.0, random.real(-20.0, 20.0), 0.0};
    const auto law = round % 2 == 0 ? CouplingLaw::cam(cam, 0.0, 0.0) : CouplingLaw();
    (void)coupling.engage(law, CatchUp::kPosition, {1.0, 2.0, 3.0}, master);
    (void)coupling.shift_phase_to(1.0, profile_limits(kCalm));
    for (int step = 0; step < 500; ++step) {
      master.position += master.velocity * kPeriod;
      sum += coupling.step(master).position;
    }
    coupling.release(Release::kStop);
    sum += coupling.step(master).position;
    (void)coupling.engage_at(law, {9.0, 1.0}, coupling.setpoint(), {});
  }
  const auto counts = rt::RtGuard::leave();
  EXPECT_EQ(counts.total(), 0U);
  EXPECT_TRUE(std::isfinite(sum));
}

}  // namespace
}  // namespace driveline::trajectory
