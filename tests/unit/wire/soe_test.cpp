#include "driveline/wire/soe.hpp"

#include <gtest/gtest.h>

#include <set>
#include <string>
#include <vector>

/// Codes, numbers and texts of SoE, typed a second time.
namespace driveline::wire {
namespace {

std::string text_of(std::uint16_t raw) {
  const auto text = Idn{raw}.text();
  return {text.begin(), text.end()};
}

TEST(SoeIdn, TextBothWays) {
  EXPECT_EQ(text_of(0x0018), "S-0-0024");
  EXPECT_EQ(text_of(0x84D2), "P-0-1234");
  EXPECT_EQ(text_of(0x7FFF), "S-7-4095");
  EXPECT_EQ(Idn::from_text("S-0-0024"), Idn{0x0018});
  EXPECT_EQ(Idn::from_text("P-0-1234"), Idn{0x84D2});
  EXPECT_EQ(Idn::from_text("s-7-5"), Idn{0x7005});
  for (unsigned raw = 0; raw <= 0xFFFF; ++raw) {
    const auto text = text_of(static_cast<std::uint16_t>(raw));
    ASSERT_EQ(Idn::from_text(text), Idn{static_cast<std::uint16_t>(raw)}) << text;
  }
}

TEST(SoeIdn, OtherTextsAreNone) {
  for (const auto* text : {"", "S", "S-0-", "S-8-0001", "X-0-0001", "S-0-4096", "S-0-00001", "S-0-00a1", "S0-00001",
                           "S-0+0001", "S-0--001", "S-0-0001 "}) {
    EXPECT_FALSE(Idn::from_text(text)) << text;
  }
}

TEST(SoeError, EveryCodeHasATextOfItsOwn) {
  const std::vector<std::uint16_t> codes{0x1001, 0x1009, 0x2001, 0x2002, 0x2003, 0x2004, 0x2005, 0x3002, 0x3003, 0x3004,
                                         0x3005, 0x4001, 0x4002, 0x4003, 0x4004, 0x4005, 0x5001, 0x5002, 0x5003, 0x5004,
                                         0x5005, 0x6001, 0x6002, 0x6003, 0x6004, 0x6005, 0x7002, 0x7003, 0x7004, 0x7005,
                                         0x7006, 0x7007, 0x7008, 0x7009, 0x700A, 0x700B, 0x700C, 0x700D, 0x7010, 0x7011,
                                         0x7012, 0x7013, 0x7014, 0x8001, 0x8002, 0x8004, 0x800A, 0x800B, 0x800C};
  std::set<std::string_view> texts;
  for (const auto code : codes) EXPECT_TRUE(texts.insert(to_text(static_cast<SoeError>(code))).second) << code;
  EXPECT_EQ(texts.count("unknown SoE error"), 0U);
  EXPECT_EQ(kSoeErrorTexts.size(), codes.size());
  for (const auto code : {0x0000, 0x1000, 0x7001, 0x700E, 0x800D, 0xFFFF}) {
    EXPECT_EQ(to_text(static_cast<SoeError>(code)), "unknown SoE error") << code;
  }
}

TEST(SoeOpCode, CodesOfTheStandard) {
  EXPECT_EQ(static_cast<int>(SoeOpCode::kReadRequest), 1);
  EXPECT_EQ(static_cast<int>(SoeOpCode::kReadResponse), 2);
  EXPECT_EQ(static_cast<int>(SoeOpCode::kWriteRequest), 3);
  EXPECT_EQ(static_cast<int>(SoeOpCode::kWriteResponse), 4);
  EXPECT_EQ(static_cast<int>(SoeOpCode::kNotification), 5);
  EXPECT_EQ(static_cast<int>(SoeOpCode::kEmergency), 6);
}

TEST(SoeElement, AreBitsInTheirOrder) {
  unsigned bit = 1;
  for (const auto element : kSoeElements) {
    EXPECT_EQ(static_cast<unsigned>(element), bit);
    bit <<= 1;
  }
  const auto set = SoeElement::kName | SoeElement::kValue;
  EXPECT_EQ(set.bits, 0x42);
  EXPECT_EQ(set.count(), 2);
  EXPECT_TRUE(set.has(SoeElement::kName));
  EXPECT_FALSE(set.has(SoeElement::kUnit));
}

TEST(SoeAttribute, SizesAndReservedBits) {
  for (std::uint8_t code = 0; code < 4; ++code) {
    EXPECT_EQ((SoeAttribute{.length_code = code}.element_size()), std::size_t{1} << code);
  }
  constexpr std::array kReserved{std::byte{0}, std::byte{0}, std::byte{0x80}, std::byte{0x80}};
  EXPECT_EQ(SoeAttribute::decode(kReserved), (SoeAttribute{0, 0, false, false, SoeDisplay::kBinary}));
}

}  // namespace
}  // namespace driveline::wire
