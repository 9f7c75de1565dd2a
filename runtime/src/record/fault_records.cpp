#include "record/fault_records.hpp"

#include <fmt/format.h>

#include <sstream>

#include "driveline/runtime/files/output_file.hpp"

namespace driveline::runtime {
namespace {

std::filesystem::path numbered(const std::filesystem::path& directory, std::size_t number) {
  return directory / (number == 1 ? "flight_recorder.csv" : fmt::format("flight_recorder.{}.csv", number));
}

/// Returns the labels of the columns.
std::vector<motion::FlightRecorder::AxisLabel> labels_of(const LineConfig& config) {
  std::vector<motion::FlightRecorder::AxisLabel> labels;
  for (const auto& axis : config.axes) {
    const auto& unit = motion::position_unit(axis);
    const bool si = unit.name == trajectory::si_unit(unit.kind);
    labels.push_back({axis.name, si ? nullptr : &unit, config.output.increments ? axis.increments_per_unit : 0.0});
  }
  return labels;
}

}  // namespace

FaultRecords::FaultRecords(const LineConfig& config, bool with_axes, bool in_background)
    : directory_(config.output.directory),
      axes_(with_axes ? labels_of(config) : std::vector<motion::FlightRecorder::AxisLabel>{}),
      in_background_(in_background),
      recorder_(axes_.size()) {}

std::filesystem::path FaultRecords::next_file() const {
  return numbered(directory_, files_.size() + 1);
}

void FaultRecords::note_fault() noexcept {
  // The recorder is frozen while a file is being written.
  if (writing_.valid() || files_.size() >= kMaxFiles || problem_) return;
  triggered_ = true;
  recorder_.trigger();
}

void FaultRecords::begin_writing() {
  if (files_.empty()) {
    // Remove the files of an earlier run, which could be mistaken for those of this one.
    std::error_code ignored;
    for (std::size_t number = 2; number <= kMaxFiles; ++number) {
      std::filesystem::remove(numbered(directory_, number), ignored);
    }
  }
  const auto policy = in_background_ ? std::launch::async : std::launch::deferred;
  writing_ = std::async(policy, [this, file = next_file()]() -> std::optional<Error> {
    std::ostringstream text;
    recorder_.write_csv(text, axes_);
    const auto done = write_file(file, text.str());
    return done ? std::nullopt : std::optional(done.error());
  });
}

std::optional<events::FaultRecorded> FaultRecords::end_writing() {
  problem_ = writing_.get();
  if (problem_) return std::nullopt;
  files_.push_back(next_file());
  const bool last = files_.size() == kMaxFiles;
  events::FaultRecorded recorded{recorder_.size(), files_.back(), last};
  triggered_ = false;
  if (!last) recorder_.rearm();
  return recorded;
}

std::optional<events::FaultRecorded> FaultRecords::poll() {
  if (triggered_ && recorder_.frozen() && !writing_.valid()) begin_writing();
  if (!writing_.valid()) return std::nullopt;
  const bool running = in_background_ && writing_.wait_for(std::chrono::seconds{0}) != std::future_status::ready;
  return running ? std::nullopt : end_writing();
}

std::vector<events::FaultRecorded> FaultRecords::finish() {
  std::vector<events::FaultRecorded> recorded;
  const auto end = [this, &recorded] {
    if (const auto one = end_writing()) recorded.push_back(*one);
  };
  if (writing_.valid()) end();
  if (!triggered_ || recorder_.size() == 0 || problem_) return recorded;
  begin_writing();
  end();
  return recorded;
}

}  // namespace driveline::runtime
