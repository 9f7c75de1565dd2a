#include "driveline/canopen_wire/frame.hpp"

#include <gtest/gtest.h>

#include "driveline/canopen_wire/cob_id.hpp"
#include "support/bytes.hpp"

namespace driveline::canopen {
namespace {

using bytes_test::hex;

// C1: base and extended identifiers, 0 to 8 bytes, data and remote frames.
TEST(CanFrame, HasAtMostEightBytes) {
  const auto frame = Frame::of(0x345, hex("01 02 03 04 05 06 07 08 09"));
  EXPECT_EQ(frame.length, 8);
  EXPECT_EQ(bytes_test::copy_of(frame.payload()), hex("01 02 03 04 05 06 07 08"));
  EXPECT_TRUE(frame.valid());
}

TEST(CanFrame, ARemoteFrameHasALengthAndNoData) {  // python-can #2091: remote frames became empty data frames
  const auto frame = Frame::remote({0x70A, false}, 5);
  EXPECT_EQ(frame.length, 5);
  EXPECT_TRUE(frame.payload().empty());
  EXPECT_TRUE(frame.valid());
  EXPECT_NE(frame, Frame::of(0x70A, {}));
}

TEST(CanFrame, IdentifiersAndLengthsOutOfRangeAreInvalid) {
  struct Row {
    Identifier identifier;
    std::uint8_t length;
    bool valid;
  };
  for (const auto& row : std::initializer_list<Row>{{{0x7FF, false}, 8, true},
                                                    {{0x800, false}, 2, false},
                                                    {{0x7FF, true}, 0, true},
                                                    {{0x1FFF'FFFF, true}, 3, true},
                                                    {{0x2000'0000, true}, 3, false},
                                                    {{0x123, false}, 9, false}}) {
    const Frame frame{row.identifier, FrameKind::kData, row.length, {}};
    EXPECT_EQ(frame.valid(), row.valid) << std::hex << row.identifier.value;
    EXPECT_LE(frame.payload().size(), 8U);
  }
  EXPECT_FALSE((Frame{{0x123, false}, FrameKind::kError, 0, {}}.valid()));
}

// C3: lowest identifier; base before extended; data before remote frame of the same identifier.
TEST(CanFrame, ArbitrationOrder) {
  const std::vector<Frame> in_order{
      Frame::of(0x000, {}),
      Frame::of(0x080, {}),
      Frame::of(Identifier{0x080 << 18, true}, {}),
      Frame::of(Identifier{0x080 << 18 | 5, true}, {}),
      Frame::remote({0x080 << 18 | 5, true}, 2),
      Frame::of(Identifier{0x080 << 18 | 6, true}, {}),
      Frame::of(0x081, {}),
      Frame::remote({0x081, false}, 0),
      Frame::of(Identifier{0x081 << 18, true}, {}),
      Frame::of(0x7FF, {}),
      Frame::of(Identifier{0x1FFF'FFFF, true}, {}),
  };
  for (std::size_t i = 1; i < in_order.size(); ++i) {
    EXPECT_LT(arbitration_field(in_order[i - 1]), arbitration_field(in_order[i])) << i;
  }
}

TEST(CobId, BitsAndIdentifier) {
  EXPECT_EQ((CobId{0x4000'0185}.identifier()), (Identifier{0x185, false}));
  EXPECT_EQ((CobId{0xA123'4567}.identifier()), (Identifier{0x0123'4567, true}));
  EXPECT_TRUE((CobId{0x8000'0185}.invalid()));
  EXPECT_FALSE((CobId{0x4000'0185}.invalid()));
  EXPECT_TRUE((CobId{0xC000'0185}.well_formed()));
  EXPECT_FALSE((CobId{0x0000'0985}.well_formed()));
  EXPECT_TRUE((CobId{0x2000'0985}.well_formed()));
}

// CiA 301 Table 40, typed a second time.
TEST(CobId, RestrictedIdentifiers) {
  for (const std::uint32_t value : {0x000U, 0x07FU, 0x101U, 0x180U, 0x581U, 0x5FFU, 0x601U, 0x67FU, 0x6E0U, 0x6FFU,
                                    0x701U, 0x77FU, 0x780U, 0x7FFU}) {
    EXPECT_TRUE(is_restricted({value, false})) << std::hex << value;
    EXPECT_FALSE(is_restricted({value, true})) << std::hex << value;
  }
  for (const std::uint32_t value : {0x080U, 0x100U, 0x181U, 0x57FU, 0x580U, 0x600U, 0x680U, 0x6DFU}) {
    EXPECT_FALSE(is_restricted({value, false})) << std::hex << value;
  }
}

}  // namespace
}  // namespace driveline::canopen
