// Slaves that do not behave as the standard says, and that users have on their lines nevertheless.
#include <gmock/gmock.h>

#include "drive_line.hpp"
#include "driveline/ecat_master/coe/coe_client.hpp"
#include "edited_line.hpp"
#include "fault_ports.hpp"

namespace driveline::bus_test {
namespace {

using ecat_master::CoeClient;
using ecat_master::Master;

/// Gives every answer the mailbox counter 1.
std::size_t with_counter_1(std::span<std::byte> out, std::size_t length) {
  out[5] = (out[5] & std::byte{0x0F}) | std::byte{0x10};
  return length;
}

TEST(OddSlave, ThatIsDeafAfterPreOpAnswersTheRepeatedRequest) {
  EditedLine drives(2);
  Master master(drives.line(), drives.clock);
  ASSERT_EQ(sentence(master.scan()), "");
  ASSERT_EQ(sentence(master.enter_pre_op()), "");
  const auto hears_from = drives.clock.now() + milliseconds{300};
  drives.device(1).swallows = [&](auto) { return drives.clock.now() < hears_from; };
  const auto product = CoeClient(master.mailboxes(), 1).upload_as<std::uint32_t>(0x1018, 2);
  ASSERT_EQ(sentence(product), "");
  EXPECT_EQ(*product, slaves::msd::kProductCode);
  EXPECT_EQ(master.mailboxes().statistics(1).resent, 1U);
}

TEST(OddSlave, ThatLosesARequestButNotesItsCounterAnswersTheLastOne) {
  EditedLine drives(1);
  Master master(drives.line(), drives.clock);
  ASSERT_EQ(sentence(master.scan()), "");
  ASSERT_EQ(sentence(master.enter_pre_op()), "");
  std::size_t lost = 0;
  std::byte noted{0};
  drives.device(0).swallows = [&](std::span<const std::byte> mailbox) {
    const auto counter = mailbox[5] & std::byte{0x70};
    if (lost == 0) noted = counter;
    return counter == noted && ++lost > 0;
  };
  EXPECT_EQ(CoeClient(master.mailboxes(), 0).upload_as<std::uint32_t>(0x1018, 2).value(), slaves::msd::kProductCode);
  EXPECT_EQ(lost, 3U);
}

TEST(OddSlave, WithAConstantMailboxCounterGivesEveryValueWhateverIsLost) {
  constexpr std::uint32_t kOneIn = 20;
  EditedLine drives(1);
  bool armed = false;
  Chance chance(kOneIn);
  LossyPort port(drives.line(), LossyPort::Direction::kBack, [&](auto, auto) { return armed && chance(); });
  Master master(port, drives.clock);
  ASSERT_EQ(sentence(master.scan()), "");
  ASSERT_EQ(sentence(master.enter_pre_op()), "");
  drives.device(0).changes_answer = with_counter_1;
  armed = true;
  CoeClient coe(master.mailboxes(), 0);
  for (int i = 0; i < 100; ++i) {
    ASSERT_EQ(coe.upload_as<std::uint32_t>(0x1018, 1).value(), 0x28U) << i;
    ASSERT_EQ(coe.upload_as<std::uint32_t>(0x1018, 2).value(), slaves::msd::kProductCode) << i;
    ASSERT_EQ(coe.upload_as<std::uint32_t>(0x1018, 4).value(), 1000U) << i;
  }
  EXPECT_GT(port.lost(), 10U);
  EXPECT_GT(master.mailboxes().statistics(0).same_counter, 200U);
}

}  // namespace
}  // namespace driveline::bus_test
