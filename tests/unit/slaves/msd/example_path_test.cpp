// CSP at 125 us along the path of the eight-axis example: the required torque by the motor data, and the allowed lag of
// the axis.
#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>

#include "drive_rig.hpp"
#include "driveline/trajectory/interpolator.hpp"

namespace driveline::slaves::msd {
namespace {

/// A cycle: the path's demand and the drive's reports.
struct Sample {
  trajectory::AxisSetpoint demand;  ///< rad, demanded position of the shaft
  double torque_nm = 0.0;
  double following_error = 0.0;  ///< increments, as the drive reports it
};

/// A drive that follows an axis of the path for `seconds`.
std::vector<Sample> follow(std::size_t axis, double seconds, const MsdParameters& parameters,
                           void (*prepare)(DriveRig&)) {
  const auto path = trajectory::load_path(DRIVELINE_EXAMPLES_DIR "/line8.csv");
  if (!path) throw std::runtime_error(path.error().message());
  auto spline = trajectory::Interpolator::clamped_spline(*path);
  std::vector<trajectory::AxisSetpoint> setpoints(spline.axes().size());
  DriveRig rig(parameters);
  EXPECT_EQ(rig.write(0x2172, 0, 3, 1), 0U);  // cubic spline
  rig.operate();
  prepare(rig);
  rig.enable(8);
  rig.cycles(200);
  std::vector<Sample> samples;
  const int cycles = static_cast<int>(seconds / kCycleS);
  for (int i = 0; i < cycles; ++i) {
    spline.evaluate(i * kCycleS, setpoints);
    rig.target_position = static_cast<std::int32_t>(std::lrint(setpoints[axis].position * kIncrementsPerRadian));
    rig.cycle();
    samples.push_back({setpoints[axis], rig.drive.torque_nm(), double{0} + rig.following_error});
  }
  EXPECT_EQ(rig.drive.state(), PowerState::kOperationEnabled);
  return samples;
}

/// Torque that the motor needs on the path: J a + D w + friction.
double needed_nm(const MotorParameters& motor, const trajectory::AxisSetpoint& demand) {
  const double friction =
      std::abs(demand.velocity) > 0.01 ? std::copysign(motor.coulomb_friction_nm, demand.velocity) : 0.0;
  return motor.inertia_kg_m2 * demand.acceleration + motor.viscous_friction_nm_s * demand.velocity + friction;
}

/// The spline is two periods late, the torque another lag later: samples are compared at this distance in cycles.
constexpr std::size_t kLate = 4;
constexpr std::size_t kMean = 16;  ///< cycles of the mean values: 2 ms

/// Setpoints are whole increments: their second difference is off by up to two, and the torque feed-forward is derived
/// from it. That ripple is real, but has no mean.
double ripple_nm(const MotorParameters& motor) {
  return 2.0 * motor.inertia_kg_m2 / (kIncrementsPerRadian * kCycleS * kCycleS);
}

struct Peaks {
  double torque_nm = 0.0;
  double needed_nm = 0.0;
  double mean_error_nm = 0.0;    ///< largest difference of the means over 2 ms, away from reversals
  double following_error = 0.0;  ///< increments
  double speed = 0.0;            ///< rad/s
};

Peaks peaks(const std::vector<Sample>& samples, const MotorParameters& motor) {
  Peaks result;
  double difference = 0.0;
  std::size_t turning = 0;  // when the axis last reversed
  for (std::size_t i = kLate; i < samples.size(); ++i) {
    const auto& demand = samples[i - kLate].demand;
    const double needed = needed_nm(motor, demand);
    result.torque_nm = std::max(result.torque_nm, std::abs(samples[i].torque_nm));
    result.needed_nm = std::max(result.needed_nm, std::abs(needed));
    result.speed = std::max(result.speed, std::abs(demand.velocity));
    result.following_error = std::max(result.following_error, std::abs(samples[i].following_error));
    difference += (samples[i].torque_nm - needed - difference) / kMean;
    // At a reversal or standstill the friction reverses too, and the controller needs time.
    if (std::abs(demand.velocity) < 2.0) turning = i;
    if (i > turning + 400) result.mean_error_nm = std::max(result.mean_error_nm, std::abs(difference));
  }
  return result;
}

void nothing(DriveRig&) {}
void without_feed_forward(DriveRig& rig) {
  rig.set({real_value(0x2177, 0, 0.0F), real_value(0x2178, 0, 0.0F)});
}

TEST(MsdExamplePath, TorqueIsInertiaTimesAccelerationPlusFriction) {
  const MotorParameters motor;
  const char* names[] = {"x", "y", "z", "a", "b", "c", "u", "v"};
  for (std::size_t axis = 0; axis < std::size(names); ++axis) {
    const auto samples = follow(axis, 10.0, {}, nothing);
    const auto peak = peaks(samples, motor);
    RecordProperty(std::string(names[axis]) + "_peak_torque_mNm", static_cast<int>(1e3 * peak.torque_nm));
    RecordProperty(std::string(names[axis]) + "_peak_following_error", static_cast<int>(peak.following_error));
    EXPECT_LT(peak.torque_nm, motor.peak_torque_nm) << names[axis] << ": never at the limit";
    EXPECT_NEAR(peak.torque_nm, peak.needed_nm, ripple_nm(motor)) << names[axis];
    EXPECT_LT(peak.mean_error_nm, 0.02 + 0.02 * peak.needed_nm) << names[axis];
    // A tenth of a degree, with feed-forward, at up to 190 rad/s.
    EXPECT_LT(peak.following_error, 300.0) << names[axis];
  }
}

TEST(MsdExamplePath, FollowingErrorWithoutFeedForwardIsSpeedOverGain) {
  const MotorParameters motor;
  const ControllerParameters controller;
  constexpr std::size_t kAxisZ = 2;
  const auto with = peaks(follow(kAxisZ, 4.0, {}, nothing), motor);
  const auto without = peaks(follow(kAxisZ, 4.0, {}, without_feed_forward), motor);
  const double expected = without.speed / controller.position_gain_per_s * kIncrementsPerRadian;
  EXPECT_NEAR(without.following_error, expected, 0.1 * expected);
  EXPECT_GT(without.following_error, 100.0 * with.following_error);
}

TEST(MsdExamplePath, WindingsTakeTheCurrentThatTheTorqueNeeds) {
  MsdParameters parameters;
  parameters.motor.winding.simulated = true;
  constexpr std::size_t kAxisZ = 2;
  const auto samples = follow(kAxisZ, 2.6, parameters, nothing);
  const auto peak = peaks(samples, parameters.motor);
  EXPECT_NEAR(peak.torque_nm, peak.needed_nm, ripple_nm(parameters.motor));
  EXPECT_LT(peak.mean_error_nm, 0.02 + 0.02 * peak.needed_nm);
  EXPECT_LT(peak.following_error, 600.0);
}

}  // namespace
}  // namespace driveline::slaves::msd
