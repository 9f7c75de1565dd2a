// What drives say after a refused state, and what drives do that answer with anything.
#include "driveline/ecat_master/configuration/state_refusal.hpp"

#include <gmock/gmock.h>

#include <string>
#include <vector>

#include "support/mail_bench.hpp"

namespace driveline::ecat_master {
namespace {

using ecat_master_test::MailBench;
using testing::ElementsAre;
using testing::HasSubstr;

/// A slave at position 3 with two drives whose mailboxes have room for 60 bytes; it has refused a state.
struct RefusalBench : MailBench {
  static constexpr std::uint16_t kMailbox = 66;
  RefusalBench() : MailBench(wire::MailboxType::kSoe, kMailbox, kMailbox) {
    slaves.resize(1);
    slaves[0].info.ref = {3, 0x1004};
    slaves[0].info.description.mailbox.soe = true;
    slaves[0].info.description.mailbox.soe_channels = 2;
    slaves[0].mailbox = std::make_unique<MailboxClient>(
        mailbox.engine(), SlaveRef{3, 0x1004},
        MailboxWindow{
            ecat_master_test::ScriptedMailbox::kOut, kMailbox, ecat_master_test::ScriptedMailbox::kIn, kMailbox, {}});
  }

  std::string explain(wire::AlState requested = wire::AlState::kSafeOp) {
    const facts::StateRefused refused{.requested = requested, .code = wire::AlStatusCode::kInvalidInputConfiguration};
    return describe(explain_by_drives(mailbox.engine(), slaves, {refused, 3}, notes));
  }
  std::vector<std::string> noted() const {
    std::vector<std::string> sentences;
    for (const auto& note : notes) sentences.push_back(describe(note));
    return sentences;
  }

  std::vector<ConfiguredSlave> slaves;
  StartupNotes notes;
};

constexpr auto kPlain = "AL status code 0x001E (invalid input configuration)";

struct HostileCase {
  const char* name;
  std::vector<std::string_view> answers;  ///< to the requests, in order; then the slave is silent
  const char* ends;                       ///< end of the sentence
};

/// The attribute of a list of IDNs is asked for first, then the list.
const std::vector<HostileCase> kHostile{
    {"Silent", {}, kPlain},
    {"OtherDrive", {"2204 1500 0100 5500"}, kPlain},
    {"OtherIdn", {"0204 1600 0100 5500"}, kPlain},
    {"OtherElement", {"0240 1500 0100 5500"}, kPlain},
    {"CutHeader", {"0204 15"}, kPlain},
    {"NoList", {"0204 1500 0100 1100", "0240 1500 0100"}, "lists S-0-0001"},
    {"LengthBeyondContent", {"0204 1500 0100 5500", "0240 1500 FFFFFFFF 0100"}, kPlain},
    {"OddLength", {"0204 1500 0100 5500", "0240 1500 03000800 010001"}, kPlain},
    {"FragmentsThatDoNotCount", {"0204 1500 0100 5500", "0A40 0500 04000400 0100", "0A40 0500 0200"}, kPlain},
    {"AnswerOfAWrite", {"0404 1500"}, kPlain},
    {"Notifications", {"0501 6300 0300"}, kPlain},
    {"ThenSilent", {"0204 1500 0100 5500", "0240 1500 02000800 6400"}, "; S-0-0021 of drive 0 lists S-0-0100"},
    {"DatumThatIsNone",
     {"0204 1500 0100 5500", "0240 1500 02000800 6400", "1204 6400 0110"},
     "; S-0-0021 of drive 0 lists S-0-0100"},
};

TEST(StateRefusalOfHostileDrives, StaysWhatItWasWithinTheTime) {
  for (const auto& c : kHostile) {
    RefusalBench bench;
    bench.answer(c.answers);
    const auto begin = bench.slave.now();
    EXPECT_THAT(bench.explain(), testing::EndsWith(c.ends)) << c.name;
    EXPECT_LT(bench.slave.now() - begin, std::chrono::seconds{5}) << c.name;
  }
}

TEST(StateRefusalOfHostileDrives, StormsAndEndlessFragmentsEnd) {
  for (const auto* service :
       {"0501 6300 0300", "0204 1500 0100 5500", "1204 1500 0110", "0A40 FFFF 00", "4600 0000 30"}) {
    RefusalBench bench;
    bench.slave.endless = [&] { return bench.mail(service); };
    const auto begin = bench.slave.now();
    EXPECT_THAT(bench.explain(wire::AlState::kOp), HasSubstr(kPlain)) << service;
    EXPECT_LT(bench.slave.now() - begin, std::chrono::seconds{5}) << service;
  }
}

TEST(StateRefusal, CountsTheDataBeyondTheFirstEight) {
  RefusalBench bench;
  bench.answer({"0204 1500 0100 5500", "0240 1500 14001400 01000200030004000500060007000800090010 80"});
  // The drive refuses to tell more about each of the eight.
  bench.answer({"1204 0100 0110", "1204 0200 0110", "1204 0300 0110", "1204 0400 0110", "1204 0500 0110",
                "1204 0600 0110", "1204 0700 0110", "1204 0800 0110"});
  EXPECT_THAT(bench.explain(), HasSubstr("lists S-0-0001"));
  EXPECT_THAT(bench.noted(),
              testing::IsSupersetOf({"slave 3: drive 0 lists S-0-0001 in S-0-0021 as invalid",
                                     "slave 3: drive 0 lists S-0-0008 in S-0-0021 as invalid; and 2 more"}));
}

TEST(StateRefusal, IsUnchangedWithoutSoeAndForOtherStates) {
  RefusalBench bench;
  EXPECT_THAT(bench.explain(wire::AlState::kPreOp), testing::EndsWith(kPlain));
  bench.slaves[0].info.description.mailbox.soe = false;
  EXPECT_THAT(bench.explain(), testing::EndsWith(kPlain));
  bench.slaves[0].info.description.mailbox.soe = true;
  bench.slaves[0].mailbox.reset();
  EXPECT_THAT(bench.explain(), testing::EndsWith(kPlain));
  EXPECT_TRUE(bench.slave.requests.empty());
}

TEST(StateRefusal, ShowsWhatTheDriveSaysWithoutControlCharacters) {
  RefusalBench bench;
  bench.answer({"1204 1500 0110", "0204 5F00 0100 4400", "0240 5F00 03000300 411B42"});
  EXPECT_THAT(bench.explain(), testing::EndsWith(kPlain));
  EXPECT_THAT(bench.noted(), ElementsAre("slave 3: drive 0 says in S-0-0095: \"A.B\""));
}

}  // namespace
}  // namespace driveline::ecat_master
