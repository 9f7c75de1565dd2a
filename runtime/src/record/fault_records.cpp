#include "record/fault_records.hpp"

#include <fmt/format.h>

#include <sstream>

#include "driveline/runtime/files/output_file.hpp"

namespace driveline::runtime {
namespace {

std::filesystem::path numbered(const std::filesystem::path& directory, std::size_t number) {
  return directory / (number == 1 ? "flight_recorder.csv" : fmt::format("flight_recorder.{}.csv", number));
}

}  // namespace

FaultRecords::FaultRecords(std::filesystem::path directory, std::vector<ecat_master::FlightRecorder::AxisLabel> axes,
                           bool in_background)
    : directory_(std::move(directory)),
      axes_(std::move(axes)),
      in_background_(in_background),
      recorder_(axes_.size()) {}

std::filesystem::path FaultRecords::next_file() const {
  return numbered(directory_, files_.size() + 1);
}

void FaultRecords::note_fault() noexcept {
  // The recorder is frozen while a file is being written.
  if (writing_.valid() || files_.size() >= kMaxFiles || !problem_.empty()) return;
  triggered_ = true;
  recorder_.trigger();
}

void FaultRecords::begin_writing() {
  if (files_.empty()) {
    // Removes the files of an earlier run, which could be mistaken for those of this one.
    std::error_code ignored;
    for (std::size_t number = 2; number <= kMaxFiles; ++number) {
      std::filesystem::remove(numbered(directory_, number), ignored);
    }
  }
  const auto policy = in_background_ ? std::launch::async : std::launch::deferred;
  writing_ = std::async(policy, [this, file = next_file()]() -> std::optional<std::string> {
    std::ostringstream text;
    recorder_.write_csv(text, axes_);
    const auto done = write_file(file, text.str());
    return done ? std::nullopt : std::optional(describe(done.error()));
  });
}

void FaultRecords::end_writing(std::vector<std::string>& told) {
  if (auto reason = writing_.get()) {
    problem_ = std::move(*reason);
    return;
  }
  files_.push_back(next_file());
  told.push_back(fmt::format("the {} cycles around the fault are in {}{}", recorder_.size(), files_.back().string(),
                             files_.size() == kMaxFiles ? "; those around further faults are not kept" : ""));
  triggered_ = false;
  if (files_.size() < kMaxFiles) recorder_.rearm();
}

std::vector<std::string> FaultRecords::poll() {
  std::vector<std::string> told;
  if (triggered_ && recorder_.frozen() && !writing_.valid()) begin_writing();
  if (!writing_.valid()) return told;
  const bool running = in_background_ && writing_.wait_for(std::chrono::seconds{0}) != std::future_status::ready;
  if (!running) end_writing(told);
  return told;
}

std::vector<std::string> FaultRecords::finish() {
  std::vector<std::string> told;
  if (writing_.valid()) end_writing(told);
  if (!triggered_ || recorder_.size() == 0 || !problem_.empty()) return told;
  begin_writing();
  end_writing(told);
  return told;
}

}  // namespace driveline::runtime
