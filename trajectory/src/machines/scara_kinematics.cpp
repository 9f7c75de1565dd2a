#include "driveline/trajectory/scara_kinematics.hpp"

#include <array>
#include <cmath>
#include <stdexcept>

#include "text.hpp"

namespace driveline::trajectory {
namespace {

constexpr std::size_t kShoulder = 0;
constexpr std::size_t kElbow = 1;
constexpr std::size_t kLift = 2;
constexpr std::size_t kWrist = 3;

constexpr std::array<KinematicCoordinate, 4> kScaraTool{
    {{"x", AxisKind::kLinear}, {"y", AxisKind::kLinear}, {"z", AxisKind::kLinear}, {"c", AxisKind::kRotary}}};
constexpr std::array<KinematicCoordinate, 4> kScaraJoints{{{"shoulder", AxisKind::kRotary},
                                                           {"elbow", AxisKind::kRotary},
                                                           {"lift", AxisKind::kLinear},
                                                           {"wrist", AxisKind::kRotary}}};

}  // namespace

ScaraKinematics::ScaraKinematics(const Shape& shape) : shape_(shape) {
  if (!(shape.upper_arm > 0.0 && shape.forearm > 0.0 && std::isfinite(shape.upper_arm + shape.forearm))) {
    throw std::invalid_argument("the arms of a SCARA must be longer than 0");
  }
}

std::span<const KinematicCoordinate> ScaraKinematics::coordinates() const noexcept {
  return kScaraTool;
}

std::span<const KinematicCoordinate> ScaraKinematics::joints() const noexcept {
  return kScaraJoints;
}

bool ScaraKinematics::forward(const GroupVector& joints, GroupVector& tool) const noexcept {
  const double direction = joints[kShoulder] + joints[kElbow];
  tool[0] = shape_.upper_arm * std::cos(joints[kShoulder]) + shape_.forearm * std::cos(direction);
  tool[1] = shape_.upper_arm * std::sin(joints[kShoulder]) + shape_.forearm * std::sin(direction);
  tool[2] = joints[kLift];
  tool[3] = direction + joints[kWrist];
  return true;
}

// Solves the triangle of upper arm, forearm and distance by its cosine; both angles by atan2, which is accurate
// everywhere.
PoseFault ScaraKinematics::inverse(const PathGeometry& tool, PathGeometry& joints) const noexcept {
  const PathJet x = jet(tool, 0);
  const PathJet y = jet(tool, 1);
  const double a = shape_.upper_arm;
  const double b = shape_.forearm;
  const PathJet cosine = (x * x + y * y + -(a * a + b * b)) * (1.0 / (2.0 * a * b));
  const PathJet squared_sine = -(cosine * cosine) + 1.0;
  if (!(squared_sine.value > 0.0)) return {PoseFault::Kind::kUnreachable, kElbow};
  const PathJet sine = sqrt(squared_sine) * (shape_.elbow_left ? 1.0 : -1.0);
  const PathJet elbow = atan2(sine, cosine);
  const PathJet shoulder = within_half_turns(atan2(y, x) - atan2(sine * b, cosine * b + a));
  put(joints, kShoulder, shoulder);
  put(joints, kElbow, elbow);
  const PathJet turn = jet(tool, 3);
  put(joints, kLift, jet(tool, 2));
  put(joints, kWrist, turn - shoulder - elbow);
  if (std::abs(sine.value) < kSingularSine) return {PoseFault::Kind::kSingular, kElbow};
  return {};
}

std::string ScaraKinematics::explain(const PoseFault& fault) const {
  if (fault.kind == PoseFault::Kind::kSingular) return "the arms would be stretched or folded there";
  return "the arms reach from " + to_short_text(std::abs(shape_.upper_arm - shape_.forearm)) + " m to " +
         to_short_text(shape_.upper_arm + shape_.forearm) + " m";
}

}  // namespace driveline::trajectory
