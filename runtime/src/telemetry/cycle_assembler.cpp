#include "telemetry/cycle_assembler.hpp"

#include <limits>

namespace driveline::runtime {

using snapshot::FeedLine;

void CycleAssembler::add(const snapshot::LineSample& sample) {
  lines_.push_back(snapshot::to_feed(sample));
  if (expected_ == 0) emit_lines_before(std::numeric_limits<std::uint64_t>::max());
  if (lines_.size() > kMaxWaiting) emit_lines_before(lines_.front().cycle + 1);
}

void CycleAssembler::add(const snapshot::AxisSample& sample) {
  if (!axes_.empty() && sample.cycle != cycle_) emit_axes();
  cycle_ = sample.cycle;
  axes_.push_back(snapshot::to_feed(sample));
  if (axes_.size() >= expected_) emit_axes();
}

void CycleAssembler::finish() {
  if (!axes_.empty()) emit_axes();
  emit_lines_before(std::numeric_limits<std::uint64_t>::max());
}

void CycleAssembler::emit_axes() {
  emit_lines_before(cycle_);
  FeedLine line;
  line.cycle = cycle_;
  if (!lines_.empty() && lines_.front().cycle == cycle_) {
    line = lines_.front();
    lines_.pop_front();
  }
  sink_(line, axes_);
  axes_.clear();
}

void CycleAssembler::emit_lines_before(std::uint64_t cycle) {
  while (!lines_.empty() && lines_.front().cycle < cycle) {
    sink_(lines_.front(), {});
    lines_.pop_front();
  }
}

}  // namespace driveline::runtime
