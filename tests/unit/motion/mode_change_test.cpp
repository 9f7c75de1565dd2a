#include "driveline/motion/axis/mode_change.hpp"

#include <gtest/gtest.h>

namespace driveline::motion {
namespace {

using cia402::Mode;

ModeChange::Measured in_csp(double position, double velocity) {
  ModeChange::Measured measured;
  measured.position = position;
  measured.velocity = measured.led_velocity = velocity;
  measured.fresh = true;
  measured.shown = Mode::kCyclicPosition;
  return measured;
}

/// The axis would otherwise jump back to its position at that time.
TEST(ModeChange, ThatWasCancelledLeavesNoPlaceToTheNextMotion) {
  ModeChange change({.limits = {50.0, 1000.0}});
  const auto measured = in_csp(1.0, 2.0);
  change.begin(measured, {.position = 1.0, .velocity = 2.0});
  static_cast<void>(change.reference(measured, {1.0, 2.0, 0.0}));
  change.cancel();  // e.g. because of a drive fault
  auto later = in_csp(-4.0, 0.0);
  later.shown = Mode::kCyclicTorque;
  change.carry(0.1, 0.0);  // the end of a torque
  EXPECT_EQ(change.reference(later, {-4.0, 0.0, 0.0}).position, -4.0);
}

}  // namespace
}  // namespace driveline::motion
