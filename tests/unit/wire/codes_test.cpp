#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <set>
#include <string>

#include "driveline/wire/al_status_code.hpp"
#include "driveline/wire/command.hpp"
#include "driveline/wire/decode_error.hpp"
#include "driveline/wire/foe.hpp"
#include "driveline/wire/mailbox.hpp"
#include "driveline/wire/sdo_abort.hpp"
#include "driveline/wire/sii_access.hpp"

namespace driveline::wire {
namespace {

TEST(Command, EveryValueHasAText) {
  // ETG.1000.4 5.4, in the order of the codes.
  const std::vector<std::string_view> names{"NOP", "APRD", "APWR", "APRW", "FPRD", "FPWR", "FPRW", "BRD",
                                            "BWR", "BRW",  "LRD",  "LWR",  "LRW",  "ARMW", "FRMW"};
  for (unsigned raw = 0; raw <= 255; ++raw) {
    const auto command = static_cast<Command>(raw);
    EXPECT_EQ(is_known(command), raw < names.size()) << raw;
    EXPECT_EQ(to_text(command), raw < names.size() ? names[raw] : "?") << raw;
    EXPECT_EQ(is_logical(command), raw == 10 || raw == 11 || raw == 12) << raw;
  }
}

/// The codes of ETG.1000.6 Table 11 and ETG.1020, typed a second time.
const std::set<unsigned> kAlCodes{0x00, 0x01, 0x02, 0x03, 0x04, 0x06, 0x07, 0x0E, 0x11, 0x12, 0x13, 0x14,
                                  0x15, 0x16, 0x17, 0x18, 0x19, 0x1A, 0x1B, 0x1C, 0x1D, 0x1E, 0x1F, 0x20,
                                  0x21, 0x22, 0x23, 0x24, 0x25, 0x26, 0x27, 0x28, 0x29, 0x2A, 0x2B, 0x2C,
                                  0x2D, 0x2E, 0x30, 0x31, 0x32, 0x33, 0x34, 0x35, 0x36, 0x37, 0x41, 0x42,
                                  0x43, 0x44, 0x45, 0x4F, 0x50, 0x51, 0x52, 0x60, 0x61, 0xF0};

TEST(AlStatusCode, EveryCodeHasAText) {
  std::set<std::string_view> texts;
  for (unsigned raw = 0; raw <= 0xFFFF; ++raw) {
    const auto text = to_text(static_cast<AlStatusCode>(raw));
    if (kAlCodes.count(raw) == 0) {
      ASSERT_EQ(text, raw >= 0x8000 ? "vendor specific" : "unknown code") << raw;
    } else {
      ASSERT_TRUE(texts.insert(text).second) << "two codes with the text " << text;
      ASSERT_NE(text, "unknown code") << raw;
    }
  }
}

TEST(AlStatusCode, TableIsSortedAsTheSearchNeeds) {
  EXPECT_TRUE(std::is_sorted(kAlStatusCodeTexts.begin(), kAlStatusCodeTexts.end(),
                             [](const auto& a, const auto& b) { return a.code < b.code; }));
  EXPECT_EQ(kAlStatusCodeTexts.size(), kAlCodes.size());
}

TEST(AlStatusCode, TheCodesThatMattersMost) {
  EXPECT_EQ(to_text(static_cast<AlStatusCode>(0x0011)), "invalid requested state change");
  EXPECT_EQ(to_text(static_cast<AlStatusCode>(0x0016)), "invalid mailbox configuration (PREOP)");
  EXPECT_EQ(to_text(static_cast<AlStatusCode>(0x0017)), "invalid sync manager configuration");
  EXPECT_EQ(to_text(static_cast<AlStatusCode>(0x001B)), "sync manager watchdog");
  EXPECT_EQ(to_text(static_cast<AlStatusCode>(0x001D)), "invalid output configuration");
  EXPECT_EQ(to_text(static_cast<AlStatusCode>(0x001E)), "invalid input configuration");
  EXPECT_EQ(to_text(static_cast<AlStatusCode>(0x002C)), "fatal synchronization error");
  EXPECT_EQ(to_text(static_cast<AlStatusCode>(0x0030)), "invalid DC SYNC configuration");
}

TEST(SdoAbort, EveryCodeHasATextOfItsOwn) {
  // ETG.1000.6 Table 41 and CiA 301 7.2.4.3.17, typed a second time.
  const std::vector<std::uint32_t> codes{
      0x05030000, 0x05040000, 0x05040001, 0x05040002, 0x05040003, 0x05040004, 0x060A0023, 0x08000024, 0x05040005,
      0x06010000, 0x06010001, 0x06010002, 0x06010003, 0x06010004, 0x06010005, 0x06010006, 0x06020000, 0x06040041,
      0x06040042, 0x06040043, 0x06040047, 0x06060000, 0x06070010, 0x06070012, 0x06070013, 0x06090011, 0x06090030,
      0x06090031, 0x06090032, 0x06090036, 0x08000000, 0x08000020, 0x08000021, 0x08000022, 0x08000023};
  std::set<std::string_view> texts;
  for (const auto code : codes) {
    EXPECT_TRUE(texts.insert(to_text(static_cast<SdoAbort>(code))).second) << std::hex << code;
    for (const auto near : {code - 1, code + 1, code ^ 0x80000000U}) {
      const bool listed = std::find(codes.begin(), codes.end(), near) != codes.end();
      EXPECT_EQ(to_text(static_cast<SdoAbort>(near)) == "unknown abort code", !listed) << std::hex << near;
    }
  }
  EXPECT_EQ(kSdoAbortTexts.size(), codes.size());
  EXPECT_EQ(texts.count("unknown abort code"), 0U);
}

TEST(SdoAbort, Texts) {
  EXPECT_THAT(to_text(static_cast<SdoAbort>(0x06020000)), ::testing::HasSubstr("does not exist"));
  EXPECT_THAT(to_text(static_cast<SdoAbort>(0x06090011)), ::testing::HasSubstr("sub-index"));
  EXPECT_THAT(to_text(static_cast<SdoAbort>(0x06010002)), ::testing::HasSubstr("read only"));
  EXPECT_THAT(to_text(static_cast<SdoAbort>(0x06010001)), ::testing::HasSubstr("write only"));
}

TEST(DecodeError, EveryValueHasAText) {
  std::set<std::string_view> texts;
  for (unsigned raw = 0; raw <= static_cast<unsigned>(DecodeError::kReservedBits); ++raw) {
    EXPECT_TRUE(texts.insert(to_text(static_cast<DecodeError>(raw))).second) << raw;
  }
  EXPECT_EQ(to_text(static_cast<DecodeError>(200)), "undecodable");
}

TEST(FoeError, EveryCodeHasATextOfItsOwn) {
  std::set<std::string_view> texts;
  for (const auto& row : kFoeErrorTexts) EXPECT_TRUE(texts.insert(row.text).second) << row.text;
  EXPECT_EQ(kFoeErrorTexts.front().code, static_cast<FoeError>(0x8000));
  for (std::uint32_t code = 0x8000; code <= 0x800C; ++code) {
    EXPECT_NE(to_text(static_cast<FoeError>(code)), "unknown FoE error") << std::hex << code;
  }
  EXPECT_EQ(to_text(static_cast<FoeError>(0x800E)), "unknown FoE error") << "reserved";
  EXPECT_EQ(to_text(static_cast<FoeError>(0x7FFF)), "unknown FoE error");
}

TEST(FoeOpCode, CodesOfTheStandard) {
  EXPECT_EQ(static_cast<int>(FoeOpCode::kReadRequest), 1);
  EXPECT_EQ(static_cast<int>(FoeOpCode::kWriteRequest), 2);
  EXPECT_EQ(static_cast<int>(FoeOpCode::kData), 3);
  EXPECT_EQ(static_cast<int>(FoeOpCode::kAck), 4);
  EXPECT_EQ(static_cast<int>(FoeOpCode::kError), 5);
  EXPECT_EQ(static_cast<int>(FoeOpCode::kBusy), 6);
}

TEST(FoeBusy, IsDoneAndEntireInThisOrder) {
  constexpr std::array kMail = {std::byte{6}, std::byte{0},    std::byte{0x32},
                                std::byte{0}, std::byte{0x64}, std::byte{1}};
  const auto header = FoeHeader::decode(kMail);
  EXPECT_EQ(FoeBusy::from_value(header->value), (FoeBusy{0x32, 0x0164}));
  EXPECT_EQ((FoeBusy{0x32, 0x0164}).value(), header->value);
}

TEST(MailboxErrorCode, EveryCodeHasATextOfItsOwn) {
  std::set<std::string_view> texts;
  for (std::uint16_t code = 1; code <= 9; ++code) {
    EXPECT_TRUE(texts.insert(to_text(static_cast<MailboxErrorCode>(code))).second) << code;
  }
  EXPECT_EQ(texts.count("unknown mailbox error"), 0U);
  EXPECT_EQ(to_text(static_cast<MailboxErrorCode>(10)), "unknown mailbox error");
}

TEST(MailboxType, CodesOfTheStandard) {
  // ETG.1000.4 Table 29.
  EXPECT_EQ(static_cast<int>(MailboxType::kError), 0);
  EXPECT_EQ(static_cast<int>(MailboxType::kAoe), 1);
  EXPECT_EQ(static_cast<int>(MailboxType::kEoe), 2);
  EXPECT_EQ(static_cast<int>(MailboxType::kCoe), 3);
  EXPECT_EQ(static_cast<int>(MailboxType::kFoe), 4);
  EXPECT_EQ(static_cast<int>(MailboxType::kSoe), 5);
  EXPECT_EQ(static_cast<int>(MailboxType::kVoe), 15);
}

TEST(SiiAccess, BitsOfTheControlRegister) {
  // ESC data sheet, register 0x0502:0x0503.
  EXPECT_EQ(sii_access::kCommandRead | sii_access::kCommandWrite | sii_access::kCommandReload,
            sii_access::kCommandMask);
  const std::vector<unsigned> bits{sii_access::kWriteEnable,
                                   sii_access::kReads8Bytes,
                                   sii_access::kTwoByteAddress,
                                   sii_access::kCommandRead,
                                   sii_access::kCommandWrite,
                                   sii_access::kCommandReload,
                                   sii_access::kErrorChecksum,
                                   sii_access::kErrorNotLoaded,
                                   sii_access::kErrorAcknowledge,
                                   sii_access::kErrorWriteEnable,
                                   sii_access::kBusy};
  EXPECT_THAT(bits, ::testing::ElementsAre(1U << 0, 1U << 6, 1U << 7, 1U << 8, 1U << 9, 1U << 10, 1U << 11, 1U << 12,
                                           1U << 13, 1U << 14, 1U << 15));
}

}  // namespace
}  // namespace driveline::wire
