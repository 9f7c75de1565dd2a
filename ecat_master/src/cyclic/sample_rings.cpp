#include "driveline/ecat_master/cyclic/sample_rings.hpp"

namespace driveline::ecat_master {

void publish(std::span<const Axis> axes, const snapshot::LineSample& line,
             rt::SpscRing<snapshot::AxisSample>& ring) noexcept {
  ring.try_push_all(axes.size(), [&](std::size_t i, snapshot::AxisSample& sample) noexcept {
    sample.cycle = line.cycle;
    sample.time_ns = line.time_ns;
    sample.axis = static_cast<std::uint16_t>(i);
    axes[i].fill(sample);
  });
}

}  // namespace driveline::ecat_master
