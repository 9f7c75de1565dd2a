#include <gtest/gtest.h>

#include <limits>

#include "wire_type_lists.hpp"

/// Types made from the raw value of a register. Their buffer is the integer itself, so every value is tried instead of
/// short buffers.
namespace driveline::wire::test {
namespace {

template <typename T>
class RegisterType : public ::testing::Test {
 protected:
  using Raw = typename RegisterSample<T>::Raw;
  static Raw raw_of(std::string_view hex) { return bytes::load_le<Raw>(bytes_of(hex)); }
};

using Types = AsTestTypes<RegisterTypes>::Type;
TYPED_TEST_SUITE(RegisterType, Types);

TYPED_TEST(RegisterType, EncodesToGoldenBytes) {
  ASSERT_FALSE(RegisterSample<TypeParam>::golden().empty());
  for (const auto& golden : RegisterSample<TypeParam>::golden()) {
    EXPECT_EQ(golden.value.raw(), this->raw_of(golden.hex)) << golden.provenance;
  }
}

TYPED_TEST(RegisterType, DecodesGoldenBytes) {
  for (const auto& golden : RegisterSample<TypeParam>::golden()) {
    EXPECT_EQ(TypeParam::from_raw(this->raw_of(golden.hex)), golden.value) << golden.provenance;
  }
}

TYPED_TEST(RegisterType, EveryRawValueSurvivesExceptReservedBits) {
  using Value = typename RegisterSample<TypeParam>::Raw;
  for (unsigned raw = 0; raw <= std::numeric_limits<Value>::max(); ++raw) {
    const auto value = TypeParam::from_raw(static_cast<Value>(raw));
    ASSERT_EQ(value.raw(), raw & RegisterSample<TypeParam>::kMeaning) << raw;
    ASSERT_EQ(TypeParam::from_raw(value.raw()), value) << raw;
  }
}

TEST(AlState, UnknownStatesAreKept) {
  for (unsigned raw = 0; raw < 16; ++raw) {
    const auto state = AlControl::from_raw(static_cast<std::uint16_t>(raw)).state;
    EXPECT_EQ(static_cast<unsigned>(state), raw);
    const bool known = raw == 1 || raw == 2 || raw == 3 || raw == 4 || raw == 8;
    EXPECT_EQ(is_known(state), known) << raw;
    EXPECT_EQ(to_text(state) != "?", known || raw == 0) << raw;
  }
}

TEST(AlState, TextsAreThoseOfTheTools) {
  EXPECT_EQ(to_text(AlState::kInit), "INIT");
  EXPECT_EQ(to_text(AlState::kPreOp), "PREOP");
  EXPECT_EQ(to_text(AlState::kBootstrap), "BOOT");
  EXPECT_EQ(to_text(AlState::kSafeOp), "SAFEOP");
  EXPECT_EQ(to_text(AlState::kOp), "OP");
}

TEST(DlStatus, EachPortHasItsBits) {
  // ETG.1000.4 Table 35: link in bits 4-7, then loop and communication in pairs from bit 8.
  constexpr std::array<std::uint16_t, 4> kLink{0x0010, 0x0020, 0x0040, 0x0080};
  constexpr std::array<std::uint16_t, 4> kLoop{0x0100, 0x0400, 0x1000, 0x4000};
  constexpr std::array<std::uint16_t, 4> kCommunication{0x0200, 0x0800, 0x2000, 0x8000};
  for (std::size_t port = 0; port < 4; ++port) {
    const auto status = [&](std::uint16_t raw) { return DlStatus::from_raw(raw).ports[port]; };
    EXPECT_EQ(status(kLink[port]), (DlStatus::Port{true, false, false}));
    EXPECT_EQ(status(kLoop[port]), (DlStatus::Port{false, true, false}));
    EXPECT_EQ(status(kCommunication[port]), (DlStatus::Port{false, false, true}));
    EXPECT_EQ(status(static_cast<std::uint16_t>(~(kLink[port] | kLoop[port] | kCommunication[port]))),
              (DlStatus::Port{false, false, false}));
  }
}

}  // namespace
}  // namespace driveline::wire::test
