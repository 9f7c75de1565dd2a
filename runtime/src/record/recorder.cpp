#include "record/recorder.hpp"

#include <fmt/format.h>
#include <algorithm>
#include <cmath>
#include <iterator>
#include <string_view>

#include "driveline/rt/output_place.hpp"

namespace driveline::runtime {

void ErrorFigures::add(double error) noexcept {
  maximum = std::max(maximum, std::abs(error));
  sum_of_squares += error * error;
  ++samples;
}

double ErrorFigures::rms() const noexcept {
  return samples == 0 ? 0.0 : std::sqrt(sum_of_squares / static_cast<double>(samples));
}

/// The extremes are NaN until the first value; fmin() and fmax() skip NaN.
void Recorder::Extremes::add(double value) noexcept {
  least = std::fmin(least, value);
  greatest = std::fmax(greatest, value);
}

Recorder::Recorder(const std::vector<motion::AxisConfig>& axes, const std::optional<std::filesystem::path>& csv,
                   std::uint64_t every, bool increments, bool compensated)
    : errors_(axes.size()), every_(every), increments_(increments), compensated_(compensated), extremes_(axes.size()) {
  for (const auto& axis : axes) {
    columns_.push_back({axis.name, axis.linear(), &motion::position_unit(axis), axis.increments_per_unit});
  }
  if (!csv) return;
  csv_name_ = *csv;
  csv_.emplace(csv_name_);
  rows_.emplace(csv_name_.parent_path(), kMaxRows);
  if (auto opened = csv_->problem(); !opened) problem_ = opened.error();
}

double Recorder::path_error(const snapshot::AxisSample& sample) const noexcept {
  return compensated_ ? sample.following_error : sample.target_position - sample.actual_position;
}

/// Writes three columns for each axis first, then the less important ones. The first row shows which drives report a
/// following error and a position demand.
void Recorder::write_header(const std::vector<snapshot::AxisSample>& row) {
  auto& stream = csv_->stream();
  stream << "time[s]";
  const auto head = [&stream](const Column& column, std::string_view figure, std::string_view unit) {
    stream << fmt::format(",{}_{}[{}]", column.axis, figure, unit);
  };
  for (const auto& column : columns_) {
    for (const auto* figure : {"target", "actual", "following_error"}) head(column, figure, column.unit->name);
  }
  for (const auto& column : columns_) head(column, "torque", column.linear ? "N" : "Nm");
  for (const auto& column : columns_) {
    for (const auto* figure : {"following_error_min", "following_error_max"}) head(column, figure, column.unit->name);
  }
  for (std::size_t i = 0; i < columns_.size(); ++i) {
    if (!std::isnan(row[i].drive_following_error)) head(columns_[i], "drive_following_error", columns_[i].unit->name);
  }
  for (std::size_t i = 0; i < columns_.size(); ++i) {
    errors_[i].demand = !std::isnan(row[i].demand_position);
    if (errors_[i].demand) head(columns_[i], "demand", columns_[i].unit->name);
  }
  for (const auto& column : columns_) {
    if (compensated_) head(column, "commanded", column.unit->name);
  }
  for (const auto& column : columns_) {
    if (!increments_) break;
    for (const auto* figure : {"target", "actual", "following_error"}) head(column, figure, "increments");
  }
  stream << '\n';
}

/// Only cycles of a CAN bus have a load.
void Recorder::lines(std::span<const snapshot::LineSample> samples) {
  const auto begin = operation_begin_.load();
  for (const auto& sample : samples) {
    if (sample.bus_load <= 0.0F || sample.time_ns < begin || sample.time_ns >= operation_end_.load()) continue;
    const auto load = static_cast<double>(sample.bus_load);
    ++load_.samples;
    load_.mean += (load - load_.mean) / static_cast<double>(load_.samples);
    load_.maximum = std::max(load_.maximum, load);
  }
}

void Recorder::axes(std::span<const snapshot::AxisSample> samples) {
  const auto begin = operation_begin_.load();
  for (const auto& sample : samples) {
    if (sample.axis >= errors_.size()) continue;
    auto& error = errors_[sample.axis];
    const bool operating = sample.time_ns >= begin && sample.time_ns < operation_end_.load();
    if (sample.state == snapshot::AxisState::kUnavailable && operating) ++error.unavailable;
    if (operating) error.last = sample;
    if (sample.state == snapshot::AxisState::kOperationEnabled) {
      error.add(sample.following_error);
      error.path.add(path_error(sample));
      if (!std::isnan(sample.drive_following_error)) error.drive.add(sample.drive_following_error);
      extremes_[sample.axis].add(sample.following_error);
    }
    if (csv_) add_to_row(sample);
  }
}

/// Collects the samples of a cycle, which arrive one after another; a row is written when it is complete, and dropped
/// if samples are missing.
void Recorder::add_to_row(const snapshot::AxisSample& sample) {
  if (sample.axis == 0 || row_.empty() || row_.front().cycle != sample.cycle) row_.clear();
  if (sample.axis != row_.size()) return;
  row_.push_back(sample);
  if (row_.size() < errors_.size()) return;
  if (sample.cycle % every_ == 0) {
    write_row(row_);
    last_row_.clear();
  } else {
    std::swap(row_, last_row_);
  }
  row_.clear();
}

void Recorder::write_row(const std::vector<snapshot::AxisSample>& row) {
  if (!first_time_ns_) {
    first_time_ns_ = row.front().time_ns;
    write_header(row);
  }
  const double time_s = static_cast<double>(row.front().time_ns - *first_time_ns_) * 1e-9;
  fmt::memory_buffer text;
  fmt::format_to(std::back_inserter(text), "{:.6f}", time_s);
  const auto add = [&text](auto format, auto... values) {
    fmt::format_to(std::back_inserter(text), format, values...);
  };
  const auto shown = [this](std::size_t axis, double si) { return columns_[axis].unit->from_si(si); };
  for (std::size_t i = 0; i < row.size(); ++i) {
    add(FMT_STRING(",{:.7g},{:.7g},{:.4g}"), shown(i, row[i].target_position), shown(i, row[i].actual_position),
        shown(i, row[i].following_error));
  }
  for (const auto& sample : row) add(FMT_STRING(",{:.5g}"), sample.actual_torque);
  for (std::size_t i = 0; i < row.size(); ++i) {
    add(FMT_STRING(",{:.7g},{:.7g}"), shown(i, extremes_[i].least), shown(i, extremes_[i].greatest));
  }
  std::fill(extremes_.begin(), extremes_.end(), Extremes{});
  for (std::size_t i = 0; i < row.size(); ++i) {
    const double error = row[i].drive_following_error;
    if (!std::isnan(error)) add(FMT_STRING(",{:.4g}"), shown(i, error));
  }
  for (std::size_t i = 0; i < row.size(); ++i) {
    if (errors_[i].demand) add(FMT_STRING(",{:.7g}"), shown(i, row[i].demand_position));
  }
  for (std::size_t i = 0; compensated_ && i < row.size(); ++i)
    add(FMT_STRING(",{:.7g}"), shown(i, row[i].actual_position + path_error(row[i])));
  for (std::size_t i = 0; increments_ && i < row.size(); ++i) {
    const double scale = columns_[i].increments_per_unit;
    add(FMT_STRING(",{:.0f},{:.0f},{:.1f}"), row[i].target_position * scale, row[i].actual_position * scale,
        row[i].following_error * scale);
  }
  text.push_back('\n');
  rows_->add(time_s, std::string_view(text.data(), text.size()));
}

void Recorder::finish(const snapshot::DrainCounters&) {
  if (!csv_ || !csv_->is_open()) return;
  // Also write the cycles after the last row if one of them could contain the peak.
  const bool more = std::any_of(extremes_.begin(), extremes_.end(), [](const auto& e) { return !std::isnan(e.least); });
  if (more && !last_row_.empty()) write_row(last_row_);
  if (rows() == 0 || discarded_.load(std::memory_order_relaxed)) return csv_->discard();
  if (const auto error = rows_->write_to(csv_->stream())) {
    const Result<void> wrong =
        fail(ErrorKind::kMachine, rt::describe_output_error(csv_name_, error), csv_name_.string());
    problem_ = wrong.error();
    return csv_->discard();
  }
  if (auto completed = csv_->complete(); !completed) problem_ = completed.error();
}

}  // namespace driveline::runtime
