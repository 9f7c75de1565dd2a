#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "driveline/slaves/msd/core/variant.hpp"
#include "single_line.hpp"
#include "startup_objects.hpp"

namespace driveline::bus_test {

inline constexpr double kOwnVelocity = 10.0;  ///< set in the drive, rad/s; used for objects that are not mapped

inline RunOptions profile_options(slaves::msd::Variant variant = slaves::msd::Variant::kMsd) {
  auto options = single_options();
  options.variant = variant;
  const auto increments = [](double value) { return static_cast<std::uint32_t>(value * kDemandIncrements); };
  set_object(options, 0x6081, 0, increments(kOwnVelocity));
  set_object(options, 0x6083, 0, increments(500.0));
  set_object(options, 0x6084, 0, increments(800.0));
  return options;
}

/// Options with 6081h and 6083h mapped.
inline RunOptions mapped_options() {
  auto options = profile_options();
  options.pdos = motion::PdoConfiguration{{{0x1600, {{0x6040, 0, 16}, {0x6060, 0, 8}, {0x607A, 0, 32}}},
                                           {0x1601, {{0x60FF, 0, 32}, {0x6081, 0, 32}}},
                                           {0x1602, {{0x6083, 0, 32}}}},
                                          {{0x1A00, {{0x6041, 0, 16}, {0x6061, 0, 8}, {0x6064, 0, 32}}},
                                           {0x1A01, {{0x606C, 0, 32}, {0x60F4, 0, 32}}},
                                           {0x1A02, {{0x6077, 0, 16}, {0x603F, 0, 16}}}}};
  return options;
}

/// Options with 6042h mapped, which counts in revolutions per minute.
inline RunOptions velocity_mode_options(slaves::msd::Variant variant = slaves::msd::Variant::kMsd) {
  auto options = profile_options(variant);
  options.pdos = motion::PdoConfiguration{
      {{0x1600, {{0x6040, 0, 16}, {0x6060, 0, 8}, {0x607A, 0, 32}}}, {0x1601, {{0x60FF, 0, 32}, {0x6042, 0, 16}}}},
      {{0x1A00, {{0x6041, 0, 16}, {0x6061, 0, 8}, {0x6064, 0, 32}}},
       {0x1A01, {{0x606C, 0, 32}, {0x60F4, 0, 32}}},
       {0x1A02, {{0x6077, 0, 16}, {0x603F, 0, 16}}}}};
  count_in_rpm(options);
  return options;
}

inline AxisRequest run_at(double velocity) {
  return request(AxisCommand::kDriveRun, velocity);
}
inline AxisRequest to(double target) {
  return request(AxisCommand::kDriveMoveAbsolute, target);
}
inline AxisRequest by(double distance) {
  return request(AxisCommand::kDriveMoveRelative, distance);
}
inline AxisRequest at(double velocity) {
  return request(AxisCommand::kDriveMoveVelocity, velocity);
}

class ProfileLine : public SingleLine {
 public:
  explicit ProfileLine(const RunOptions& options = profile_options()) : SingleLine(1, options) { enable(); }
  [[nodiscard]] motion::AxisReport now() { return axes().axis_report(0); }
  /// Expects that the axis is usable.
  void expect_use() {
    cycles(200);
    EXPECT_EQ(state(), PlcopenState::kStandstill);
    EXPECT_EQ(now().mode, 8);
    EXPECT_EQ(ask(request(AxisCommand::kMoveRelative, 1.0)).phase, RequestPhase::kDone);
  }
  /// The highest speed of the axis within `count` cycles.
  double fastest(int count) {
    double found = 0.0;
    for (int i = 0; i < count; ++i) {
      cycle();
      found = std::max(found, std::abs(now().velocity));
    }
    return found;
  }
};

}  // namespace driveline::bus_test
