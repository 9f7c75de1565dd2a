// Each persona, asked by datagrams: what a slave with it answers, and what a slave without it answers. The bytes are
// written out by hand from ETG.1000.4, ETG.1000.6 and CiA 301.
#include <algorithm>
#include <array>
#include <set>

#include "persona_rig.hpp"

namespace driveline::slaves {
namespace {

using Kind = PersonaKind;
using wire::Command;

void enter_pre_op(PersonaRig& rig) {
  EXPECT_EQ(rig.pre_op(), "0002 0000");
}

// Object dictionary

template <unsigned kIndex, unsigned kSub, unsigned... kValue>
std::string download(PersonaRig& rig) {
  enter_pre_op(rig);
  return rig.download(kIndex, kSub, {kValue...});
}

template <unsigned kIndex, unsigned kSub>
std::string upload(PersonaRig& rig) {
  enter_pre_op(rig);
  return rig.upload(kIndex, kSub);
}

/// The neighbour of a missing assignment object.
template <unsigned kMissing, unsigned kPresent>
std::string assignments(PersonaRig& rig) {
  enter_pre_op(rig);
  const auto missing = rig.upload(kMissing, 0);
  return missing + ", " + rig.upload(kPresent, 0);
}

/// Two and three entries in 1A00h: statusword, mode display and torque.
std::string three_entries(PersonaRig& rig) {
  enter_pre_op(rig);
  rig.download(0x1A00, 0, {0});
  rig.download(0x1A00, 1, {0x10, 0x00, 0x41, 0x60});
  rig.download(0x1A00, 2, {0x08, 0x00, 0x61, 0x60});
  rig.download(0x1A00, 3, {0x10, 0x00, 0x77, 0x60});
  const auto two = rig.download(0x1A00, 0, {2});
  rig.download(0x1A00, 0, {0});
  return two + ", " + rig.download(0x1A00, 0, {3});
}

/// Two and three PDOs in 1C13h.
std::string three_pdos(PersonaRig& rig) {
  enter_pre_op(rig);
  rig.download(0x1C13, 0, {0});
  rig.download(0x1C13, 1, {0x00, 0x1A});
  rig.download(0x1C13, 2, {0x01, 0x1A});
  rig.download(0x1C13, 3, {0x02, 0x1A});
  const auto two = rig.download(0x1C13, 0, {2});
  rig.download(0x1C13, 0, {0});
  return two + ", " + rig.download(0x1C13, 0, {3});
}

std::string complete_upload(PersonaRig& rig) {
  enter_pre_op(rig);
  return rig.sdo({0x50, 0x18, 0x10, 0, 0, 0, 0, 0}).substr(0, 23);
}

// Mailbox

std::string three_counters(PersonaRig& rig) {
  enter_pre_op(rig);
  std::string counters;
  for (int i = 0; i < 3; ++i) {
    rig.mail({0x00, 0x20, 0x40, 0x00, 0x10, 0, 0, 0, 0, 0});
    rig.pass(1ms);
    counters += rig.next_counter();
  }
  return counters;
}

/// The counters of three answers to requests that count 5, 6 and 7.
std::string counters_after_other_requests(PersonaRig& rig) {
  rig.count_from(4);
  return three_counters(rig);
}

std::string answers_after(PersonaRig& rig, std::chrono::nanoseconds first, std::chrono::nanoseconds second) {
  enter_pre_op(rig);
  std::string result;
  for (const auto time : {first, second}) {
    rig.pass(time);
    const bool answers = rig.upload(0x1000, 0) != "none";
    result += answers ? "answer " : "none ";
  }
  return result;
}

std::string before_and_after_70_ms(PersonaRig& rig) {
  return answers_after(rig, 20ms, 60ms);
}

std::string six_requests(PersonaRig& rig) {
  enter_pre_op(rig);
  std::string result;
  for (int i = 0; i < 6; ++i) result += rig.upload(0x1000, 0) != "none" ? "a" : "-";
  return result;
}

std::string answer_after_30_and_50_ms(PersonaRig& rig) {
  enter_pre_op(rig);
  std::string result;
  rig.mail({0x00, 0x20, 0x40, 0x00, 0x10, 0, 0, 0, 0, 0});
  for (const auto time : {30ms, 20ms}) {
    rig.pass(time);
    result += rig.next_mail() != "none" ? "answer " : "none ";
  }
  return result;
}

/// The first two messages after a request, without the counters and the value of 1000h.
std::string two_messages(PersonaRig& rig) {
  enter_pre_op(rig);
  std::string result;
  rig.mail({0x00, 0x20, 0x40, 0x00, 0x10, 0, 0, 0, 0, 0});
  for (int i = 0; i < 2; ++i) {
    rig.pass(1ms);
    auto message = rig.next_mail();
    if (message.size() > 36) message = message.substr(6, 5) + " / " + message.substr(18, 17);
    result += message + "; ";
  }
  return result;
}

/// Messages that wait in PREOP, without a request.
std::string waiting_messages(PersonaRig& rig) {
  enter_pre_op(rig);
  std::string result;
  for (int i = 0; i < 3; ++i) {
    rig.pass(1ms);
    const auto message = rig.next_mail();
    result += (message == "none" ? message : message.substr(18, 17)) + "; ";
  }
  return result;
}

// State machine

/// Two transitions to SAFEOP, without process data: the PDOs of the drive are empty.
std::string two_requests_of_safeop(PersonaRig& rig) {
  enter_pre_op(rig);
  const auto first = rig.request(0x04);
  return first + ", " + rig.request(0x14);
}

std::string pre_op_after_30_and_60_ms(PersonaRig& rig) {
  const auto early = rig.pre_op(30ms);
  rig.pass(30ms);
  return early + ", " + PersonaRig::hex(rig.word(0x0130), 4);
}

std::string safeop_without_sync(PersonaRig& rig) {
  enter_pre_op(rig);
  return rig.request(0x04);
}

/// PREOP without and with access of the application to the EEPROM.
std::string pre_op_without_and_with_the_eeprom(PersonaRig& rig) {
  const auto first = rig.pre_op();
  rig.request(0x11);
  rig.write(0x0500, {1});
  return first + ", " + rig.pre_op();
}

// EEPROM

/// Enable bytes and types of the first four sync managers.
std::string sync_managers(PersonaRig& rig) {
  const auto content = rig.category(41);
  if (content == 0) return "none";
  std::string result;
  for (unsigned n = 0; n < 4; ++n) {
    const auto enable_and_type = rig.eeprom_word(content + 4 * n + 3);
    result += PersonaRig::hex(enable_and_type & 0xFFU, 1) + PersonaRig::hex(enable_and_type >> 8, 1) + " ";
  }
  return result;
}

std::string pdo_categories(PersonaRig& rig) {
  return std::string(rig.category(50) != 0 ? "inputs " : "") + (rig.category(51) != 0 ? "outputs " : "") +
         (rig.category(41) != 0 ? "sync managers" : "");
}

std::string categories(PersonaRig& rig) {
  return PersonaRig::hex(rig.eeprom_word(0x40), 4) == "FFFF" ? "none" : "some";
}

/// Numbers of the strings of the first RxPDO and its first entry.
std::string names(PersonaRig& rig) {
  const auto content = rig.category(51);
  const bool pdo = (rig.eeprom_word(content + 2) >> 8) != 0;
  const bool entry = (rig.eeprom_word(content + 5) >> 8) != 0;
  return std::string(pdo ? "named" : "unnamed") + (entry ? " named" : " unnamed");
}

std::string mailbox_words(PersonaRig& rig) {
  return PersonaRig::text(rig.eeprom(0x18));
}

/// Status bit 6 of 0502h: 8 bytes per read.
std::string bytes_per_read(PersonaRig& rig) {
  rig.eeprom(0x08);
  return (rig.word(0x0502) & 0x0040U) != 0 ? "8" : "4";
}

std::string busy_after_3_and_6_ms(PersonaRig& rig) {
  rig.write(0x0502, {0x00, 0x01});
  std::string result;
  for (int i = 0; i < 2; ++i) {
    rig.pass(3ms);
    result += (rig.word(0x0502) & 0x8000U) != 0 ? "busy " : "idle ";
  }
  return result;
}

// Slave controller

/// Bits 2 and 3 of 0008h: distributed clock, of 64 bits.
std::string clock(PersonaRig& rig) {
  const auto features = rig.word(0x0008);
  return std::string((features & 0x04U) != 0 ? "clock " : "none ") + ((features & 0x08U) != 0 ? "64" : "32");
}

std::string fmmus(PersonaRig& rig) {
  return std::to_string(rig.read(0x0004, 1)[0]);
}

/// Working counters of LRD and LRW to a byte of process RAM that an FMMU maps.
std::string logical_commands(PersonaRig& rig) {
  rig.write(0x0600, {0, 0, 1, 0, 1, 0, 0, 7, 0x00, 0x18, 0, 1, 1, 0, 0, 0});
  std::string result;
  for (const auto command : {Command::kLrd, Command::kLrw}) {
    std::vector<std::byte> data(1);
    result += std::to_string(rig.send(command, 0x00010000, data)) + " ";
  }
  return result;
}

// Drive profile: statusword and mode display, mapped into 1A00h and read from sync manager 3 in SAFEOP.

void map_status_and_mode(PersonaRig& rig) {
  enter_pre_op(rig);
  for (const auto& step : std::initializer_list<std::pair<unsigned, std::vector<unsigned>>>{
           {0, {0}}, {1, {0x10, 0x00, 0x41, 0x60}}, {2, {0x08, 0x00, 0x61, 0x60}}, {0, {2}}}) {
    EXPECT_EQ(rig.download(0x1A00, step.first, step.second).substr(0, 2), "60");
  }
  for (const auto& step :
       std::initializer_list<std::pair<unsigned, std::vector<unsigned>>>{{0, {0}}, {1, {0x00, 0x1A}}, {0, {1}}}) {
    EXPECT_EQ(rig.download(0x1C13, step.first, step.second).substr(0, 2), "60");
  }
  rig.write(0x0818, {0x00, 0x1A, 3, 0, 0x20, 0, 1, 0});
  EXPECT_EQ(rig.request(4), "0004 0000");
}

std::string statusword_bit(PersonaRig& rig, unsigned bit) {
  map_status_and_mode(rig);
  const auto inputs = rig.read(0x1A00, 3);
  return ((inputs[0] | inputs[1] << 8) >> bit & 1U) != 0 ? "1" : "0";
}

std::string warning_bit(PersonaRig& rig) {
  return statusword_bit(rig, 7);
}

std::string follow_bit(PersonaRig& rig) {
  return statusword_bit(rig, 12);
}

/// The displayed mode 40 ms and 80 ms after the mode has become 9 (CSV).
std::string mode_display(PersonaRig& rig) {
  map_status_and_mode(rig);
  rig.pass(200ms);
  rig.download(0x6060, 0, {9});
  std::string result;
  for (int i = 0; i < 2; ++i) {
    rig.pass(39ms);
    result += PersonaRig::text({rig.read(0x1A00, 3)[2]}) + " ";
  }
  return result;
}

/// A persona with a value other than its default where it has one, and the two answers.
struct Row {
  Persona persona;
  std::string (*observe)(PersonaRig&);
  const char* with;
  const char* without;
  const char* device = "";  ///< name in the example file; empty: a drive
};

const std::vector<Row>& rows() {
  static const std::vector<Row> kRows = {
      {{Kind::kSyncTypeReadOnly}, download<0x1C33, 1, 2, 0>, "80 33 1C 01 02 00 01 06", "60 33 1C 01 00 00 00 00"},
      {{Kind::kSyncTypeUnsupported}, download<0x1C32, 1, 2, 0>, "80 32 1C 01 00 00 01 06", "60 32 1C 01 00 00 00 00"},
      {{Kind::kSyncTypeByState}, download<0x1C32, 1, 2, 0>, "80 32 1C 01 22 00 00 08", "60 32 1C 01 00 00 00 00"},
      {{Kind::kSyncCycleReadOnly},
       download<0x1C32, 2, 0x48, 0xE8, 1, 0>,
       "80 32 1C 02 02 00 01 06",
       "60 32 1C 02 00 00 00 00",
       "MX4"},
      {{Kind::kSyncCycleLimited},
       download<0x1C32, 2, 0x48, 0xE8, 1, 0>,
       "80 32 1C 02 30 00 09 06",
       "60 32 1C 02 00 00 00 00",
       "MX4"},
      {{Kind::kNoSyncObjects}, upload<0x1C33, 1>, "80 33 1C 01 00 00 02 06", "4B 33 1C 01 00 00 00 00"},
      {{Kind::kNoInterpolationTime}, download<0x60C2, 2, 0xFD>, "80 C2 60 02 00 00 02 06", "60 C2 60 02 00 00 00 00"},
      {{Kind::kInterpolationTimeReadOnly},
       download<0x60C2, 2, 0xFD>,
       "80 C2 60 02 02 00 01 06",
       "60 C2 60 02 00 00 00 00"},
      {{Kind::kInterpolationTimeLimited}, download<0x60C2, 1, 4>, "80 C2 60 01 30 00 09 06", "60 C2 60 01 00 00 00 00"},
      {{Kind::kNoOutputAssignment, 0x08000000},
       assignments<0x1C12, 0x1C13>,
       "80 12 1C 00 00 00 00 08, 4F 13 1C 00 04 00 00 00",
       "4F 12 1C 00 04 00 00 00, 4F 13 1C 00 04 00 00 00"},
      {{Kind::kNoInputAssignment, 0x06010001},
       assignments<0x1C13, 0x1C12>,
       "80 13 1C 00 01 00 01 06, 4F 12 1C 00 04 00 00 00",
       "4F 13 1C 00 04 00 00 00, 4F 12 1C 00 04 00 00 00"},
      {{Kind::kNoSyncManagerTypes}, upload<0x1C00, 3>, "80 00 1C 03 00 00 02 06", "4F 00 1C 03 03 00 00 00"},
      {{Kind::kFixedAssignment, 0x08000021},
       download<0x1C13, 0, 0>,
       "80 13 1C 00 21 00 00 08",
       "60 13 1C 00 00 00 00 00"},
      {{Kind::kFixedMapping, 0x06010002}, download<0x1A03, 0, 0>, "80 03 1A 00 02 00 01 06", "60 03 1A 00 00 00 00 00"},
      {{Kind::kMappingLimit, 2},
       three_entries,
       "60 00 1A 00 00 00 00 00, 80 00 1A 00 42 00 04 06",
       "60 00 1A 00 00 00 00 00, 60 00 1A 00 00 00 00 00"},
      {{Kind::kAssignmentLimit, 2},
       three_pdos,
       "60 13 1C 00 00 00 00 00, 80 13 1C 00 42 00 04 06",
       "60 13 1C 00 00 00 00 00, 60 13 1C 00 00 00 00 00"},
      {{Kind::kOverstatedAssignment, 2},
       assignments<0x1C12, 0x1C13>,
       "4F 12 1C 00 06 00 00 00, 4F 13 1C 00 06 00 00 00",
       "4F 12 1C 00 04 00 00 00, 4F 13 1C 00 04 00 00 00"},
      {{Kind::kNoCompleteAccess}, complete_upload, "80 18 10 00 04 00 01 06", "51 18 10 00 12 00 00 00", "MX4"},
      {{Kind::kFourByteAnswers}, upload<0x1C00, 3>, "43 00 1C 03 03 00 00 00", "4F 00 1C 03 03 00 00 00"},
      {{Kind::kAnswersWithoutSize}, upload<0x1C00, 3>, "42 00 1C 03 03 00 00 00", "4F 00 1C 03 03 00 00 00"},
      {{Kind::kConstantCounter, 5}, three_counters, "555", "123"},
      {{Kind::kRequestCounter}, counters_after_other_requests, "567", "123"},
      {{Kind::kJumpingCounter}, three_counters, "473", "123"},
      {{Kind::kDeafAfterPreOp, 70}, before_and_after_70_ms, "none answer ", "answer answer "},
      {{Kind::kLostRequests, 3}, six_requests, "aa-aa-", "aaaaaa"},
      {{Kind::kLateAnswers, 40}, answer_after_30_and_50_ms, "none answer ", "answer none "},
      {{Kind::kRequestsToMaster},
       two_messages,
       "00 00 / 00 20 40 00 10 00; 00 00 / 00 30 43 00 10 00; ",
       "00 00 / 00 30 43 00 10 00; none; "},
      {{Kind::kMessagesToSlave, 0x1203},
       two_messages,
       "03 12 / 00 20 40 00 10 00; 00 00 / 00 30 43 00 10 00; ",
       "00 00 / 00 30 43 00 10 00; none; "},
      {{Kind::kEmergencies, 2}, waiting_messages, "00 10 20 32 04 00; 00 10 20 32 04 00; none; ", "none; none; none; "},
      {{Kind::kStaleMessage}, waiting_messages, "00 30 43 00 10 00; none; none; ", "none; none; none; "},
      {{Kind::kSafeOpRefusedOnce, 0x0024}, two_requests_of_safeop, "0012 0024, 0004 0000", "0004 0000, 0004 0000"},
      {{Kind::kSlowTransitions, 50}, pre_op_after_30_and_60_ms, "0001 0000, 0002", "0002 0000, 0002"},
      {{Kind::kNeedsSync0}, safeop_without_sync, "0012 0030", "0004 0000"},
      {{Kind::kEepromForApplication},
       pre_op_without_and_with_the_eeprom,
       "0011 0050, 0002 0000",
       "0002 0000, 0002 0000"},
      {{Kind::kEepromTypesSwapped}, sync_managers, "11 12 14 13 ", "11 12 13 14 ", "MX4"},
      {{Kind::kEepromTypesZero}, sync_managers, "10 10 10 10 ", "11 12 13 14 ", "MX4"},
      {{Kind::kEepromDisabled}, sync_managers, "11 12 03 04 ", "11 12 13 14 ", "MX4"},
      {{Kind::kEepromWithoutPdos}, pdo_categories, "sync managers", "inputs outputs sync managers", "MX4"},
      {{Kind::kEepromWithoutCategories}, categories, "none", "some", "MX4"},
      {{Kind::kEepromWithoutNames}, names, "unnamed unnamed", "named named", "MX4"},
      {{Kind::kEepromWithoutMailbox}, mailbox_words, "00 00 00 00 00 00 00 00", "00 10 00 01 00 11 00 01", "MX4"},
      {{Kind::kEepromReads4Bytes}, bytes_per_read, "4", "8"},
      {{Kind::kSlowEeprom, 5000}, busy_after_3_and_6_ms, "busy idle ", "idle idle "},
      {{Kind::kClock32Bit}, clock, "clock 32", "clock 64"},
      {{Kind::kNoClock}, clock, "none 32", "clock 64"},
      {{Kind::kNoLrw}, logical_commands, "1 0 ", "1 1 "},
      {{Kind::kFewFmmus, 4}, fmmus, "4", "8"},
      {{Kind::kWarningBit}, warning_bit, "1", "0"},
      {{Kind::kFollowBitAlways}, follow_bit, "1", "0"},
      {{Kind::kLateModeDisplay, 60}, mode_display, "00 09 ", "09 09 "},
  };
  return kRows;
}

void PrintTo(const Row& row, std::ostream* out) {
  *out << persona_row(row.persona.kind).name << ", value " << row.persona.value;
}

class Personas : public testing::TestWithParam<Row> {
 protected:
  static std::string answer(const Row& row, const std::vector<Persona>& personas) {
    PersonaRig rig(personas, *row.device == '\0' ? drive() : example_device(row.device));
    return row.observe(rig);
  }
};

TEST_P(Personas, DoWhatTheirRowSays) {
  EXPECT_EQ(answer(GetParam(), {GetParam().persona}), GetParam().with);
  EXPECT_EQ(answer(GetParam(), {}), GetParam().without);
  EXPECT_STRNE(GetParam().with, GetParam().without);
}

INSTANTIATE_TEST_SUITE_P(Each, Personas, testing::ValuesIn(rows()), [](const auto& of_row) {
  std::string name(persona_row(of_row.param.persona.kind).name);
  std::replace(name.begin(), name.end(), '-', '_');
  return name;
});

TEST(PersonaTable, EachRowHasATest) {
  std::set<Kind> tested;
  for (const auto& row : rows()) tested.insert(row.persona.kind);
  EXPECT_EQ(tested.size(), kPersonaCount);
}

TEST(PersonaTable, NamesAreDifferentAndValuesWithinTheirLimits) {
  std::set<std::string_view> names;
  for (const auto& row : kPersonas) {
    EXPECT_TRUE(names.insert(row.name).second) << row.name;
    EXPECT_FALSE(row.source.empty()) << row.name;
    if (row.value.meaning.empty()) continue;
    EXPECT_GE(row.value.standard, row.value.lowest) << row.name;
    EXPECT_LE(row.value.standard, row.value.highest) << row.name;
  }
}

TEST(PersonaSlave, WithoutPersonasIsTheDeviceItself) {
  auto device = drive();
  const auto* expected = device.get();
  EXPECT_EQ(&make_persona_slave(std::move(device), {}, {})->device(), expected);
}

TEST(PersonaSlave, CombinesPersonas) {
  PersonaRig rig({{Kind::kConstantCounter, 6}, {Kind::kFixedAssignment, 0x06010002}, {Kind::kNoClock}}, drive());
  EXPECT_EQ(clock(rig), "none 32");
  EXPECT_EQ(three_counters(rig), "666");
  EXPECT_EQ(rig.download(0x1C12, 0, {0}), "80 12 1C 00 02 00 01 06");
}

/// A device without the persona takes a request with the counter of the one before for its repetition.
TEST(PersonaSlave, RefusedRequestsDoNotHideLaterOnes) {
  PersonaRig rig({{Kind::kFixedAssignment, 0x06010002}}, drive());
  enter_pre_op(rig);
  EXPECT_EQ(rig.upload(0x1C00, 1), "4F 00 1C 01 01 00 00 00");
  for (int i = 0; i < 6; ++i) EXPECT_EQ(rig.download(0x1C13, 0, {0}), "80 13 1C 00 02 00 01 06") << i;
  EXPECT_EQ(rig.upload(0x1C00, 2), "4F 00 1C 02 02 00 00 00") << "the seventh after the last one, with its counter";
}

TEST(PersonaSlave, DropsRepetitionsOfARequest) {
  for (const unsigned index : {0x1C13U, 0x1C00U}) {  // refused, and answered by the device
    PersonaRig rig({{Kind::kNoInputAssignment, 0x06020000}}, drive());
    enter_pre_op(rig);
    const std::vector<unsigned> request = {0x00, 0x20, 0x40, index & 0xFFU, index >> 8, 0, 0, 0, 0, 0};
    rig.count_from(2);
    rig.mail(request);
    rig.pass(1ms);
    EXPECT_NE(rig.next_mail(), "none");
    rig.count_from(2);
    rig.mail(request);
    rig.pass(1ms);
    EXPECT_EQ(rig.next_mail(), "none") << index;
  }
}

TEST(PersonaSlave, StartsAgainAfterPowerOff) {
  auto slave = make_persona_slave(drive(), {}, std::vector<Persona>{{Kind::kSafeOpRefusedOnce, 0x0052}});
  EXPECT_EQ(slave->device().transition(wire::AlState::kPreOp, wire::AlState::kSafeOp),
            wire::AlStatusCode::kExternalHardwareNotReady);
  EXPECT_EQ(slave->device().transition(wire::AlState::kPreOp, wire::AlState::kSafeOp), wire::AlStatusCode::kNoError);
  slave->set_power(false, 2s);
  slave->set_power(true, 3s);
  EXPECT_EQ(slave->device().transition(wire::AlState::kPreOp, wire::AlState::kSafeOp),
            wire::AlStatusCode::kExternalHardwareNotReady);
}

}  // namespace
}  // namespace driveline::slaves
