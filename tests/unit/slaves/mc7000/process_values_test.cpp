#include "driveline/slaves/mc7000/process_values.hpp"

#include <gmock/gmock.h>

#include <array>
#include <ostream>

namespace driveline::slaves::mc7000 {
namespace {

struct PdoCase {
  const char* name;
  std::array<int, 8> bytes;
  PosModLocation location;
  std::int32_t h98;
  int m90;
};
void PrintTo(const PdoCase& one, std::ostream* out) {
  *out << one.name;
}

class RxPdo21 : public testing::TestWithParam<PdoCase> {};

TEST_P(RxPdo21, WritesWhatItsModeSays) {
  ProcessValues values;
  values.set_variable(98, -5);
  values.set_flag(90, 3);
  std::array<std::byte, ProcessValues::kRxPdo21Size> pdo{};
  for (std::size_t i = 0; i < pdo.size(); ++i) pdo[i] = static_cast<std::byte>(GetParam().bytes[i]);
  EXPECT_EQ(values.receive_rx_pdo21(pdo), GetParam().location);
  EXPECT_EQ(values.variable(98), GetParam().h98);
  EXPECT_EQ(values.flag(90), GetParam().m90);
  EXPECT_EQ(values.variable(0x5A), 0) << "the field of the flag is none of a variable";
  EXPECT_EQ(values.flag(0x62), 0) << "the field of the variable is none of a flag";
}

INSTANTIATE_TEST_SUITE_P(
    Modes, RxPdo21,
    testing::Values(
        PdoCase{"both", {0xFF, 0x62, 0x00, 0x00, 0x0A, 0x00, 0x5A, 0x01}, PosModLocation::kNone, 655360, 1},
        PdoCase{"variable", {0xF0, 0x62, 0x64, 0x00, 0x00, 0x00, 0x5A, 0x01}, PosModLocation::kNone, 100, 3},
        PdoCase{"negative", {0xF0, 0x62, 0xFE, 0xFF, 0xFF, 0xFF, 0x5A, 0x01}, PosModLocation::kNone, -2, 3},
        PdoCase{"flag", {0x0F, 0x62, 0x64, 0x00, 0x00, 0x00, 0x5A, 0x00}, PosModLocation::kNone, -5, 0},
        PdoCase{"no mode", {0xF1, 0x62, 0x64, 0x00, 0x00, 0x00, 0x5A, 0x00}, PosModLocation::kNone, -5, 3},
        PdoCase{"no variable", {0xFF, 0x64, 0x64, 0x00, 0x00, 0x00, 0x5A, 0x00}, PosModLocation::kIndexOverflow, -5, 3},
        PdoCase{"no flag", {0xFF, 0x62, 0x64, 0x00, 0x00, 0x00, 0x64, 0x00}, PosModLocation::kIndexOverflow, -5, 3},
        PdoCase{"unused field", {0xF0, 0x62, 0x64, 0x00, 0x00, 0x00, 0xFF, 0x00}, PosModLocation::kNone, 100, 3}));

TEST(ProcessValues, HaveTheirLastFieldAt99) {
  ProcessValues values;
  std::array<std::byte, ProcessValues::kRxPdo21Size> pdo{};
  pdo[0] = std::byte{0xFF};
  pdo[1] = pdo[6] = std::byte{0x63};
  pdo[2] = pdo[7] = std::byte{5};
  EXPECT_EQ(values.receive_rx_pdo21(pdo), PosModLocation::kNone);
  EXPECT_EQ(values.variable(99), 5);
  EXPECT_EQ(values.flag(99), 5);
  EXPECT_EQ(values.value_of({.variable = true, .value = 99}), 5);
  EXPECT_EQ(values.value_of({.variable = false, .value = 99}), 99);
}

struct LocationCase {
  int number;
  const char* text;
};

// MC7000 manual, lines 1575-1600.
TEST(PosModLocations, HaveATextExceptThoseThatAreNotUsed) {
  for (int number = 210; number <= 239; ++number) {
    const bool unused =
        (number >= 227 && number <= 229) || number == 231 || number == 233 || number == 234 || number > 235;
    EXPECT_EQ(text_of(static_cast<PosModLocation>(number)).empty(), unused) << number;
  }
  for (const auto& one : {LocationCase{214, "no reference point"},
                          {216, "selected program is not there"},
                          {217, "jump to a record that is not there"},
                          {224, "feed is held"},
                          {235, "command not allowed while the axis moves"}}) {
    EXPECT_EQ(text_of(static_cast<PosModLocation>(one.number)), one.text);
  }
}

}  // namespace
}  // namespace driveline::slaves::mc7000
