#pragma once

#include "driveline/ecat_master/cyclic/motion_control.hpp"
#include "driveline/rt/spsc_ring.hpp"
#include "driveline/snapshot/snapshot.hpp"

namespace driveline::ecat_master {

/// Rings the cycle writes its samples to; both may be left out.
struct SampleRings {
  rt::SpscRing<snapshot::LineSample>* lines = nullptr;  ///< one sample per sampled cycle
  rt::SpscRing<snapshot::AxisSample>* axes = nullptr;   ///< one per axis and sampled cycle
};

/// Writes a sample of each axis, of the cycle that `line` is of, into the ring: all of them, or none where there is not
/// room for all. \rtsafe
void publish(const MotionControl& motion, const snapshot::LineSample& line,
             rt::SpscRing<snapshot::AxisSample>& ring) noexcept;

}  // namespace driveline::ecat_master
