#include "text/seven_segments.hpp"

#include <string_view>

namespace driveline::cli {
namespace {

/// Segments as bits: a (top) 0, b 1, c 2, d (bottom) 3, e 4, f 5, g (middle) 6.
constexpr std::array<std::uint8_t, 10> kDigits = {0x3F, 0x06, 0x5B, 0x4F, 0x66, 0x6D, 0x7D, 0x07, 0x7F, 0x6F};
constexpr std::uint8_t kE = 0x79;
constexpr std::uint8_t kR = 0x50;

int segments_of(char symbol) {
  if (symbol >= '0' && symbol <= '9') return kDigits[static_cast<std::size_t>(symbol - '0')];
  switch (symbol) {
    case 'S':
      return kDigits[5];
    case 'E':
      return kE;
    case 'r':
      return kR;
    case ' ':
      return 0;
    default:
      return -1;
  }
}

/// Draws a digit in three rows of three characters, plus one for the decimal point.
std::array<std::string, 3> draw_digit(const slaves::msd::Digit& digit) {
  const int segments = segments_of(digit.symbol);
  if (segments < 0) return {"    ", std::string(" ") + digit.symbol + "  ", digit.point ? "   ." : "    "};
  const auto lit = [segments](unsigned bit, char symbol) {
    return (static_cast<unsigned>(segments) >> bit & 1U) != 0 ? symbol : ' ';
  };
  return {std::string{' ', lit(0, '_'), ' ', ' '}, std::string{lit(5, '|'), lit(6, '_'), lit(1, '|'), ' '},
          std::string{lit(4, '|'), lit(3, '_'), lit(2, '|'), digit.point ? '.' : ' '}};
}

}  // namespace

std::array<std::string, 3> draw_display(const slaves::msd::DisplayFrame& frame) {
  auto rows = draw_digit(frame.first);
  const auto second = draw_digit(frame.second);
  for (std::size_t i = 0; i < rows.size(); ++i) rows[i] += " " + second[i];
  return rows;
}

}  // namespace driveline::cli
