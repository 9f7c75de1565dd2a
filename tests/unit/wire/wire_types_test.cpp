#include <gtest/gtest.h>

#include "support/must.hpp"
#include "wire_type_lists.hpp"

/// The four checks of each structure: golden bytes from other sources, their decoding, round trip, short buffers.
namespace driveline::wire::test {
namespace {

template <typename T>
class WireType : public ::testing::Test {
 protected:
  static Bytes encoded(const T& value) {
    std::array<std::byte, T::kSize> out{};
    out.fill(std::byte{0xA5});
    value.encode(out);
    return {out.begin(), out.end()};
  }
  /// Bytes that must follow the structure for it to be accepted, according to its own length field.
  static std::size_t promised(const T& value) {
    if constexpr (std::is_same_v<T, MailboxHeader>) return value.length;
    return 0;
  }
};

using Types = AsTestTypes<Structures>::Type;
TYPED_TEST_SUITE(WireType, Types);

TYPED_TEST(WireType, EncodesToGoldenBytes) {
  ASSERT_FALSE(Sample<TypeParam>::golden().empty());
  for (const auto& golden : Sample<TypeParam>::golden()) {
    EXPECT_EQ(this->encoded(golden.value), bytes_of(golden.hex)) << golden.provenance;
  }
}

TYPED_TEST(WireType, DecodesGoldenBytes) {
  for (const auto& golden : Sample<TypeParam>::golden()) {
    Bytes bytes = bytes_of(golden.hex);
    bytes.resize(bytes.size() + this->promised(golden.value));
    const auto value = TypeParam::decode(bytes);
    ASSERT_TRUE(value) << golden.provenance << ": " << to_text(value.error());
    EXPECT_EQ(*value, golden.value) << golden.provenance;
  }
}

TYPED_TEST(WireType, RandomValuesSurviveTheRoundTrip) {
  std::mt19937 random(20240);
  for (int i = 0; i < 5000; ++i) {
    const TypeParam value = Sample<TypeParam>::random(random);
    Bytes bytes = this->encoded(value);
    ASSERT_EQ(bytes.size(), TypeParam::kSize);
    bytes.resize(bytes.size() + this->promised(value));
    const auto decoded = must(TypeParam::decode(bytes));
    ASSERT_EQ(*decoded, value);
  }
}

TYPED_TEST(WireType, ShortBuffersAreRejected) {
  for (const auto& golden : Sample<TypeParam>::golden()) {
    Bytes whole = bytes_of(golden.hex);
    whole.resize(whole.size() + this->promised(golden.value));
    for (std::size_t size = 0; size < whole.size(); ++size) {
      const Bytes bytes(whole.begin(), whole.begin() + static_cast<std::ptrdiff_t>(size));
      const auto decoded = TypeParam::decode(bytes);
      ASSERT_FALSE(decoded) << size;
      EXPECT_EQ(decoded.error(), size < TypeParam::kSize ? DecodeError::kTooShort : DecodeError::kBadLength) << size;
    }
  }
}

TYPED_TEST(WireType, AnyBytesDecodeOrAreRejected) {
  std::mt19937 random(7);
  for (int i = 0; i < 5000; ++i) {
    Bytes bytes(random() % 40);
    for (auto& b : bytes) b = any<std::byte>(random);
    const auto decoded = TypeParam::decode(bytes);
    if (bytes.size() < TypeParam::kSize) {
      ASSERT_FALSE(decoded);
    } else if (decoded) {
      // A decoded value is encoded to bytes with the same meaning.
      Bytes again = this->encoded(*decoded);
      again.resize(again.size() + this->promised(*decoded));
      ASSERT_EQ(TypeParam::decode(again), *decoded);
    }
  }
}

TEST(MailboxErrorReply, OtherReplyTypesAreRejected) {
  const auto decoded = MailboxErrorReply::decode(bytes_of("02 00 02 00"));
  ASSERT_FALSE(decoded);
  EXPECT_EQ(decoded.error(), DecodeError::kBadService);
}

TEST(EtherCatHeader, ReservedBitIsIgnored) {
  EXPECT_EQ(EtherCatHeader::decode(bytes_of("0e 18")), (EtherCatHeader{14, 1}));
}

TEST(DatagramHeader, ReservedBitsAreIgnoredAndWrittenAsZero) {
  const auto header = must(DatagramHeader::decode(bytes_of("01 00 00 00 00 00 04 38 00 00")));
  EXPECT_EQ(header->length, 4);
  EXPECT_FALSE(header->circulating);
  EXPECT_FALSE(header->more);
  std::array<std::byte, DatagramHeader::kSize> out{};
  header->encode(out);
  EXPECT_EQ(out[7], std::byte{0});
}

TEST(FmmuEntity, ReservedBitsAreIgnored) {
  const auto all = FmmuEntity::decode(bytes_of("00 00 00 00 00 00 ff ff 00 00 ff ff ff ff ff ff"));
  EXPECT_EQ(all, (FmmuEntity{0, 0, 7, 7, 0, 7, 3, true}));
  EXPECT_EQ(FmmuEntity::decode(bytes_of("00 00 00 00 00 00 f8 f8 00 00 f8 fc fe 00 00 00")),
            (FmmuEntity{0, 0, 0, 0, 0, 0, 0, false}));
}

TEST(DatagramAddress, PhysicalAndLogical) {
  // twincat packet 408: 01 00 10 09
  const auto address = DatagramAddress::physical(1, 0x0910);
  EXPECT_EQ(address.raw, 0x09100001U);
  EXPECT_EQ(address.adp(), 1);
  EXPECT_EQ(address.ado(), 0x0910);
  EXPECT_EQ(DatagramAddress::logical(0xDEADBEEF).raw, 0xDEADBEEFU);
}

TEST(DatagramAddress, PositionsCountDownwards) {
  // ETG.1000.4 5.4.1.3: each slave adds one, the slave that finds zero is addressed.
  EXPECT_EQ(DatagramAddress::position(0, 0x10).adp(), 0);
  EXPECT_EQ(DatagramAddress::position(1, 0x10).adp(), 0xFFFF);
  EXPECT_EQ(DatagramAddress::position(100, 0x10).adp(), 0xFF9C);
  EXPECT_EQ(DatagramAddress::position(100, 0x1234).ado(), 0x1234);
}

TEST(SdoHeader, FlagsAndSizes) {
  // Answers of the AKD drive in the soem capture: 4Fh carries one byte, 4Bh two, 43h four.
  EXPECT_EQ(SdoHeader::decode(bytes_of("4f 00 1c 00 04 00 00 00"))->expedited_size(), 1U);
  EXPECT_EQ(SdoHeader::decode(bytes_of("4b 12 1c 01 00 16 00 00"))->expedited_size(), 2U);
  EXPECT_EQ(SdoHeader::decode(bytes_of("47 12 1c 01 00 16 00 00"))->expedited_size(), 3U);
  const auto four = SdoHeader::decode(bytes_of("43 00 16 01 10 00 40 60")).value();
  EXPECT_EQ(four.expedited_size(), 4U);
  EXPECT_EQ(four.data_u32(), 0x60400010U);
  EXPECT_EQ(four.specifier(), 2);
  EXPECT_TRUE(four.expedited());
  EXPECT_TRUE(four.size_indicated());
  EXPECT_FALSE(four.complete_access());
  const auto complete = SdoHeader{0x50, 0x1018, 1, {}};
  EXPECT_TRUE(complete.complete_access());
  EXPECT_FALSE(complete.expedited());
  EXPECT_EQ((SdoHeader{0x42, 0, 0, {}}.expedited_size()), 4U);  // size not indicated
}

TEST(SdoHeader, ExpeditedCommands) {
  // CiA 301 7.2.4.3.3 and 7.2.4.3.5: 2F 2B 27 23 for downloads, 4F 4B 47 43 for uploads of 1 to 4 bytes.
  constexpr std::array<std::uint8_t, 4> kDownload{0x2F, 0x2B, 0x27, 0x23};
  constexpr std::array<std::uint8_t, 4> kUpload{0x4F, 0x4B, 0x47, 0x43};
  for (std::size_t size = 1; size <= 4; ++size) {
    EXPECT_EQ(expedited_command(1, size), kDownload[size - 1]);
    EXPECT_EQ(expedited_command(2, size), kUpload[size - 1]);
  }
}

TEST(MailboxHeader, CounterRunsFromOneToSeven) {
  std::uint8_t counter = 0;
  for (const int expected : {1, 2, 3, 4, 5, 6, 7, 1, 2}) {
    counter = next_mailbox_counter(counter);
    EXPECT_EQ(counter, expected);
  }
  EXPECT_EQ(next_mailbox_counter(255), 1);
}

}  // namespace
}  // namespace driveline::wire::test
