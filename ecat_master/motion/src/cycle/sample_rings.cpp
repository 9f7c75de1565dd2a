#include "driveline/motion/cycle/sample_rings.hpp"

namespace driveline::motion {

void publish(const MotionControl& motion, const snapshot::LineSample& line,
             rt::SpscRing<snapshot::AxisSample>& ring) noexcept {
  ring.try_push_all(motion.axes().size(), [&](std::size_t i, snapshot::AxisSample& sample) noexcept {
    sample = {.cycle = line.cycle, .time_ns = line.time_ns};
    sample.axis = static_cast<std::uint16_t>(i);
    motion.fill(i, sample);
  });
}

}  // namespace driveline::motion
