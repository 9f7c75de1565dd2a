#include "driveline/motion/cycle/flight_recorder.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <ostream>

namespace driveline::motion {

FlightRecorder::FlightRecorder(std::size_t axes, std::size_t cycles)
    : axes_(axes), lines_(std::max<std::size_t>(cycles, 1)), axis_records_(lines_.size() * axes) {}

void FlightRecorder::record(const snapshot::LineSample& line, std::span<const Axis> axes) noexcept {
  // Acquire: the values set by rearm() must be visible.
  if (frozen_.load(std::memory_order_acquire)) return;
  lines_[next_] = line;
  const auto records = std::span(axis_records_).subspan(next_ * axes_, axes_);
  for (std::size_t i = 0; i < std::min(axes_, axes.size()); ++i) {
    snapshot::AxisSample sample;
    axes[i].fill(sample);
    auto& record = records[i];
    record.target_position = sample.target_position;
    record.actual_position = sample.actual_position;
    record.target_velocity = static_cast<float>(sample.target_velocity);
    record.actual_velocity = static_cast<float>(sample.actual_velocity);
    record.target_torque = static_cast<float>(sample.target_torque);
    record.actual_torque = static_cast<float>(sample.actual_torque);
    record.following_error = static_cast<float>(sample.following_error);
    record.control_word = sample.control_word;
    record.status_word = sample.status_word;
    record.mode = sample.mode;
    record.state = sample.state;
  }
  next_ = (next_ + 1) % lines_.size();
  size_ = std::min(size_ + 1, lines_.size());
  if (triggered_.load(std::memory_order_acquire) && ++after_ >= std::min(kCyclesAfter, lines_.size())) {
    frozen_.store(true, std::memory_order_release);
  }
}

/// Slot of the record that is `age` cycles older than the newest.
std::size_t FlightRecorder::slot(std::size_t age) const noexcept {
  return (next_ + lines_.size() - 1 - age) % lines_.size();
}

void FlightRecorder::write_header(std::ostream& out, std::span<const AxisLabel> axes, bool clocks, bool load) const {
  out << "cycle,time_ns,wake_latency_ns,cost_ns,round_trip_ns,missed_periods,frames_received,working_counter,"
         "expected_working_counter";
  if (clocks) out << ",dc_locked,dc_difference_ns";
  if (load) out << ",bus_load,bus_send_errors,bus_receive_errors";
  for (const auto& axis : axes) {
    for (const char* figure : {"control_word", "status_word", "mode", "available"})
      out << ',' << axis.name << '.' << figure;
    const auto in = [&axis](std::string_view per) {
      return axis.unit != nullptr ? fmt::format("[{}{}]", axis.unit->name, per) : std::string{};
    };
    for (const char* figure : {"target_position", "actual_position"})
      out << ',' << axis.name << '.' << figure << in("");
    for (const char* figure : {"target_velocity", "actual_velocity"})
      out << ',' << axis.name << '.' << figure << in("/s");
    for (const char* figure : {"target_torque", "actual_torque"}) out << ',' << axis.name << '.' << figure;
    out << ',' << axis.name << ".following_error" << in("");
  }
  for (const auto& axis : axes) {
    if (!(axis.increments_per_unit > 0.0)) continue;
    for (const char* figure : {"target_position", "actual_position", "following_error"})
      out << ',' << axis.name << '.' << figure << "[increments]";
  }
  out << '\n';
}

void FlightRecorder::write_csv(std::ostream& out, std::span<const AxisLabel> axes) const {
  // Without distributed clocks both keep their initial values.
  const bool clocks = std::any_of(lines_.begin(), lines_.end(),
                                  [](const auto& line) { return line.dc_locked || line.dc_difference_ns != 0; });
  const bool load = std::any_of(lines_.begin(), lines_.end(), [](const auto& line) { return line.bus_load > 0.0F; });
  std::vector<AxisLabel> labels(axes.begin(), axes.begin() + static_cast<std::ptrdiff_t>(std::min(axes.size(), axes_)));
  while (labels.size() < axes_) labels.push_back({fmt::format("axis{}", labels.size())});
  write_header(out, labels, clocks, load);
  for (std::size_t age = size_; age-- > 0;) {
    const auto& line = lines_[slot(age)];
    out << fmt::format("{},{},{},{},{},{},{},{},{}", line.cycle, line.time_ns, line.wake_latency_ns, line.cost_ns,
                       line.round_trip_ns, line.missed_periods, line.frame_received ? 1 : 0, line.working_counter,
                       line.expected_working_counter);
    if (clocks) out << fmt::format(",{},{}", line.dc_locked ? 1 : 0, line.dc_difference_ns);
    if (load) out << fmt::format(",{:.4f},{},{}", line.bus_load, line.bus_send_errors, line.bus_receive_errors);
    const auto records = std::span(axis_records_).subspan(slot(age) * axes_, axes_);
    for (std::size_t i = 0; i < axes_; ++i) {
      const auto& axis = records[i];
      const auto unit = [shown = labels[i].unit](double si) { return shown != nullptr ? shown->from_si(si) : si; };
      out << fmt::format(",0x{:04X},0x{:04X},{},{},{:.9g},{:.9g},{:.6g},{:.6g},{:.6g},{:.6g},{:.6g}", axis.control_word,
                         axis.status_word, axis.mode, axis.state == snapshot::AxisState::kUnavailable ? 0 : 1,
                         unit(axis.target_position), unit(axis.actual_position), unit(axis.target_velocity),
                         unit(axis.actual_velocity), axis.target_torque, axis.actual_torque,
                         unit(axis.following_error));
    }
    for (std::size_t i = 0; i < axes_; ++i) {
      const double scale = labels[i].increments_per_unit;
      if (!(scale > 0.0)) continue;
      out << fmt::format(",{:.0f},{:.0f},{:.0f}", records[i].target_position * scale,
                         records[i].actual_position * scale, static_cast<double>(records[i].following_error) * scale);
    }
    out << '\n';
  }
}

void FlightRecorder::rearm() noexcept {
  next_ = 0;
  size_ = 0;
  after_ = 0;
  triggered_.store(false, std::memory_order_relaxed);
  frozen_.store(false, std::memory_order_release);
}

}  // namespace driveline::motion
