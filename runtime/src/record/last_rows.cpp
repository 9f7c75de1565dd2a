#include "record/last_rows.hpp"

namespace driveline::runtime {

void LastRows::add(double time_s, std::string_view row) {
  if (parts_.empty() || parts_.back().rows == part_) {
    if (parts_.size() == kParts) {
      rows_ -= parts_.front().rows;
      parts_.pop_front();
      dropped_ = true;
    }
    parts_.emplace_back(folder_, time_s);
  }
  auto& newest = parts_.back();
  newest.file.write(row);
  ++newest.rows;
  ++rows_;
}

std::optional<double> LastRows::begins_at_s() const noexcept {
  return dropped_ ? std::optional(parts_.front().begin_s) : std::nullopt;
}

std::error_code LastRows::write_to(std::ostream& to) {
  for (auto& part : parts_) {
    part.file.copy_to(to);
    if (part.file.error()) return part.file.error();
  }
  return {};
}

}  // namespace driveline::runtime
