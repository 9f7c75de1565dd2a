#include "driveline/trajectory/delta_kinematics.hpp"

#include <algorithm>
#include <cmath>
#include <initializer_list>
#include <stdexcept>

#include "text.hpp"

namespace driveline::trajectory {
namespace {

constexpr std::size_t kChains = 3;
constexpr double kHalfOfRootOf3 = 0.86602540378443864676;
/// Directions of the chains around z.
constexpr std::array<double, kChains> kCosines{1.0, -0.5, -0.5};
constexpr std::array<double, kChains> kSines{0.0, kHalfOfRootOf3, -kHalfOfRootOf3};

constexpr std::array<KinematicCoordinate, kChains> kDeltaTool{
    {{"x", AxisKind::kLinear}, {"y", AxisKind::kLinear}, {"z", AxisKind::kLinear}}};

using Point = std::array<double, 3>;

Point minus(const Point& a, const Point& b) noexcept {
  return {a[0] - b[0], a[1] - b[1], a[2] - b[2]};
}

double dot(const Point& a, const Point& b) noexcept {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

Point cross(const Point& a, const Point& b) noexcept {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}

double positive(std::initializer_list<double> lengths) {
  for (const double length : lengths) {
    if (!(length > 0.0 && std::isfinite(length))) {
      throw std::invalid_argument("the lengths of a delta must be above 0");
    }
  }
  return *lengths.begin();
}

}  // namespace

DeltaKinematics::DeltaKinematics(double rod, AxisKind joint)
    : rod_(positive({rod})), joints_{{{"1", joint}, {"2", joint}, {"3", joint}}} {}

std::span<const KinematicCoordinate> DeltaKinematics::coordinates() const noexcept {
  return kDeltaTool;
}

std::span<const KinematicCoordinate> DeltaKinematics::joints() const noexcept {
  return joints_;
}

// The platform, reduced to a point, is at the distance of the rod length from all three knees. So it lies on the line
// through the centre of the circle through the knees, perpendicular to their plane; the lower of the two solutions
// applies.
bool DeltaKinematics::forward(const GroupVector& joints, GroupVector& tool) const noexcept {
  std::array<Point, kChains> knees{};
  for (std::size_t k = 0; k < kChains; ++k) {
    const auto [out, up] = knee(joints[k]);
    knees[k] = {kCosines[k] * out, kSines[k] * out, up};
  }
  const Point a = minus(knees[1], knees[0]);
  const Point b = minus(knees[2], knees[0]);
  const Point normal = cross(a, b);
  const double square = dot(normal, normal);
  if (!(square > 0.0)) return false;
  const Point across_a = cross(normal, a);
  const Point across_b = cross(b, normal);
  Point middle{};
  for (std::size_t i = 0; i < middle.size(); ++i) {
    middle[i] = (dot(b, b) * across_a[i] + dot(a, a) * across_b[i]) / (2.0 * square);
  }
  const double left = rod_ * rod_ - dot(middle, middle);
  if (!(left > 0.0)) return false;
  const double along = -std::copysign(std::sqrt(left / square), normal[2]);
  for (std::size_t i = 0; i < middle.size(); ++i) tool[i] = knees[0][i] + middle[i] + along * normal[i];
  return true;
}

PoseFault DeltaKinematics::inverse(const PathGeometry& tool, PathGeometry& joints) const noexcept {
  const PathJet x = jet(tool, 0);
  const PathJet y = jet(tool, 1);
  const PathJet z = jet(tool, 2);
  std::array<PathJet, kChains> found{};
  std::array<Point, kChains> rods{};
  PoseFault fault;
  for (std::size_t k = 0; k < kChains; ++k) {
    const auto kind = solve(x * kCosines[k] + y * kSines[k], y * kCosines[k] - x * kSines[k], z, found[k]);
    if (kind == PoseFault::Kind::kUnreachable) return {kind, k};
    if (fault.kind == PoseFault::Kind::kNone && kind != PoseFault::Kind::kNone) fault = {kind, k};
    const auto [out, up] = knee(found[k].value);
    rods[k] = minus({x.value, y.value, z.value}, {kCosines[k] * out, kSines[k] * out, up});
  }
  for (std::size_t k = 0; k < kChains; ++k) put(joints, k, found[k]);
  // Rods in one plane do not hold the platform in the direction perpendicular to it. The lower solution of forward()
  // has a negative determinant.
  const double held = -dot(rods[0], cross(rods[1], rods[2])) / (rod_ * rod_ * rod_);
  if (fault.kind == PoseFault::Kind::kNone && held < kSingularSine) fault.kind = PoseFault::Kind::kSingular;
  return fault;
}

std::string DeltaKinematics::explain(const PoseFault& fault) const {
  const std::string chain = "chain " + std::to_string(fault.joint + 1);
  if (fault.kind == PoseFault::Kind::kUnreachable) return chain + " is too short or too long for it";
  if (fault.joint == PoseFault::kAllJoints)
    return "the rods would be in one plane there and could not hold the platform";
  return "arm and rods of " + chain + " would be in line there";
}

RotaryDeltaKinematics::RotaryDeltaKinematics(const Shape& shape)
    : DeltaKinematics(shape.rod, AxisKind::kRotary),
      offset_(positive({shape.base_radius}) - positive({shape.platform_radius})),
      upper_arm_(positive({shape.upper_arm})) {}

DeltaKinematics::Knee RotaryDeltaKinematics::knee(double joint) const noexcept {
  return {offset_ + upper_arm_ * std::cos(joint), -upper_arm_ * std::sin(joint)};
}

// With the position (a, w) in the plane of the arm, outwards and downwards from its axis, and the angle t of the arm,
// the knee is at the distance of the rod length if a cos t + w sin t = e; of both angles the outer one applies.
PoseFault::Kind RotaryDeltaKinematics::solve(const PathJet& out, const PathJet& side, const PathJet& up,
                                             PathJet& joint) const noexcept {
  const PathJet a = out + -offset_;
  const PathJet w = -up;
  const PathJet square = a * a + w * w;
  const PathJet e = (square + side * side + (upper_arm_ * upper_arm_ - rod_ * rod_)) * (0.5 / upper_arm_);
  const PathJet left = square - e * e;
  if (!(left.value > 0.0)) return PoseFault::Kind::kUnreachable;
  const PathJet root = sqrt(left);
  joint = atan2(w * e - a * root, a * e + w * root);
  return root.value < kSingularSine * std::sqrt(square.value) ? PoseFault::Kind::kSingular : PoseFault::Kind::kNone;
}

LinearDeltaKinematics::LinearDeltaKinematics(const Shape& shape)
    : DeltaKinematics(shape.rod, AxisKind::kLinear),
      offset_(positive({shape.column_radius}) - positive({shape.platform_radius})) {}

DeltaKinematics::Knee LinearDeltaKinematics::knee(double joint) const noexcept {
  return {offset_, joint};
}

PoseFault::Kind LinearDeltaKinematics::solve(const PathJet& out, const PathJet& side, const PathJet& up,
                                             PathJet& joint) const noexcept {
  const PathJet a = out + -offset_;
  const PathJet left = -(a * a + side * side) + rod_ * rod_;
  if (!(left.value > 0.0)) return PoseFault::Kind::kUnreachable;
  const PathJet height = sqrt(left);
  joint = up + height;
  return height.value < kSingularSine * rod_ ? PoseFault::Kind::kSingular : PoseFault::Kind::kNone;
}

}  // namespace driveline::trajectory
