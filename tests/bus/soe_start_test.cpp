// Drives behind SoE that do not start as the master wants: why they refuse a state, and how long they may take.
#include <gmock/gmock.h>

#include <array>
#include <string>
#include <vector>

#include "drive_line.hpp"
#include "driveline/ecat_master/state_machine.hpp"
#include "soe_line.hpp"

namespace driveline::bus_test {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using wire::AlState;
using Bytes = std::vector<std::byte>;

std::vector<std::string> noted(const ecat_master::Master& master) {
  std::vector<std::string> sentences;
  for (const auto& note : master.startup_notes()) sentences.push_back(describe(note));
  return sentences;
}

/// Another tool takes slave 1 to PREOP.
void drop_to_pre_op(SoeLine& line) {
  const std::array ref{line.master.slaves()[1].info.ref};
  ASSERT_EQ(sentence(ecat_master::change_state(line.master.bus(), ref, AlState::kPreOp, std::chrono::seconds{1})), "");
}

TEST(SoeRefusal, OfSafeOpNamesTheDatumWithValueAndLimitsAndWhatTheDriveSays) {
  SoeLine line(drive_by_idn(), {{AlState::kSafeOp, {1}, 1500, 8000}, {AlState::kSafeOp, {100}, 50, 150}});
  ASSERT_EQ(line.to_pre_op(), "");
  ASSERT_EQ(sentence(line.soe(1).write_value({0, {1}}, Bytes{std::byte{0xD0}, std::byte{7}})), "");
  EXPECT_THAT(line.to_safe_op(), HasSubstr("slave 1: requested SAFEOP, is in PREOP + error, AL status code 0x8127"));
  const auto refused = line.to_safe_op();
  EXPECT_THAT(refused, testing::EndsWith("; S-0-0021 of drive 1 lists S-0-0001"));
  EXPECT_THAT(noted(line.master),
              ElementsAre("slave 1: drive 0 says in S-0-0095: \"ready\"",
                          "slave 1: drive 1 lists S-0-0001 (NC cycle time (TNcyc)) in S-0-0021 as invalid: it is 1000 "
                          "us, limits 125 to 64000 us",
                          "slave 1: drive 1 says in S-0-0095: \"parameters invalid\""));
}

TEST(SoeRefusal, EndsWhenTheDatumIsRight) {
  SoeLine line(drive_by_idn(), {{AlState::kSafeOp, {1}, 1500, 8000}});
  ASSERT_THAT(line.to_safe_op(), HasSubstr("S-0-0021 of drive 0 lists S-0-0001"));
  for (const auto drive : std::array<std::uint8_t, 2>{0, 1}) {
    ASSERT_EQ(sentence(line.soe(1).write_value({drive, {1}}, Bytes{std::byte{0xD0}, std::byte{7}})), "");
  }
  EXPECT_EQ(line.to_safe_op(), "");
  EXPECT_THAT(noted(line.master), IsEmpty());
  EXPECT_THAT(*line.soe(1).idn_list({0, {21}}), IsEmpty());
}

TEST(SoeRefusal, OfOpNamesTheDataOfItsOwnList) {
  SoeLine line(drive_by_idn(), {{AlState::kSafeOp, {1}, 500, 8000}, {AlState::kOp, {100}, 300, 400}});
  ASSERT_EQ(line.to_safe_op(), "");
  EXPECT_THAT(line.to_op(),
              testing::AllOf(HasSubstr("slave 1: requested OP, is in SAFEOP + error, AL status code 0x8127"),
                             HasSubstr("; S-0-0022 of drive 0 lists S-0-0100")));
  EXPECT_THAT(noted(line.master),
              testing::Contains("slave 1: drive 1 lists S-0-0100 (Velocity loop proportional gain) in S-0-0022 as "
                                "invalid: it is 100, limits 1 to 10000"));
}

TEST(SoeRefusal, OfASlaveWithoutTheseListsIsToldAsBefore) {
  SoeLine line(drive_by_idn());
  line.stations[1]->al().refuse(AlState::kSafeOp, wire::AlStatusCode::kInvalidInputConfiguration);
  EXPECT_THAT(line.to_safe_op(), testing::EndsWith("AL status code 0x001E (invalid input configuration)"));
  EXPECT_THAT(noted(line.master), ElementsAre("slave 1: drive 0 says in S-0-0095: \"ready\"",
                                              "slave 1: drive 1 says in S-0-0095: \"ready\""));
}

TEST(SoeRefusal, InTheRecoveryNamesTheDatum) {
  SoeLine line(drive_by_idn(), {{AlState::kOp, {100}, 50, 400}});
  ASSERT_EQ(line.to_safe_op(), "");
  ASSERT_EQ(line.to_op(), "");
  ASSERT_EQ(sentence(line.soe(1).write_value({1, {100}}, Bytes{std::byte{0x2C}, std::byte{0}})), "");
  drop_to_pre_op(line);
  const auto recovered = line.master.recover(1, std::chrono::seconds{1});
  EXPECT_THAT(sentence(recovered), testing::EndsWith("; S-0-0022 of drive 1 lists S-0-0100"));
  EXPECT_THAT(noted(line.master), testing::Contains(HasSubstr("it is 44, limits 1 to 10000")));
}

/// A slave that takes `delay` for each transition, the planned time-outs to SAFEOP, and the error.
struct SlowCase {
  std::chrono::seconds delay;
  ecat_master::StateTimeouts::Limit to_safe_op;
  bool soe;
  const char* error;
};

TEST(SoeStateTimeout, IsTwentySecondsUnlessThePlanHasAnother) {
  using std::chrono::seconds;
  const std::vector<SlowCase> cases{
      {seconds{19}, std::nullopt, true, ""},
      {seconds{21}, std::nullopt, true, "requested SAFEOP, is in PREOP and did not change within 20000 ms"},
      {seconds{21}, seconds{30}, true, ""},
      {seconds{19}, seconds{12}, true, "requested SAFEOP, is in PREOP and did not change within 12000 ms"},
      {seconds{11}, std::nullopt, false, "requested SAFEOP, is in PREOP and did not change within 10000 ms"},
  };
  for (const auto& c : cases) {
    auto device = drive_by_idn();
    device.mailbox.soe = c.soe;
    device.mailbox.coe = !c.soe;
    SoeLine line(device);
    line.stations[1]->al().set_transition_delay(c.delay);
    ecat_master::SlavePlan plan;
    plan.own_pdos = true;
    std::vector<ecat_master::SlavePlan> plans{plan, plan};
    plans[1].timeouts.to_pre_op = plans[1].timeouts.back_to_init = seconds{40};
    plans[1].timeouts.to_safe_op = c.to_safe_op;
    const auto error = line.to_safe_op(plans);
    EXPECT_THAT(error, HasSubstr(c.error));
    EXPECT_EQ(error.empty(), *c.error == '\0') << error;
  }
}

/// A start-up value of the drives of slave 1, and what the start says; empty: it is in the drive.
struct StartupCase {
  const char* name;
  ecat_master::StartupIdn idn;
  const char* error;
  Bytes kept;  ///< value of the drive after the start
};

ecat_master::StartupIdn startup(std::uint8_t drive, wire::Idn idn, decltype(ecat_master::StartupIdn::value) value) {
  ecat_master::StartupIdn planned;
  planned.at = {drive, idn};
  planned.value = std::move(value);
  return planned;
}

std::vector<ecat_master::SlavePlan> plans_with(std::vector<ecat_master::StartupIdn> idns) {
  ecat_master::SlavePlan plan;
  plan.own_pdos = true;
  std::vector<ecat_master::SlavePlan> plans{plan, plan};
  plans[1].startup_idns = std::move(idns);
  return plans;
}

Bytes bytes_of(std::initializer_list<unsigned> values) {
  Bytes bytes;
  for (const auto value : values) bytes.push_back(static_cast<std::byte>(value));
  return bytes;
}

using List = ecat_master::StartupIdn::List;

const std::vector<StartupCase>& startup_cases() {
  static const std::vector<StartupCase> kCases{
      {"Number", startup(1, {1}, "2000"), "", bytes_of({0xD0, 7})},
      {"NumberInHexadecimal", startup(0, {100}, "0x012C"), "", bytes_of({0x2C, 1})},
      {"Bytes", startup(1, {100}, bytes_of({0x2C, 1})), "", bytes_of({0x2C, 1})},
      {"BytesOfAList", startup(1, {16}, bytes_of({2, 0, 2, 0, 40, 0})), "", bytes_of({40, 0})},
      {"ListWithoutHeader", startup(1, {16}, bytes_of({40, 0})),
       "slave 1: the value for S-0-0016 of drive 1 does not fit: a list of elements of 2 bytes, IDN, is expected",
       bytes_of({51, 0})},
      {"Text", startup(1, {142}, "crane"), "", bytes_of({'c', 'r', 'a', 'n', 'e'})},
      {"ListOfIdns", startup(1, {16}, List{"S-0-0040", "51"}), "", bytes_of({40, 0, 51, 0})},
      {"EmptyList", startup(0, {24}, List{}), "", {}},
      {"Command", startup(1, {99}, "3"), "", bytes_of({0, 0})},
      {"BelowTheMinimum", startup(1, {1}, "100"),
       "slave 1: refused 100 for S-0-0001 of drive 1, below its lower limit 125", bytes_of({0xE8, 3})},
      {"AboveTheMaximum", startup(1, {100}, "10001"),
       "slave 1: refused 10001 for S-0-0100 of drive 1, above its upper limit 10000", bytes_of({100, 0})},
      {"UnknownIdn",
       startup(1, {0x8BD6}, "1"),
       "slave 1: refused P-0-3030 of drive 1 with SoE error 0x1001 (there is no such IDN)",
       {}},
      {"MissingDrive",
       startup(2, {1}, "2000"),
       "slave 1: refused S-0-0001 of drive 2 with SoE error 0x800A (there is no such drive)",
       {}},
      {"LongList", startup(1, {16}, List{"40", "51", "40"}),
       "slave 1: the list for S-0-0016 of drive 1 has 6 bytes, the drive has room for 4", bytes_of({51, 0})},
      {"TextForANumber", startup(1, {1}, "fast"),
       "slave 1: the value for S-0-0001 of drive 1 does not fit: one number of 2 bytes, unsigned, is expected",
       bytes_of({0xE8, 3})},
      {"ListForANumber", startup(1, {1}, List{"2000"}),
       "slave 1: the value for S-0-0001 of drive 1 does not fit: one number of 2 bytes, unsigned, is expected",
       bytes_of({0xE8, 3})},
      {"NumberForAList", startup(1, {16}, "40"),
       "slave 1: the value for S-0-0016 of drive 1 does not fit: a list of elements of 2 bytes, IDN, is expected",
       bytes_of({51, 0})},
      {"ReadOnly", startup(1, {11}, "1"),
       "slave 1: refused S-0-0011 of drive 1 with SoE error 0x7004 (the value cannot be changed)", bytes_of({0, 0})},
  };
  return kCases;
}

TEST(SoeStartup, WritesTheValueOrSaysWhatWasExpected) {
  for (const auto& c : startup_cases()) {
    SoeLine line(drive_by_idn());
    EXPECT_EQ(line.to_safe_op(plans_with({c.idn})), c.error) << c.name;
    const auto kept = line.soe(1).value(c.idn.at);
    EXPECT_EQ(kept.value_or(Bytes{}), c.kept) << c.name;
  }
}

TEST(SoeStartup, WritesWhatTheCheckOfTheDriveDemands) {
  SoeLine line(drive_by_idn(), {{AlState::kSafeOp, {1}, 1500, 8000}, {AlState::kOp, {100}, 300, 400}});
  auto gain = startup(1, {100}, "350");
  gain.in = motion::StartupState::kSafeOperational;
  auto other = startup(0, {100}, "310");
  other.in = motion::StartupState::kSafeOperational;
  ASSERT_EQ(line.to_safe_op(plans_with({startup(0, {1}, "2000"), startup(1, {1}, "4000"), gain, other})), "");
  EXPECT_EQ(line.soe(1).value({1, {100}}).value(), bytes_of({100, 0})) << "not before SAFEOP";
  EXPECT_EQ(line.to_op(), "");
  EXPECT_EQ(line.soe(1).value({1, {100}}).value(), bytes_of({0x5E, 1}));
}

TEST(SoeStartup, IsWrittenAgainInTheRecovery) {
  SoeLine line(drive_by_idn());
  auto gain = startup(1, {100}, "350");
  gain.in = motion::StartupState::kSafeOperational;
  ASSERT_EQ(line.to_safe_op(plans_with({startup(0, {1}, "2000"), gain})), "");
  ASSERT_EQ(line.to_op(), "");
  ASSERT_EQ(sentence(line.soe(1).write_value({1, {100}}, bytes_of({44, 0}))), "");
  drop_to_pre_op(line);
  ASSERT_EQ(sentence(line.soe(1).write_value({0, {1}}, bytes_of({0xE8, 3}))), "") << "another tool changes it in PREOP";
  ASSERT_EQ(sentence(line.master.recover(1, std::chrono::seconds{1})), "");
  EXPECT_EQ(line.soe(1).value({0, {1}}).value(), bytes_of({0xD0, 7}));
  EXPECT_EQ(line.soe(1).value({1, {100}}).value(), bytes_of({0x5E, 1}));
}

TEST(SoeStartup, NeedsAnSoeMailbox) {
  auto device = soe_device(128);
  device.mailbox.soe = false;
  SoeLine line(device);
  EXPECT_EQ(line.to_safe_op(plans_with({startup(1, {1}, "2000")})), "slave 1: has no SoE mailbox");
}

}  // namespace
}  // namespace driveline::bus_test
