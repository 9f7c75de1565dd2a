// Start-up values of drives: the messages on the wire, and drives that do not keep what they accept.
#include <gmock/gmock.h>

#include <string>
#include <vector>

#include "driveline/ecat_master/configuration/configurator.hpp"
#include "support/mail_bench.hpp"

namespace driveline::ecat_master {
namespace {

using bytes_test::hex;
using ecat_master_test::MailBench;
using ecat_master_test::ScriptedMailbox;

/// A slave at position 3 whose mailboxes have room for 60 bytes, and the start-up value of S-0-0100 in drive 1.
struct StartupBench : MailBench {
  static constexpr std::uint16_t kMailbox = 66;
  explicit StartupBench(decltype(StartupIdn::value) value) : MailBench(wire::MailboxType::kSoe, kMailbox, kMailbox) {
    slaves.resize(1);
    auto& one = slaves[0];
    one.info.ref = {3, 0x1004};
    one.info.description.mailbox.soe = true;
    one.mailbox = std::make_unique<MailboxClient>(
        mailbox.engine(), SlaveRef{3, 0x1004},
        MailboxWindow{ScriptedMailbox::kOut, kMailbox, ScriptedMailbox::kIn, kMailbox, {}});
    StartupIdn idn;
    idn.at = {1, {100}};
    idn.value = std::move(value);
    one.plan.startup_idns.push_back(idn);
  }
  std::string write(motion::StartupState in = motion::StartupState::kPreOperational) {
    const auto done = write_startup_idns(mailbox.engine(), slaves, in);
    return done ? "" : describe(done.error());
  }

  std::vector<ConfiguredSlave> slaves;
};

struct AnswerCase {
  const char* name;
  decltype(StartupIdn::value) value;
  std::vector<std::string_view> answers;  ///< to the requests in order; then the drive is silent
  const char* says;
};

constexpr auto kNumber = "2204 6400 0100 1100";  ///< attribute: unsigned, two bytes
constexpr auto kList = "2204 6400 0100 1500";    ///< attribute: list of these
using List = StartupIdn::List;

const std::vector<AnswerCase>& answer_cases() {
  static const std::vector<AnswerCase> kCases{
      {"Kept", "300", {kNumber, "2440 6400", "2240 6400 2C01"}, ""},
      {"ListKept", List{"2", "3"}, {kList, "2240 6400 00000800", "2440 6400", "2240 6400 04000800 02000300"}, ""},
      {"NotKept",
       "300",
       {kNumber, "2440 6400", "2240 6400 2B01"},
       "slave 3: S-0-0100 of drive 1 reads back as 299 after 300 was written"},
      {"ElementNotKept",
       List{"2", "3"},
       {kList, "2240 6400 00000800", "2440 6400", "2240 6400 04000800 02000400"},
       "slave 3: element 1 of S-0-0100 of drive 1 reads back as 4 after 3 was written"},
      {"ListCut",
       List{"2", "3"},
       {kList, "2240 6400 00000800", "2440 6400", "2240 6400 02000800 0200"},
       "slave 3: element 1 of S-0-0100 of drive 1 reads back as 0 after 3 was written"},
      {"ListTooLong",
       List{"2", "3"},
       {kList, "2240 6400 00000300"},
       "slave 3: the list for S-0-0100 of drive 1 has 4 bytes, the drive has room for 3"},
      {"RefusedWithoutLimit",
       "300",
       {kNumber, "3440 6400 0770", "3220 6400 0160"},
       "slave 3: refused S-0-0100 of drive 1 with SoE error 0x7007 (value above its maximum)"},
      {"LengthThatLies",
       List{"2"},
       {kList, "2240 6400 00000800", "2440 6400", "2240 6400 FFFF0800 0200"},
       "slave 3: the 6 bytes of S-0-0100 of drive 1 do not match its attribute"},
      {"OtherDrive",
       "300",
       {"0204 6400 0100 1100"},
       "slave 3: request for S-0-0100 of drive 1 was answered with S-0-0100 of drive 0"},
      {"OtherElement", "300", {"2240 6400 0100 1100"}, "slave 3: sent a malformed mailbox"},
      {"NoAttribute", "300", {"2204 6400"}, "slave 3: the 0 bytes of S-0-0100 of drive 1 do not match its attribute"},
  };
  return kCases;
}

TEST(StartupIdns, AreKeptOrTheStartSaysWhatTheDriveHas) {
  for (const auto& c : answer_cases()) {
    StartupBench bench(c.value);
    bench.answer(c.answers);
    EXPECT_EQ(bench.write(), c.says) << c.name;
    EXPECT_EQ(bench.slave.requests.size(), c.answers.size()) << c.name;
  }
}

TEST(StartupIdns, ListsHaveTheirLengthAndTheMaximumLengthOfTheDrive) {
  StartupBench bench(List{"2", "3"});
  bench.answer({kList, "2240 6400 00000800", "2440 6400", "2240 6400 04000800 02000300"});
  ASSERT_EQ(bench.write(), "");
  EXPECT_EQ(bench.told().at(2), hex("2340 6400 04000800 02000300"));
}

TEST(StartupIdns, BelongToTheirTransition) {
  StartupBench bench("300");
  EXPECT_EQ(bench.write(motion::StartupState::kSafeOperational), "");
  EXPECT_TRUE(bench.slave.requests.empty());
}

TEST(StartupIdns, AreNotReadBackWhereThePlanSaysSo) {
  StartupBench bench("300");
  bench.slaves[0].plan.startup_idns[0].read_back = false;
  bench.answer({kNumber, "2440 6400"});
  EXPECT_EQ(bench.write(), "");
  EXPECT_EQ(bench.slave.requests.size(), 2U);
}

TEST(StartupIdns, ACommandEndsOrIsCancelled) {
  constexpr auto kCommand = "2204 6400 0100 0900";
  struct Case {
    std::vector<std::string_view> answers;
    const char* says;
  };
  const std::vector<Case> cases{
      {{kCommand, "2440 6400", "2201 6400 0700", "2201 6400 0300", "2440 6400"}, ""},
      {{kCommand, "2440 6400", "2201 6400 0F00", "2440 6400"},
       "slave 3: the procedure command S-0-0100 of drive 1 ended in data state 0x000F (failed)"},
  };
  for (const auto& c : cases) {
    StartupBench bench("3");
    bench.answer(c.answers);
    EXPECT_EQ(bench.write(), c.says);
    EXPECT_EQ(bench.told().back(), hex("2340 6400 0000"));
  }
}

TEST(StartupIdns, StormsEndWithinTheTimeLimit) {
  for (const auto* service : {"2501 6400 0300", "2A40 FFFF 00", "2201 6400 0700", "2440 6400"}) {
    StartupBench bench("300");
    bench.slave.endless = [&] { return bench.mail(service); };
    const auto begin = bench.slave.now();
    EXPECT_NE(bench.write(), "") << service;
    EXPECT_LT(bench.slave.now() - begin, std::chrono::seconds{5}) << service;
  }
}

}  // namespace
}  // namespace driveline::ecat_master
