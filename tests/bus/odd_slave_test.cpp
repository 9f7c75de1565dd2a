// Slaves that do not behave as the standard says, and that users have on their lines nevertheless.
#include <gmock/gmock.h>

#include "drive_line.hpp"
#include "driveline/ecat_master/coe/coe_client.hpp"
#include "driveline/ecat_master/diagnosis/diagnosis.hpp"
#include "driveline/ecat_master/discovery/line_survey.hpp"
#include "edited_line.hpp"
#include "fault_ports.hpp"
#include "started_line.hpp"

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
  PreOpMaster master(drives.line(), drives.clock);
  const auto hears_from = drives.clock.now() + milliseconds{300};
  drives.device(1).swallows = [&](auto) { return drives.clock.now() < hears_from; };
  const auto product = CoeClient(master.mailboxes(), 1).upload_as<std::uint32_t>(0x1018, 2);
  ASSERT_EQ(sentence(product), "");
  EXPECT_EQ(*product, slaves::msd::kProductCode);
  EXPECT_EQ(master.mailboxes().statistics(1).resent, 1U);
  drives.device(1).changes_answer = with_counter_1;
  for (const auto number : {std::uint8_t{1}, std::uint8_t{2}, std::uint8_t{4}}) {
    ASSERT_EQ(sentence(CoeClient(master.mailboxes(), 1).upload(0x1018, number)), "");
  }
  const auto diagnosis = ecat_master::diagnose(master, nullptr, nullptr);
  ASSERT_EQ(sentence(diagnosis), "");
  EXPECT_THAT(diagnosis->problems,
              testing::ElementsAre("slave 1: mailbox requests were sent again because no answer came (1)",
                                   "slave 1: mailbox answers have the counter of the previous message (3)"));
}

TEST(OddSlave, ThatLosesARequestButNotesItsCounterAnswersTheLastOne) {
  EditedLine drives(1);
  PreOpMaster master(drives.line(), drives.clock);
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
  PreOpMaster master(port, drives.clock);
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

/// A line whose second drive reads its EEPROM on the way to PREOP, which fails with AL status code 0x0050 as long as
/// register 0x0500 does not offer it the interface.
class EepromReader {
 public:
  EepromReader() : drives_(2), master_(drives_.line(), drives_.clock) {
    drives_.device(1).judges = [this](wire::AlState from, wire::AlState to) {
      if (from != wire::AlState::kInit || to != wire::AlState::kPreOp || owner() == 1) {
        return wire::AlStatusCode::kNoError;
      }
      ++refusals;
      return wire::AlStatusCode::kEepromNoAccess;
    };
  }

  [[nodiscard]] Master& master() noexcept { return master_; }
  /// Register 0x0500 of the second drive.
  [[nodiscard]] int owner() {
    std::array<std::byte, 1> value{};
    drives_.slave(1).esc().pdi_read(wire::reg::kSiiConfiguration.address, value, drives_.clock.now());
    return std::to_integer<int>(value[0]);
  }
  [[nodiscard]] std::string configure(const ecat_master::SlavePlan& second) {
    ecat_master::SlavePlan first;
    first.own_pdos = true;
    if (const auto scanned = master_.scan(); !scanned) return sentence(scanned);
    return sentence(master_.configure({first, second}));
  }
  int refusals = 0;

 private:
  EditedLine drives_;
  Master master_;
};

TEST(OddSlave, ThatReadsItsEepromGetsItWhenItRefusesPreOp) {
  EepromReader line;
  ASSERT_EQ(sentence(line.master().scan()), "");
  EXPECT_EQ(line.owner(), 0);
  ASSERT_EQ(sentence(line.master().enter_pre_op()), "");
  EXPECT_EQ(line.refusals, 1);
  EXPECT_EQ(line.owner(), 1);
  // The master reads the EEPROM, also beside another master, and the application has it again.
  const auto refs = std::array{line.master().slaves()[0].info.ref, line.master().slaves()[1].info.ref};
  line.master().bus().sii_cache().clear();
  for (const auto& image : ecat_master::read_each_sii(line.master().bus(), refs)) {
    ASSERT_EQ(sentence(image), "");
    EXPECT_GT(image->size(), 128U);
  }
  EXPECT_EQ(line.owner(), 1);
}

TEST(OddSlave, ThatReadsItsEepromHasItBeforePreOpWhereThePlanOrTheFileSaysSo) {
  for (const bool by_file : {false, true}) {
    EepromReader line;
    ecat_master::SlavePlan plan;
    plan.own_pdos = true;
    if (by_file) {
      ASSERT_EQ(sentence(line.master().scan()), "");
      auto file = line.master().slaves()[1].info.description;
      file.eeprom_to_application = true;
      // The PDOs stay those of the slave.
      file.rx_pdos.clear();
      file.tx_pdos.clear();
      plan.esi = std::make_shared<const esi::DeviceDescription>(file);
    } else {
      plan.eeprom_to_application = true;
    }
    ASSERT_EQ(line.configure(plan), "");
    EXPECT_EQ(line.refusals, 0) << by_file;
    EXPECT_EQ(line.owner(), 1) << by_file;
  }
}

}  // namespace
}  // namespace driveline::bus_test
