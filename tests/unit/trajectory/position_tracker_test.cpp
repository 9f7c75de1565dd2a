// Position, velocity and acceleration from an encoder with a coarse resolution that loses measurements, stops and
// jumps.
#include "driveline/trajectory/position_tracker.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <random>
#include <vector>

namespace driveline::trajectory {
namespace {

constexpr double kPeriod = 125e-6;
/// 14 bits per turn: a coarse encoder.
constexpr double kResolution = 2.0 * std::numbers::pi / 16384.0;

TrackerSettings settings(double noise = kResolution) {
  TrackerSettings made;
  made.period_s = kPeriod;
  made.noise = noise;
  made.max_velocity = 100.0;
  return made;
}

double grained(double position) {
  return std::round(position / kResolution) * kResolution;
}

/// Differences of the output, as sent to a drive.
class Demand {
 public:
  void see(double position) {
    places_.push_back(position);
    const auto n = places_.size();
    if (n < 4) return;
    const double step = places_[n - 1] - places_[n - 2];
    const double before = places_[n - 2] - places_[n - 3];
    velocity = std::max(velocity, std::abs(step) / kPeriod);
    acceleration = std::max(acceleration, std::abs(step - before) / (kPeriod * kPeriod));
  }
  double velocity = 0.0;
  double acceleration = 0.0;

 private:
  std::vector<double> places_;
};

void settle(PositionTracker& tracker, double position) {
  for (int i = 0; i < 4000; ++i) tracker.step(position);
  ASSERT_TRUE(tracker.valid());
}

TEST(PositionTracker, IsNotLateAtAConstantVelocityOrAcceleration) {
  PositionTracker tracker(settings(0.0));
  const auto place = [](double t) { return 3.0 + 20.0 * t + 0.5 * 40.0 * t * t; };
  for (int i = 0; i < 8000; ++i) tracker.step(place(i * kPeriod));
  const double now = 7999 * kPeriod;
  EXPECT_NEAR(tracker.at(0.0).position, place(now), 1e-9);
  EXPECT_NEAR(tracker.at(0.0).velocity, 20.0 + 40.0 * now, 1e-7);
  EXPECT_NEAR(tracker.at(0.0).acceleration, 40.0, 1e-5);
  EXPECT_NEAR(tracker.at(0.003).position, place(now + 0.003), 1e-9);
}

TEST(PositionTracker, TheGrainOfACoarseEncoderIsNotInTheDemand) {
  PositionTracker tracker(settings());
  const auto place = [](double t) { return 17.3 * t; };
  Demand demand;
  double worst = 0.0;
  for (int i = 0; i < 24000; ++i) {
    tracker.step(grained(place(i * kPeriod)));
    if (i < 4000) continue;
    const auto ahead = tracker.at(3.0 * kPeriod);
    demand.see(ahead.position);
    worst = std::max(worst, std::abs(ahead.position - place((i + 3) * kPeriod)));
  }
  EXPECT_LT(worst, kResolution);
  // Differences of the measurements themselves would be kResolution / kPeriod^2, 24,500 rad/s^2.
  EXPECT_LT(demand.acceleration, 10.0);
  EXPECT_NEAR(demand.velocity, 17.3, 0.05);
}

TEST(PositionTracker, WhatStandsDoesNotMoveWhateverTheNoise) {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> noise(-0.999 * kResolution, 0.999 * kResolution);
  PositionTracker tracker(settings());
  for (int i = 0; i < 8000; ++i) tracker.step(1.0 + noise(random));
  ASSERT_TRUE(tracker.standing());
  const auto stands = tracker.at(0.01);
  EXPECT_EQ(stands.velocity, 0.0);
  EXPECT_NEAR(stands.position, 1.0, kResolution);
  for (int i = 0; i < 80000; ++i) {
    tracker.step(1.0 + noise(random));
    ASSERT_EQ(tracker.at(0.01).position, stands.position) << i;
  }
}

// So slow that the measured position pauses: it is followed nevertheless, and no error accumulates.
TEST(PositionTracker, SlowMotionIsFollowed) {
  PositionTracker tracker(settings());
  settle(tracker, 0.0);
  double position = 0.0;
  double worst = 0.0;
  Demand demand;
  for (int i = 0; i < 160000; ++i) {
    position += 20.0 * kResolution * kPeriod;
    tracker.step(grained(position));
    demand.see(tracker.at(0.0).position);
    worst = std::max(worst, std::abs(tracker.at(0.0).position - position));
  }
  EXPECT_GT(position, 300.0 * kResolution);
  EXPECT_LT(worst, 4.5 * kResolution);
  EXPECT_LT(demand.acceleration, 150.0);
}

TEST(PositionTracker, LostMeasurementsAreBridgedWithoutALeap) {
  std::mt19937 random(11);
  PositionTracker tracker(settings());
  double t = 0.0;
  const auto place = [](double at) { return 2.0 * std::sin(5.0 * at); };
  Demand demand;
  double worst = 0.0;
  for (int i = 0; i < 40000; ++i, t += kPeriod) {
    const bool lost = i > 4000 && random() % 40 < 8;
    if (lost) {
      tracker.step();
    } else {
      tracker.step(grained(place(t)));
    }
    if (i < 4000) continue;
    ASSERT_TRUE(tracker.valid()) << i;
    demand.see(tracker.at(0.0).position);
    worst = std::max(worst, std::abs(tracker.at(0.0).position - place(t)));
  }
  EXPECT_LT(worst, 3.0 * kResolution);
  EXPECT_LT(demand.acceleration, 1.3 * 2.0 * 25.0);
}

TEST(PositionTracker, IsLostWhenNothingComesAndBeginsAnew) {
  PositionTracker tracker(settings());
  settle(tracker, 5.0);
  for (int i = 0; i < 8; ++i) tracker.step();
  EXPECT_TRUE(tracker.valid());
  tracker.step();
  EXPECT_FALSE(tracker.valid());
  tracker.step(900.0);
  EXPECT_FALSE(tracker.valid()) << "what it was before says nothing about now";
  settle(tracker, 900.0);
  EXPECT_NEAR(tracker.at(0.0).position, 900.0, 1e-9);
}

TEST(PositionTracker, APlaceWhereItCannotBeIsNotBelieved) {
  PositionTracker tracker(settings());
  settle(tracker, 5.0);
  const auto before = tracker.at(0.0);
  tracker.step(-40.0);
  tracker.step(std::numeric_limits<double>::quiet_NaN());
  tracker.step(5.0);
  EXPECT_EQ(tracker.leaps(), 1U);
  EXPECT_EQ(tracker.at(0.0).position, before.position);
  for (int i = 0; i < 9; ++i) tracker.step(-40.0);
  EXPECT_FALSE(tracker.valid()) << "it has another zero: who follows it must not go there";
}

TEST(PositionTracker, IsStableInAnyPeriod) {
  for (const double period : {31.25e-6, 125e-6, 1e-3, 4e-3, 0.02}) {
    auto with = settings(0.0);
    with.period_s = period;
    PositionTracker tracker(with);
    for (int i = 0; i < 4000; ++i) tracker.step(2.0 * i * period);
    EXPECT_NEAR(tracker.at(0.0).position, 2.0 * 3999 * period, 1e-9) << period;
    EXPECT_NEAR(tracker.at(0.0).velocity, 2.0, 1e-6) << period;
  }
}

}  // namespace
}  // namespace driveline::trajectory
