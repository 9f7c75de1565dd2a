#include <gmock/gmock.h>

#include "driveline/ecat_master/diagnosis/diagnosis.hpp"
#include "driveline/ecat_master/discovery/device_identification.hpp"
#include "driveline/ecat_master/discovery/line_comparison.hpp"
#include "edited_line.hpp"
#include "started_line.hpp"

namespace driveline::bus_test {
namespace {

using ecat_master::compare_line;
using ecat_master::Difference;
using ecat_master::ExpectedSlave;
using ecat_master::IdentityRule;
using ecat_master::Master;
using ecat_master::SlaveInfo;
using ecat_master::Topology;
using wire::AlState;
using Kind = Difference::Kind;
constexpr auto kNone = Difference::kNone;

/// A slave named by a letter; its product is the letter, its serial number its position in the alphabet.
SlaveInfo found_one(char letter, std::uint16_t position) {
  SlaveInfo slave;
  slave.ref = {position, static_cast<std::uint16_t>(0x1001 + position)};
  slave.description.vendor_id = 0x28;
  slave.description.product_code = static_cast<unsigned char>(letter);
  slave.description.revision = 5;
  slave.description.serial_number = static_cast<std::uint32_t>(letter - 'a' + 1);
  slave.description.name = std::string(1, letter);
  return slave;
}

std::vector<SlaveInfo> found(std::string_view letters) {
  std::vector<SlaveInfo> line;
  for (const char letter : letters) line.push_back(found_one(letter, static_cast<std::uint16_t>(line.size())));
  return line;
}

/// A dot is a slave with any identity.
std::vector<ExpectedSlave> planned(std::string_view letters) {
  std::vector<ExpectedSlave> plan;
  for (const char letter : letters) {
    ExpectedSlave slave;
    slave.name = std::string(1, letter);
    if (letter != '.') slave.product = IdentityRule::equal(static_cast<std::uint32_t>(letter));
    plan.push_back(slave);
  }
  return plan;
}

std::vector<Difference> differences(std::string_view plan, std::string_view line) {
  return compare_line(planned(plan), found(line), Topology{}).differences;
}

TEST(LineComparison, FindsNothingWhereNothingIsWrong) {
  EXPECT_THAT(differences("abc", "abc"), testing::IsEmpty());
  EXPECT_THAT(differences("a.c", "axc"), testing::IsEmpty());
  EXPECT_THAT(differences("", "abc"), testing::IsEmpty()) << "no plan: anything goes";
}

TEST(LineComparison, AMissingSlaveIsOneDifference) {
  EXPECT_THAT(differences("abcd", "acd"), testing::ElementsAre(Difference{Kind::kMissing, kNone, 0, 1}));
  EXPECT_THAT(differences("abcd", "bcd"), testing::ElementsAre(Difference{Kind::kMissing, kNone, kNone, 0}));
  EXPECT_THAT(differences("abcd", "abc"), testing::ElementsAre(Difference{Kind::kMissing, kNone, 2, 3}));
  EXPECT_EQ(differences("ab", "").size(), 2U);
}

TEST(LineComparison, AnExtraSlaveIsOneDifference) {
  EXPECT_THAT(differences("abc", "abxc"), testing::ElementsAre(Difference{Kind::kExtra, 2, kNone, kNone}));
  EXPECT_THAT(differences("abc", "xabc"), testing::ElementsAre(Difference{Kind::kExtra, 0, kNone, kNone}));
}

TEST(LineComparison, SwappedNeighboursAreOneDifference) {
  EXPECT_THAT(differences("abcd", "acbd"), testing::ElementsAre(Difference{Kind::kSwapped, 1, 2, 1}));
  EXPECT_THAT(differences("ab", "ba"), testing::ElementsAre(Difference{Kind::kSwapped, 0, 1, 0}));
  EXPECT_THAT(differences("abcd", "badc"),
              testing::ElementsAre(Difference{Kind::kSwapped, 0, 1, 0}, Difference{Kind::kSwapped, 2, 3, 2}));
}

TEST(LineComparison, AnotherDeviceInAPlaceIsOneDifference) {
  EXPECT_THAT(differences("abc", "axc"), testing::ElementsAre(Difference{Kind::kWrongDevice, 1, kNone, 1}));
}

TEST(LineComparison, RevisionAndSerialHaveRules) {
  auto plan = planned("ab");
  plan[0].revision = IdentityRule::at_least(5);
  plan[1].revision = IdentityRule::at_least(6);
  EXPECT_THAT(compare_line(plan, found("ab"), Topology{}).differences,
              testing::ElementsAre(Difference{Kind::kRevision, 1, kNone, 1}));
  plan[1].revision = IdentityRule::equal(5);
  plan[1].serial = IdentityRule::equal(3);
  EXPECT_THAT(compare_line(plan, found("ab"), Topology{}).differences,
              testing::ElementsAre(Difference{Kind::kSerial, 1, kNone, 1}));
}

TEST(LineComparison, SerialNumbersTellWhichOfEqualDrivesIsMissing) {
  std::vector<ExpectedSlave> plan(4);
  for (std::uint32_t i = 0; i < 4; ++i) plan[i].serial = IdentityRule::equal(i + 1);
  EXPECT_THAT(compare_line(plan, found("abd"), Topology{}).differences,
              testing::ElementsAre(Difference{Kind::kMissing, kNone, 1, 2}));
}

TEST(LineComparison, SlavesWithAnAliasMayBeAnywhere) {
  auto line = found("abc");
  line[2].alias = 7;
  auto plan = planned("cab");
  plan[0].alias = 7;
  const auto compared = compare_line(plan, line, Topology{});
  EXPECT_TRUE(compared.matches());
  EXPECT_THAT(compared.plan_of_slave, testing::ElementsAre(1U, 2U, 0U));
  plan[0].alias = 8;
  EXPECT_THAT(
      compare_line(plan, line, Topology{}).differences,
      testing::ElementsAre(Difference{Kind::kMissing, kNone, kNone, 0}, Difference{Kind::kExtra, 2, kNone, kNone}));
  plan[0].alias = 7;
  line[0].alias = 7;
  EXPECT_THAT(compare_line(plan, line, Topology{}).differences,
              testing::Contains(Difference{Kind::kDuplicate, 0, 2, 0}));
  const auto duplicates = find_duplicate_aliases(line);
  ASSERT_EQ(duplicates.size(), 1U);
  EXPECT_EQ(duplicates[0].alias, 7);
  EXPECT_THAT(duplicates[0].positions, testing::ElementsAre(0, 2));
}

TEST(LineComparison, SaysWhatItFound) {
  auto plan = planned("ab");
  plan[1].revision = IdentityRule::at_least(6);
  plan[1].name = "y";
  auto say = [&](std::string_view line) {
    const auto slaves = found(line);
    std::vector<std::string> text;
    for (const auto& d : compare_line(plan, slaves, Topology{}).differences) text.push_back(describe(d, plan, slaves));
    return text;
  };
  EXPECT_THAT(say("ab"),
              testing::ElementsAre(
                  "slave 1: wrong revision: \"y\" (slave 1: product 0x00000062 revision >= 0x00000006) is planned, "
                  "found b, vendor 0x00000028 product 0x00000062 revision 0x00000005 serial 2"));
  EXPECT_THAT(say("a"), testing::ElementsAre(
                            "missing: \"y\" (slave 1: product 0x00000062 revision >= 0x00000006), behind slave 0"));
}

TEST(LineComparison, SaysWhoIsMissingBehindWhom) {
  const auto say = [](std::string_view plan, std::string_view line) {
    const auto expected = planned(plan);
    const auto slaves = found(line);
    return describe(compare_line(expected, slaves, Topology{}), expected, slaves);
  };
  EXPECT_THAT(say("abcd", "ab"), testing::ElementsAre("missing: \"c\" (slave 2: product 0x00000063), behind slave 1",
                                                      "missing: \"d\" (slave 3: product 0x00000064), behind slave 1"));
  EXPECT_THAT(say("ab", "b"),
              testing::ElementsAre("missing: \"a\" (slave 0: product 0x00000061), in front of the others"));
  EXPECT_THAT(say("aab", "ab"),
              testing::ElementsAre("missing: \"a\" (slave 1: product 0x00000061), behind slave 0 or another of its "
                                   "kind before that"))
      << "equal devices: which one is gone cannot be known";
  EXPECT_THAT(say("ab", "axb"),
              testing::ElementsAre("extra: slave 1 is not planned: x, vendor 0x00000028 product 0x00000078 revision "
                                   "0x00000005 serial 24"));
  EXPECT_THAT(
      say("abc", "xcb"),
      testing::ElementsAre(testing::StartsWith("slave 0: \"a\" (slave 0: product 0x00000061) is planned, found x"),
                           "slave 1 and slave 2 have changed places: \"b\" (slave 1: product 0x00000062) is "
                           "planned first"))
      << "all of them, not the first one";
}

TEST(LineComparison, AnEepromThatCannotBeReadIsNoForeignDevice) {
  auto line = found("abc");
  line[1] = ecat_master::make_slave_info(line[1].ref, std::vector<std::byte>(256, std::byte{0xFF}));
  const auto expected = planned("abc");
  const auto compared = compare_line(expected, line, Topology{});
  EXPECT_THAT(compared.differences, testing::ElementsAre(Difference{Kind::kEeprom, 1, kNone, 1}));
  EXPECT_THAT(describe(compared, expected, line),
              testing::ElementsAre("slave 1: EEPROM is blank: all bytes are 0xFF; \"b\" (slave 1: product "
                                   "0x00000062) is planned there"));
  EXPECT_TRUE(to_error(compared.differences.front(), expected, line).is<ecat_master::facts::SiiBlank>());
}

TEST(PlanByAlias, FindsTheDriveWhereverItIs) {
  EditedLine drives(
      3, [](std::size_t drive, auto& profile) { set_alias(profile, static_cast<std::uint16_t>(30 - 10 * drive)); });
  ScannedMaster master(drives.line(), drives.clock);
  std::vector<ecat_master::SlavePlan> plans(3);
  for (std::size_t i = 0; i < 3; ++i) {
    plans[i].name = "axis " + std::to_string(i);
    plans[i].alias = static_cast<std::uint16_t>(10 * (i + 1));
  }
  ASSERT_EQ(sentence(master.configure(plans)), "");
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_EQ(master.position_of(i), 2 - i);
    EXPECT_EQ(master.slaves()[2 - i].plan.name, "axis " + std::to_string(i));
  }
  EXPECT_FALSE(master.position_of(3));
}

TEST(PlanByAlias, RefusesAnAliasThatIsThereTwice) {
  EditedLine drives(3, [](std::size_t, auto& profile) { set_alias(profile, 4); });
  ScannedMaster master(drives.line(), drives.clock);
  std::vector<ecat_master::SlavePlan> plans(1);
  plans[0].alias = 4;
  EXPECT_EQ(sentence(master.configure(plans)), "slave 0 and slave 1 both answer to alias 4");
}

TEST(PlanByDeviceId, FindsTheDriveByItsIdentificationSelector) {
  EditedLine drives(3, [](std::size_t drive, auto& profile) {
    if (drive != 1) profile.device_id = static_cast<std::uint16_t>(100 + drive);
  });
  ScannedMaster master(drives.line(), drives.clock);
  std::vector<ecat_master::SlavePlan> plans(3);
  plans[0].device_id = 102;
  plans[1].device_id = 100;
  ASSERT_EQ(sentence(master.configure(plans)), "");
  EXPECT_EQ(master.position_of(0), 2U);
  EXPECT_EQ(master.position_of(1), 0U);
  EXPECT_EQ(master.position_of(2), 1U);
  EXPECT_FALSE(master.slaves()[1].info.device_id) << "does not know the request";
  plans[1].device_id = 55;
  EXPECT_EQ(sentence(master.configure(plans)), "planned slave 1 (device ID 55) is not on the line");
}

TEST(PlanByDeviceId, LeavesTheStatesAlone) {
  EditedLine drives(2, [](std::size_t, auto& profile) { profile.device_id = 9; });
  PreOpMaster master(drives.line(), drives.clock);
  ASSERT_EQ(sentence(master.identify_devices()), "");
  EXPECT_EQ(master.slaves()[0].info.device_id, 9);
  for (const std::size_t i : {0U, 1U}) EXPECT_EQ(drives.slave(i).state(), AlState::kPreOp);
}

TEST(WrongWiring, InAndOutSwappedIsRefusedUnlessMeant) {
  slaves::Wiring wiring(3);
  wiring.connect_master(slaves::MasterPort::kPrimary, {0, 0});
  wiring.connect({0, 1}, {1, 1});
  wiring.connect({1, 0}, {2, 0});
  slaves::LineOptions options;
  for (const bool meant : {false, true}) {
    DriveLine drives(3, {}, options, wiring);
    ecat_master::Master::Settings settings;
    settings.accept_swapped_ports = meant;
    ScannedMaster master(drives.line(), drives.clock, settings);
    std::vector<ecat_master::SlavePlan> plans(3);
    EXPECT_EQ(sentence(master.configure(plans)),
              meant ? "" : "slave 2: IN and OUT are swapped, frames come in at port 1");
  }
}

TEST(BadEeprom, WithAWrongChecksumIsNamedAndTheOthersAreFound) {
  EditedLine drives(3, [](std::size_t drive, auto& profile) {
    if (drive == 1) profile.sii_image[14] ^= std::byte{0x55};
  });
  ScannedMaster master(drives.line(), drives.clock);
  ASSERT_TRUE(master.slaves()[1].info.problem);
  EXPECT_THAT(
      describe(*master.slaves()[1].info.problem),
      testing::MatchesRegex(
          "slave 1: EEPROM checksum is 0x[0-9A-F]{2}, 0x[0-9A-F]{2} is expected: the slave ignores the content"));
  EXPECT_EQ(master.slaves()[1].info.description.serial_number, 1001U) << "the content is shown all the same";
  EXPECT_FALSE(master.slaves()[0].info.problem);
  EXPECT_EQ(master.slaves()[2].info.description.serial_number, 1002U);
  // With a plan and without: the error is about the EEPROM, not about the identity or a state change time-out.
  const auto wrong = describe(*master.slaves()[1].info.problem);
  EXPECT_EQ(sentence(master.configure({})), wrong);
  std::vector<ecat_master::SlavePlan> plans(3);
  for (auto& plan : plans) plan.vendor_id = 0x28;
  plans[1].product_code = 0x12345678;
  const auto began = drives.clock.now();
  EXPECT_EQ(sentence(master.configure(plans)), wrong);
  EXPECT_LT(drives.clock.now() - began, std::chrono::seconds{1}) << "the slave is not waited for";
  EXPECT_THAT(master.comparison().differences, testing::ElementsAre(Difference{Kind::kEeprom, 1, kNone, 1}));
}

TEST(BadEeprom, WithCategoriesThatLeadNowhereIsNamed) {
  EditedLine drives(2, [](std::size_t drive, auto& profile) {
    // The first category claims the maximum length of the format.
    if (drive == 0) profile.sii_image[2 * 0x41] = profile.sii_image[2 * 0x41 + 1] = std::byte{0x7F};
  });
  ScannedMaster master(drives.line(), drives.clock);
  ASSERT_TRUE(master.slaves()[0].info.problem);
  EXPECT_FALSE(master.slaves()[0].info.usable());
  EXPECT_THAT(describe(*master.slaves()[0].info.problem), testing::StartsWith("slave 0: EEPROM content is not usable"));
  EXPECT_EQ(master.slaves()[1].info.description.serial_number, 1001U);
  EXPECT_THAT(sentence(master.enter_pre_op()), testing::StartsWith("slave 0: EEPROM content is not usable"));
  std::vector<ecat_master::SlavePlan> plans(2);
  for (auto& plan : plans) plan.vendor_id = 0x28;
  EXPECT_THAT(sentence(master.configure(plans)), testing::StartsWith("slave 0: EEPROM content is not usable"));
}

TEST(BadEeprom, ThatIsBlankIsNamed) {
  EditedLine drives(2, [](std::size_t drive, auto& profile) {
    if (drive == 1) std::fill(profile.sii_image.begin(), profile.sii_image.end(), std::byte{0xFF});
  });
  ScannedMaster master(drives.line(), drives.clock);
  std::vector<ecat_master::SlavePlan> plans(2);
  for (auto& plan : plans) plan.vendor_id = 0x28;
  EXPECT_EQ(sentence(master.configure(plans)), "slave 1: EEPROM is blank: all bytes are 0xFF");
}

TEST(BadEeprom, IsADifferenceOfItsOwnWhereverThePlanIsByAlias) {
  EditedLine drives(3, [](std::size_t drive, auto& profile) {
    set_alias(profile, static_cast<std::uint16_t>(10 + drive));
    if (drive == 2) profile.sii_image[2 * 0x41] = profile.sii_image[2 * 0x41 + 1] = std::byte{0x7F};
  });
  ScannedMaster master(drives.line(), drives.clock);
  std::vector<ecat_master::SlavePlan> plans(3);
  for (std::size_t i = 0; i < 3; ++i) plans[i].alias = static_cast<std::uint16_t>(10 + i);
  EXPECT_THAT(sentence(master.configure(plans)), testing::StartsWith("slave 2: EEPROM content is not usable"));
  EXPECT_THAT(master.comparison().differences, testing::ElementsAre(Difference{Kind::kEeprom, 2, kNone, kNone},
                                                                    Difference{Kind::kMissing, kNone, kNone, 2}));
}

TEST(BadEeprom, IsInTheDiagnosisAndSoAreDuplicateAliases) {
  EditedLine drives(4, [](std::size_t drive, auto& profile) {
    if (drive != 1) set_alias(profile, 77);
    if (drive == 1) profile.sii_image[14] ^= std::byte{0x55};
  });
  ScannedMaster master(drives.line(), drives.clock);
  const auto diagnosis = ecat_master::diagnose(master, nullptr, nullptr);
  ASSERT_EQ(sentence(diagnosis), "");
  EXPECT_THAT(diagnosis->problems,
              testing::ElementsAre(testing::StartsWith("slave 1: EEPROM checksum is 0x"),
                                   "alias 77: slaves 0, 2 and 3 have it, it does not identify any of them"));
  for (const auto& problem : diagnosis->problems) {
    EXPECT_THAT(to_text(*diagnosis), testing::HasSubstr("  " + problem + "\n"));
  }
  EXPECT_THAT(to_text(*diagnosis), testing::Not(testing::HasSubstr("no problem is known")));
}

TEST(BadEeprom, WithoutCategoriesIsASlaveWithoutMailbox) {
  EditedLine drives(2, [](std::size_t drive, auto& profile) {
    if (drive != 0) return;
    profile.sii_image.resize(2 * 0x40);
    profile.sii_image.resize(2 * 0x44, std::byte{0xFF});
  });
  ScannedMaster master(drives.line(), drives.clock);
  EXPECT_TRUE(master.slaves()[0].info.usable());
  EXPECT_TRUE(master.slaves()[0].info.description.sync_managers.empty());
  EXPECT_EQ(master.slaves()[0].info.description.vendor_id, 0x28U);
}

TEST(ChangedIdentity, IsRefusedByThePlanThatWorkedBefore) {
  EditedLine drives(2, [](std::size_t drive, auto& profile) {
    if (drive == 1) profile.sii_image[2 * 0x0C] = std::byte{0x77};  // revision, low byte
  });
  ScannedMaster master(drives.line(), drives.clock);
  std::vector<ecat_master::SlavePlan> plans(2);
  for (auto& plan : plans) plan.revision = IdentityRule::equal(slaves::msd::kRevision);
  EXPECT_THAT(sentence(master.configure(plans)),
              testing::MatchesRegex("slave 1: revision is 0x[0-9A-F]{6}77 but 0x[0-9A-F]{8} is planned"));
}

TEST(Bootstrap, OpensTheMailboxesOfThatState) {
  EditedLine drives(2, [](std::size_t, auto& profile) {
    auto image = esi::decode_sii(profile.sii_image).value();
    image.bootstrap_mailbox = {0x1000, 256, 0x1200, 256};
    profile.sii_image = esi::encode_sii(image);
    using Use = slaves::SyncManagerLayout::Use;
    profile.bootstrap_mailboxes = {{Use::kMailboxOut, 0x1000, 64, 512, 256}, {Use::kMailboxIn, 0x1200, 64, 512, 256}};
  });
  ScannedMaster master(drives.line(), drives.clock);
  ASSERT_EQ(sentence(enter_bootstrap(master.mailboxes(), master.slaves()[1].info)), "");
  EXPECT_EQ(drives.slave(1).state(), AlState::kBootstrap);
  EXPECT_EQ(drives.slave(0).state(), AlState::kInit) << "one slave of the line, not all";
  ASSERT_EQ(sentence(master.enter_pre_op()), "") << "and back";
  EXPECT_EQ(drives.slave(1).state(), AlState::kPreOp);
}

TEST(Bootstrap, IsRefusedToASlaveWithoutIt) {
  DriveLine drives(1);
  ScannedMaster master(drives.line(), drives.clock);
  auto slave = master.slaves()[0].info;
  slave.description.bootstrap_rx_size = slave.description.bootstrap_tx_size = 0;
  EXPECT_EQ(sentence(enter_bootstrap(master.mailboxes(), slave)),
            "slave 0: has no mailbox for BOOT: its EEPROM defines none for the bootstrap state");
  EXPECT_EQ(drives.state(0), AlState::kInit);
}

}  // namespace
}  // namespace driveline::bus_test
