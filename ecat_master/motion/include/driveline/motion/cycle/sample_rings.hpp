#pragma once

#include "driveline/motion/control/motion_control.hpp"
#include "driveline/rt/spsc_ring.hpp"
#include "driveline/snapshot/snapshot.hpp"

namespace driveline::motion {

/// Ring buffers to which the cycle writes its samples; null: none.
struct SampleRings {
  rt::SpscRing<snapshot::LineSample>* lines = nullptr;  ///< one sample per sampled cycle
  rt::SpscRing<snapshot::AxisSample>* axes = nullptr;   ///< one per axis and sampled cycle
};

/// Writes a sample of each axis, for the cycle of `line`, into the ring: all samples, or none if they do not all fit.
/// \rtsafe
void publish(const MotionControl& motion, const snapshot::LineSample& line,
             rt::SpscRing<snapshot::AxisSample>& ring) noexcept;

}  // namespace driveline::motion
