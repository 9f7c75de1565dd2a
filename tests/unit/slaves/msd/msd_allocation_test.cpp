// The cycle of the drive must not allocate, free or lock. A separate program, because the guard replaces malloc.
#include "drive_rig.hpp"
#include "driveline/rt_guard/rt_guard.hpp"

namespace driveline::slaves::msd {
namespace {

/// Mailbox with an SDO upload of `index` or, for 2003h, a download of a long string.
std::array<std::byte, 512> request(std::uint16_t index, unsigned counter, bool download) {
  std::array<std::byte, 512> mailbox{};
  const unsigned length = download ? 70 : 10;
  const std::array<unsigned, 16> start = {length,
                                          0,
                                          0,
                                          0,
                                          0,
                                          0x03U | counter << 4,
                                          0,
                                          0x20,
                                          download ? 0x21U : 0x40U,
                                          index & 0xFFU,
                                          unsigned{index} >> 8,
                                          0,
                                          download ? 60U : 0U,
                                          0,
                                          0,
                                          0};
  for (std::size_t i = 0; i < start.size(); ++i) mailbox[i] = static_cast<std::byte>(start[i]);
  for (std::size_t i = 16; download && i < 76; ++i) mailbox[i] = std::byte{'n'};
  return mailbox;
}

TEST(MsdAllocation, NoneInTenThousandCyclesWithMailboxFaultAndRecovery) {
  EnabledRig rig(8);
  std::array<std::byte, 512> reply{};
  if (!rt::RtGuard::available()) GTEST_SKIP() << "a sanitizer owns malloc; the guard counts nothing here";
  std::size_t answers = 0;
  rt::RtGuard::enter();
  for (unsigned i = 0; i < 12'000; ++i) {
    rig.target_position += 20;
    rig.command(i % 4000 < 3900 ? 0x0F : i % 4000 < 3950 ? 0x80 : i % 4000 < 3970 ? 0x06 : 0x07);
    rig.device.mailbox_request(request(i % 3 == 0 ? 0x2003 : i % 3 == 1 ? 0x6064 : 0x9999, 1 + i % 7, i % 6 == 0));
    while (rig.device.mailbox_reply(reply) != 0) ++answers;
    if (i % 4000 == 3890) rig.device.fall_back(AlState::kOp, AlState::kSafeOp, AlStatusCode::kSyncManagerWatchdog);
    if (i % 4000 == 3895) static_cast<void>(rig.device.transition(AlState::kSafeOp, AlState::kOp));
  }
  EXPECT_EQ(rt::RtGuard::leave().total(), 0U);
  EXPECT_GE(answers, 12'000U);
  EXPECT_EQ(rig.drive.dictionary().raw(*dictionary_table().find(0x1003, 0)), 1U) << "the faults did happen";
}

}  // namespace
}  // namespace driveline::slaves::msd
