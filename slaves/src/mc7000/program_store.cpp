#include "driveline/slaves/mc7000/program_store.hpp"

#include <utility>

namespace driveline::slaves::mc7000 {

tl::expected<void, LineError> ProgramStore::execute(std::string_view line) {
  if (saving()) return tl::unexpected(LineError::kSaving);
  const auto parsed = parse_line(line);
  if (!parsed) return tl::unexpected(parsed.error());
  return std::visit([this](const auto& content) { return run(content); }, *parsed);
}

tl::expected<void, LineError> ProgramStore::run(const OpenProgram& line) {
  if (programs_[line.number]) return tl::unexpected(LineError::kProgramExists);
  download_ = Download{.number = line.number, .content = {.name = line.name, .program = {}}};
  return {};
}

tl::expected<void, LineError> ProgramStore::run(const DeleteProgram& line) {
  if (download_) return tl::unexpected(LineError::kOpenProgram);
  if (!programs_[line.number]) return tl::unexpected(LineError::kProgramMissing);
  programs_[line.number].reset();
  return {};
}

tl::expected<void, LineError> ProgramStore::run(const SavePrograms& /*line*/) {
  if (download_) return tl::unexpected(LineError::kOpenProgram);
  saving_left_ = kSaveTime;
  return {};
}

tl::expected<void, LineError> ProgramStore::run(const EndProgram& /*line*/) {
  if (!download_) return tl::unexpected(LineError::kNoOpenProgram);
  programs_[download_->number] = std::make_shared<const Stored>(std::move(download_->content));
  download_.reset();
  return {};
}

tl::expected<void, LineError> ProgramStore::run(const Record& line) {
  if (!download_) return tl::unexpected(LineError::kNoOpenProgram);
  download_->content.program.put(line);
  return {};
}

void ProgramStore::advance(std::chrono::nanoseconds elapsed) noexcept {
  if (!saving()) return;
  saving_left_ -= elapsed;
  if (!saving()) flash_ = programs_;
}

void ProgramStore::restart() {
  drop_download();
  saving_left_ = {};
  programs_ = flash_;
}

const Program* ProgramStore::program(std::uint8_t number) const noexcept {
  return number < kPrograms && programs_[number] ? &programs_[number]->program : nullptr;
}

std::string_view ProgramStore::name(std::uint8_t number) const noexcept {
  return number < kPrograms && programs_[number] ? std::string_view(programs_[number]->name) : std::string_view();
}

}  // namespace driveline::slaves::mc7000
