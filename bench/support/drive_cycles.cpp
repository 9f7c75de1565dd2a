#include "support/drive_cycles.hpp"

#include <algorithm>

#include "driveline/slaves/msd/device_layout.hpp"

namespace driveline::bench {

DriveCycles::DriveCycles(std::size_t drives, int cycles)
    : rig_(clock_, drives, cycles * LineRig::kPeriod + std::chrono::seconds{1}), valid_(new bool[drives]) {
  rig_.bring_up([&](ecat_master::CyclicCore& core) -> std::unique_ptr<motion::CycleRunner> {
    return std::make_unique<motion::InlineRunner>(core, clock_);
  });
  // Continue with the cycle number and time of the runner.
  cycle_ = static_cast<std::int64_t>(rig_.master().core()->cycles());
  time_ = clock_.now();
  std::fill_n(valid_.get(), drives, true);
  for (std::size_t i = 0; i < drives; ++i) devices_.push_back(&rig_.line().slave(i).device());
}

void DriveCycles::prepare(std::size_t batch) {
  outputs_.resize(batch);
  for (auto& image : outputs_) {
    rig_.motion().update(cycle_++, rig_.master().core()->image().outputs());
    image.assign(rig_.master().core()->image().outputs().begin(), rig_.master().core()->image().outputs().end());
  }
}

void DriveCycles::execute() {
  for (const auto& image : outputs_) step(image);
}

void DriveCycles::read_inputs() {
  const std::span<const bool> valid(valid_.get(), rig_.line().size());
  rig_.motion().read_inputs(rig_.master().core()->image().inputs(), valid, valid);
}

void DriveCycles::step(std::span<const std::byte> outputs) {
  time_ += LineRig::kPeriod;
  auto& image = rig_.master().core()->image();
  const auto inputs = image.inputs();
  const auto places = image.places();
  for (std::size_t i = 0; i < places.size(); ++i) {
    auto& drive = *devices_[i];
    const auto& place = places[i];
    drive.write_outputs(slaves::msd::kOutputsSyncManager, outputs.subspan(place.output_offset, place.output_bytes));
    drive.advance(time_);
    drive.read_inputs(slaves::msd::kInputsSyncManager, inputs.subspan(place.input_offset, place.input_bytes));
  }
}

}  // namespace driveline::bench
