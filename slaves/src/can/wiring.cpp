#include "driveline/slaves/can/wiring.hpp"

#include <algorithm>
#include <array>

namespace driveline::slaves::can {
namespace {

struct CableLength {
  std::uint32_t bit_rate;
  double length_m;
};

/// MSD manual 4.6.3, Table 4.8.
constexpr std::array kCableLengths{CableLength{1'000'000, 25}, CableLength{500'000, 100}, CableLength{250'000, 250},
                                   CableLength{125'000, 500},  CableLength{50'000, 1000}, CableLength{20'000, 2500}};

}  // namespace

double longest_cable_m(std::uint32_t bit_rate) noexcept {
  const auto* row = std::find_if(kCableLengths.begin(), kCableLengths.end(),
                                 [=](const CableLength& one) { return one.bit_rate <= bit_rate; });
  if (row == kCableLengths.end()) return kCableLengths.back().length_m;
  // Between two rates of the table the shorter cable of the faster one counts.
  return row->bit_rate == bit_rate || row == kCableLengths.begin() ? row->length_m : std::prev(row)->length_m;
}

std::uint32_t highest_bit_rate(unsigned terminators) noexcept {
  constexpr std::array<std::uint32_t, 3> kRates{20'000, 125'000, 1'000'000};
  return kRates[std::min<std::size_t>(terminators, kRates.size() - 1)];
}

}  // namespace driveline::slaves::can
