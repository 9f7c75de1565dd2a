#include "driveline/slaves/mc7000/program.hpp"

#include <algorithm>

namespace driveline::slaves::mc7000 {
namespace {

auto place_of(auto& records, std::uint16_t number) noexcept {
  return std::ranges::lower_bound(records, number, {}, &Record::number);
}

}  // namespace

void Program::put(const Record& record) {
  const auto place = place_of(records_, record.number);
  if (place != records_.end() && place->number == record.number) {
    *place = record;
  } else {
    records_.insert(place, record);
  }
}

std::optional<std::size_t> Program::find(std::uint16_t number) const noexcept {
  const auto place = place_of(records_, number);
  if (place == records_.end() || place->number != number) return std::nullopt;
  return static_cast<std::size_t>(place - records_.begin());
}

std::optional<std::uint16_t> Program::first_lost_jump() const noexcept {
  for (const auto& record : records_) {
    if (record.command == Command::kJump && !find(record.target)) return record.number;
  }
  return std::nullopt;
}

}  // namespace driveline::slaves::mc7000
