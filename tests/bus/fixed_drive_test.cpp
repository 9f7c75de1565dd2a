// Drives that are not like the manual: fixed, missing or limited objects, errors in the EEPROM, states refused at
// first.
#include "fixed_drive.hpp"

#include <gmock/gmock.h>

#include "driveline/ecat_master/configuration/pdo_discovery.hpp"
#include "driveline/ecat_master/configuration/process_variables.hpp"
#include "driveline/motion/axis/startup_sdos.hpp"

namespace driveline::bus_test {
namespace {

using ecat_master::SlavePlan;
using motion::WriteNeed;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::Not;
using wire::AlState;
using wire::AlStatusCode;
using wire::SdoAbort;
using Way = FixedObject::Way;

std::string abort_text(SdoAbort code) {
  std::array<char, 16> number{};
  std::snprintf(number.data(), number.size(), "0x%08X", static_cast<unsigned>(code));
  return std::string(number.data()) + " (" + std::string(to_text(code)) + ")";
}

SlavePlan own_pdos() {
  SlavePlan plan;
  plan.own_pdos = true;
  return plan;
}

SlavePlan own_pdos_and_period(nanoseconds period, WriteNeed need = WriteNeed::kOptional) {
  auto plan = own_pdos();
  plan.startup_sdos = motion::cia402_startup_sdos(period);
  for (auto& sdo : plan.startup_sdos) sdo.need = need;
  return plan;
}

void remove_60c2(esi::DeviceDescription& device) {
  device.objects.clear();
}

// 60C2h, which is 1 ms (1, -3) at first.

class InterpolationTime : public testing::TestWithParam<SdoAbort> {};

TEST_P(InterpolationTime, ThatIsFixedIsNotedAndTheDriveStarts) {
  FixedDrive drive({{0x60C2, {}, GetParam(), Way::kWrite}});
  EXPECT_EQ(drive.to_safe_op(own_pdos_and_period(milliseconds{2})), "");
  EXPECT_EQ(drive.slave().state(), AlState::kSafeOp);
  EXPECT_THAT(drive.notes(),
              ElementsAre("slave 0: object 60C2h:01 refused 2 with " + abort_text(GetParam()) + " and keeps 1"));
}

INSTANTIATE_TEST_SUITE_P(Codes, InterpolationTime,
                         testing::Values(SdoAbort::kReadOnly, SdoAbort::kUnsupportedAccess, SdoAbort::kValueRange,
                                         SdoAbort::kValueTooLow, SdoAbort::kDeviceState, SdoAbort::kGeneralError));

TEST(InterpolationTimeOfADrive, ThatDoesNotExistIsNotedAndTheDriveStarts) {
  FixedDrive drive({}, remove_60c2);
  EXPECT_EQ(drive.to_safe_op(own_pdos_and_period(milliseconds{2})), "");
  EXPECT_THAT(drive.notes(),
              ElementsAre("slave 0: object 60C2h:01 refused 2 with " + abort_text(SdoAbort::kObjectDoesNotExist)));
}

TEST(InterpolationTimeOfADrive, ThatIsRightAlreadyIsNotWritten) {
  FixedDrive drive({{0x60C2, {}, SdoAbort::kReadOnly, Way::kWrite}});
  EXPECT_EQ(drive.to_safe_op(own_pdos_and_period(milliseconds{1})), "");
  EXPECT_THAT(drive.notes(), IsEmpty());
  EXPECT_THAT(drive.written, IsEmpty());
}

TEST(InterpolationTimeOfADrive, IsWrittenWhereItDiffers) {
  FixedDrive drive;
  EXPECT_EQ(drive.to_safe_op(own_pdos_and_period(milliseconds{2})), "");
  EXPECT_THAT(drive.written, ElementsAre("60C2:01")) << "the exponent is -3 already";
  EXPECT_EQ(drive.value(0x60C2, 1), 2U);
}

/// 25 * 10^-5 s with a fixed exponent of -3 would be 25 ms.
TEST(InterpolationTimeOfADrive, IsNeverHalfOfTheOldAndHalfOfTheNewOne) {
  FixedDrive drive({{0x60C2, 2, SdoAbort::kReadOnly, Way::kWrite}});
  EXPECT_EQ(drive.to_safe_op(own_pdos_and_period(microseconds{250})), "");
  EXPECT_THAT(drive.written, ElementsAre("60C2:01", "60C2:02", "60C2:01"));
  EXPECT_EQ(drive.value(0x60C2, 1), 1U);
  EXPECT_THAT(drive.notes(), ElementsAre("slave 0: object 60C2h:02 refused 251 with " +
                                         abort_text(SdoAbort::kReadOnly) + " and keeps 253"));
}

/// The drive accepts the exponent and forgets it.
TEST(InterpolationTimeOfADrive, IsNeverHalfOfTheNewOneThatWasForgotten) {
  FixedDrive drive;
  auto& device = drive.device();
  const auto pass = device.changes_request;
  device.changes_request = [pass](std::span<std::byte> mailbox) {
    // A download of 60C2h:02: the value becomes -3.
    const bool exponent = mailbox.size() >= 16 && mailbox[8] == std::byte{0x2F} && mailbox[9] == std::byte{0xC2} &&
                          mailbox[10] == std::byte{0x60} && mailbox[11] == std::byte{0x02};
    if (exponent) mailbox[12] = std::byte{0xFD};
    pass(mailbox);
  };
  EXPECT_EQ(drive.to_safe_op(own_pdos_and_period(microseconds{250})), "");
  EXPECT_EQ(drive.value(0x60C2, 1), 1U);
  EXPECT_THAT(drive.notes(), ElementsAre("slave 0: object 60C2h:02 is 253 after 251 was written"));
}

TEST(InterpolationTimeOfADrive, ThatIsMandatoryEndsTheStart) {
  FixedDrive drive({{0x60C2, {}, SdoAbort::kReadOnly, Way::kWrite}});
  EXPECT_EQ(drive.to_safe_op(own_pdos_and_period(milliseconds{2}, WriteNeed::kMandatory)),
            "slave 0: object 60C2h:01 aborted with " + abort_text(SdoAbort::kReadOnly));
}

TEST(InterpolationTimeOfADrive, ThatIsOmittedIsNotWritten) {
  FixedDrive drive;
  EXPECT_EQ(drive.to_safe_op(own_pdos_and_period(milliseconds{2}, WriteNeed::kOmitted)), "");
  EXPECT_THAT(drive.written, IsEmpty());
  EXPECT_THAT(drive.notes(), IsEmpty());
}

// 1C32h and 1C33h: type 0 and a cycle of 125 us at first.

ecat_master::dc::ClockPlan with_sync0() {
  ecat_master::dc::ClockPlan clocks;
  clocks.period = milliseconds{2};
  clocks.slaves.resize(1);
  clocks.slaves[0].signals.assign_activate = ecat_master::dc::kActivateSync0;
  clocks.slaves[0].signals.sync0_cycle = milliseconds{2};
  return clocks;
}

std::string start_with_sync0(FixedDrive& drive, WriteNeed need) {
  drive.master().use_clocks(with_sync0());
  auto plan = own_pdos();
  plan.needs.sync_objects = need;
  return drive.to_safe_op(plan);
}

struct SyncCase {
  const char* name;
  std::uint8_t subindex;
  SdoAbort code;
  const char* wanted_and_kept[2];
};

class SyncObjects : public testing::TestWithParam<SyncCase> {};

TEST_P(SyncObjects, ThatAreRefusedAreNotedAndTheDriveStarts) {
  const auto& row = GetParam();
  FixedDrive drive({{0x1C32, row.subindex, row.code, Way::kWrite}, {0x1C33, row.subindex, row.code, Way::kWrite}});
  EXPECT_EQ(start_with_sync0(drive, WriteNeed::kOptional), "");
  EXPECT_EQ(drive.slave().state(), AlState::kSafeOp);
  const auto refused = [&](const char* object) {
    return std::string("slave 0: object ") + object + ":0" + std::to_string(row.subindex) + " refused " +
           row.wanted_and_kept[0] + " with " + abort_text(row.code) + " and keeps " + row.wanted_and_kept[1];
  };
  EXPECT_THAT(drive.notes(), ElementsAre(refused("1C32h"), refused("1C33h")));
}

TEST_P(SyncObjects, ThatAreMandatoryEndTheStart) {
  const auto& row = GetParam();
  FixedDrive drive({{0x1C32, row.subindex, row.code, Way::kWrite}});
  EXPECT_EQ(start_with_sync0(drive, WriteNeed::kMandatory),
            "slave 0: object 1C32h:0" + std::to_string(row.subindex) + " aborted with " + abort_text(row.code));
}

INSTANTIATE_TEST_SUITE_P(All, SyncObjects,
                         testing::Values(SyncCase{"ReadOnlyType", 1, SdoAbort::kReadOnly, {"2", "0"}},
                                         SyncCase{"UnsupportedType", 1, SdoAbort::kUnsupportedAccess, {"2", "0"}},
                                         SyncCase{"TypeBoundToAState", 1, SdoAbort::kDeviceState, {"2", "0"}},
                                         SyncCase{"LimitedCycle", 2, SdoAbort::kValueRange, {"2000000", "125000"}},
                                         SyncCase{
                                             "CycleBoundToAState", 2, SdoAbort::kDeviceState, {"2000000", "125000"}}),
                         [](const auto& test) { return std::string(test.param.name); });

TEST(SyncObjectsOfADrive, ThatDoNotExistAreNotedOnce) {
  FixedDrive drive({{0x1C32, {}, SdoAbort::kObjectDoesNotExist, Way::kBoth},
                    {0x1C33, {}, SdoAbort::kObjectDoesNotExist, Way::kBoth}});
  EXPECT_EQ(start_with_sync0(drive, WriteNeed::kOptional), "");
  EXPECT_THAT(drive.notes(), ElementsAre(HasSubstr("object 1C32h:01"), HasSubstr("object 1C33h:01")));
}

/// ETG.1020 allows a read-only cycle: the slave takes it from the register.
TEST(SyncObjectsOfADrive, MayHaveAReadOnlyCycle) {
  for (const auto need : {WriteNeed::kOptional, WriteNeed::kMandatory}) {
    FixedDrive drive({{0x1C32, 2, SdoAbort::kReadOnly, Way::kWrite}, {0x1C33, 2, SdoAbort::kReadOnly, Way::kWrite}});
    EXPECT_EQ(start_with_sync0(drive, need), "");
    EXPECT_THAT(drive.notes(), IsEmpty());
  }
}

TEST(SyncObjectsOfADrive, ThatAreOmittedAreNotWritten) {
  FixedDrive drive;
  EXPECT_EQ(start_with_sync0(drive, WriteNeed::kOmitted), "");
  EXPECT_THAT(drive.written, IsEmpty());
}

/// The drive accepts the type and forgets it.
TEST(SyncObjectsOfADrive, ThatKeepAnotherValueAreNoted) {
  FixedDrive drive;
  auto& device = drive.device();
  const auto pass = device.changes_request;
  device.changes_request = [pass](std::span<std::byte> mailbox) {
    // A download of 1C32h:01: the value becomes 0.
    const bool type = mailbox.size() >= 16 && mailbox[8] == std::byte{0x2B} && mailbox[9] == std::byte{0x32} &&
                      mailbox[10] == std::byte{0x1C} && mailbox[11] == std::byte{0x01};
    if (type) mailbox[12] = std::byte{0};
    pass(mailbox);
  };
  EXPECT_EQ(start_with_sync0(drive, WriteNeed::kOptional), "");
  EXPECT_THAT(drive.notes(), ElementsAre("slave 0: object 1C32h:01 is 0 after 2 was written"));
  EXPECT_EQ(start_with_sync0(drive, WriteNeed::kMandatory), "slave 0: object 1C32h:01 is 0 after 2 was written");
}

// The planned PDOs. 1600h and 1601h, 1A00h and 1A01h are assigned at first.

TEST(PlannedPdos, ThatTheDriveHasAssignedAreNotWritten) {
  FixedDrive drive({{0x1C12, {}, SdoAbort::kReadOnly, Way::kWrite}, {0x1C13, {}, SdoAbort::kReadOnly, Way::kWrite}});
  EXPECT_EQ(drive.to_safe_op(plan_with({0x1600, 0x1601}, {0x1A00, 0x1A01})), "");
  EXPECT_THAT(drive.written, IsEmpty());
  EXPECT_THAT(drive.notes(), IsEmpty());
}

TEST(PlannedPdos, AreWrittenOnlyInTheDirectionThatDiffers) {
  FixedDrive drive({{0x1C13, {}, SdoAbort::kReadOnly, Way::kWrite}});
  EXPECT_EQ(drive.to_safe_op(plan_with({0x1602, 0x1600}, {0x1A00, 0x1A01})), "");
  EXPECT_EQ(drive.value(0x1C12, 0), 2U);
  EXPECT_EQ(drive.value(0x1C12, 1), 0x1602U);
  EXPECT_THAT(drive.written, Not(testing::Contains(testing::StartsWith("1C13"))));
  EXPECT_THAT(drive.notes(), IsEmpty());
}

/// A direction without planned PDOs, which the drive does not have either.
TEST(PlannedPdos, NeedNoAssignmentInADirectionWithoutAny) {
  FixedDrive drive({{0x1C13, {}, SdoAbort::kObjectDoesNotExist, Way::kBoth}},
                   [](esi::DeviceDescription& device) { device.tx_pdos.clear(); });
  EXPECT_EQ(drive.to_safe_op(plan_with({0x1600}, {})), "");
  EXPECT_THAT(drive.notes(), IsEmpty());
}

class FixedAssignment : public testing::TestWithParam<SdoAbort> {};

TEST_P(FixedAssignment, ReplacesThePlannedOne) {
  FixedDrive drive({{0x1C12, {}, GetParam(), Way::kWrite}});
  auto plan = plan_with({0x1602}, {0x1A00, 0x1A01});
  plan.pdos.outputs[0].objects.clear();
  EXPECT_EQ(drive.to_safe_op(plan), "");
  EXPECT_EQ(drive.slave().state(), AlState::kSafeOp);
  EXPECT_THAT(drive.notes(),
              ElementsAre("slave 0: object 1C12h:00 refused 0 with " + abort_text(GetParam()),
                          "slave 0: exchanges its own outputs (2 PDOs, 10 bytes), not the planned ones"));
  const auto& used = drive.master().slaves()[0].plan;
  ASSERT_EQ(used.pdos.outputs.size(), 2U);
  EXPECT_EQ(used.pdos.outputs[0].index, 0x1600U);
  EXPECT_EQ(used.pdos.outputs[1].index, 0x1601U);
  const auto later = planned_assignments(drive.master().slaves()[0]);
  ASSERT_EQ(later.size(), 1U) << "when it comes back, only the inputs are compared and written";
  EXPECT_FALSE(later[0].outputs);
}

INSTANTIATE_TEST_SUITE_P(Codes, FixedAssignment,
                         testing::Values(SdoAbort::kReadOnly, SdoAbort::kUnsupportedAccess,
                                         SdoAbort::kSubindexCannotBeWritten, SdoAbort::kDeviceState));

TEST(FixedMapping, ReplacesThePlannedOne) {
  FixedDrive drive({{0x1600, {}, SdoAbort::kReadOnly, Way::kWrite}});
  auto plan = plan_with({0x1600}, {0x1A00, 0x1A01});
  plan.pdos.outputs[0].objects.pop_back();
  EXPECT_EQ(drive.to_safe_op(plan), "");
  EXPECT_EQ(drive.value(0x1C12, 0), 1U) << "the assignment is written";
  EXPECT_THAT(drive.notes(), ElementsAre("slave 0: object 1600h:00 refused 0 with " + abort_text(SdoAbort::kReadOnly),
                                         "slave 0: exchanges its own outputs (1 PDO, 6 bytes), not the planned ones"));
}

/// The drive may lose its assignment with its supply, but never its mapping.
TEST(FixedMapping, IsNotWrittenAgainWhenTheDriveComesBack) {
  FixedDrive drive({{0x1600, {}, SdoAbort::kReadOnly, Way::kWrite}});
  auto plan = plan_with({0x1600}, {0x1A00, 0x1A01});
  plan.pdos.outputs[0].objects.pop_back();
  ASSERT_EQ(drive.to_safe_op(plan), "");
  const auto later = planned_assignments(drive.master().slaves()[0]);
  ASSERT_EQ(later.size(), 2U);
  for (const auto& step : later[0].steps) EXPECT_EQ(step.at.index, 0x1C12U);
}

TEST(FixedMapping, ThatIsThePlannedOneIsNoObstacleToAnotherAssignment) {
  FixedDrive drive({{0x1600, {}, SdoAbort::kReadOnly, Way::kWrite}});
  EXPECT_EQ(drive.to_safe_op(plan_with({0x1600}, {0x1A00, 0x1A01})), "");
  EXPECT_EQ(drive.value(0x1C12, 0), 1U);
  EXPECT_EQ(drive.master().image().places()[0].output_bytes, 6U);
}

/// A drive that accepts changes, but not this one, cannot work as planned.
TEST(PlannedPdos, ThatTheDriveCannotAssignEndTheStart) {
  FixedDrive drive({{0x1C12, 1, SdoAbort::kValueRange, Way::kWrite}});
  EXPECT_EQ(drive.to_safe_op(plan_with({0x1602}, {0x1A00, 0x1A01})),
            "slave 0: object 1C12h:01 aborted with " + abort_text(SdoAbort::kValueRange));
}

TEST(PlannedPdos, ThatAreMandatoryEndTheStart) {
  FixedDrive drive({{0x1C12, {}, SdoAbort::kReadOnly, Way::kWrite}});
  auto plan = plan_with({0x1602}, {0x1A00, 0x1A01});
  plan.needs.pdo_assignment = WriteNeed::kMandatory;
  EXPECT_EQ(drive.to_safe_op(plan), "slave 0: object 1C12h:00 aborted with " + abort_text(SdoAbort::kReadOnly));
}

TEST(PlannedPdos, ThatAreOmittedAreThoseOfTheDrive) {
  FixedDrive drive;
  auto plan = plan_with({0x1602}, {0x1A00});
  plan.needs.pdo_assignment = plan.needs.pdo_mapping = WriteNeed::kOmitted;
  EXPECT_EQ(drive.to_safe_op(plan), "");
  EXPECT_THAT(drive.written, IsEmpty());
  EXPECT_THAT(drive.notes(), ElementsAre("slave 0: exchanges its own outputs (2 PDOs, 10 bytes), not the planned ones",
                                         "slave 0: exchanges its own inputs (2 PDOs, 10 bytes), not the planned ones"));
}

// PDOs that the drive does not show.

struct HiddenCase {
  std::uint16_t object;
  SdoAbort code;
};

class HiddenAssignment : public testing::TestWithParam<HiddenCase> {};

TEST_P(HiddenAssignment, IsThatOfTheEepromInThisDirectionAlone) {
  const auto& row = GetParam();
  FixedDrive drive({{row.object, {}, row.code, Way::kRead}});
  EXPECT_EQ(drive.to_safe_op(own_pdos()), "");
  EXPECT_EQ(drive.slave().state(), AlState::kSafeOp);
  EXPECT_EQ(drive.master().image().places()[0].output_bytes, 10U);
  EXPECT_EQ(drive.master().image().places()[0].input_bytes, 10U);
  const bool outputs = row.object == 0x1C12;
  EXPECT_THAT(drive.notes(),
              ElementsAre(std::string("slave 0: object ") + (outputs ? "1C12" : "1C13") +
                          "h:00 cannot be read, aborted with " + abort_text(row.code) + ": sync manager " +
                          (outputs ? "2" : "3") + " exchanges the 2 PDOs of the description"));
}

INSTANTIATE_TEST_SUITE_P(All, HiddenAssignment,
                         testing::Values(HiddenCase{0x1C12, SdoAbort::kObjectDoesNotExist},
                                         HiddenCase{0x1C13, SdoAbort::kObjectDoesNotExist},
                                         HiddenCase{0x1C12, SdoAbort::kSubindexDoesNotExist},
                                         HiddenCase{0x1C13, SdoAbort::kUnsupportedAccess},
                                         HiddenCase{0x1C12, SdoAbort::kWriteOnly},
                                         HiddenCase{0x1C13, SdoAbort::kDeviceState},
                                         HiddenCase{0x1C12, SdoAbort::kGeneralError}));

TEST(HiddenPdos, OfBothDirectionsAreThoseOfTheEeprom) {
  FixedDrive drive(
      {{0x1C12, {}, SdoAbort::kObjectDoesNotExist, Way::kBoth}, {0x1C13, {}, SdoAbort::kGeneralError, Way::kBoth}});
  EXPECT_EQ(drive.to_safe_op(own_pdos()), "");
  EXPECT_EQ(drive.master().image().places()[0].output_bytes, 10U);
  EXPECT_EQ(drive.master().image().places()[0].input_bytes, 10U);
}

TEST(HiddenPdos, OfADriveWithoutAssignmentObjectsReplaceThePlannedOnes) {
  FixedDrive drive({{0x1C12, {}, SdoAbort::kObjectDoesNotExist, Way::kBoth},
                    {0x1600, {}, SdoAbort::kReadOnly, Way::kWrite},
                    {0x1601, {}, SdoAbort::kReadOnly, Way::kWrite}});
  EXPECT_EQ(drive.to_safe_op(plan_with({0x1600}, {0x1A00, 0x1A01})), "");
  EXPECT_EQ(drive.master().image().places()[0].output_bytes, 10U);
  EXPECT_THAT(drive.notes(), testing::Contains("slave 0: exchanges its own outputs (2 PDOs, 10 bytes), not the planned "
                                               "ones"));
}

TEST(HiddenPdos, WithoutReadableMappingHaveThatOfTheEeprom) {
  FixedDrive drive({{0x1A01, {}, SdoAbort::kGeneralError, Way::kRead}});
  EXPECT_EQ(drive.to_safe_op(own_pdos()), "");
  EXPECT_EQ(drive.master().image().places()[0].input_bytes, 10U);
  EXPECT_THAT(drive.notes(), ElementsAre("slave 0: the mapping of PDO 1A01h cannot be read, aborted with " +
                                         abort_text(SdoAbort::kGeneralError) + ": that of the description is used"));
}

TEST(HiddenPdos, ThatNobodyDescribesEndTheStart) {
  FixedDrive drive({{0x1A01, {}, SdoAbort::kGeneralError, Way::kRead}}, {}, [](esi::SiiImage& image) {
    std::erase_if(image.categories, [](const auto& category) { return category.type == esi::SiiCategoryType::kTxPdo; });
  });
  EXPECT_EQ(drive.to_safe_op(own_pdos()),
            "slave 0: object 1A01h:00 aborted with " + abort_text(SdoAbort::kGeneralError));
}

TEST(HiddenPdos, OfADirectionWithoutAnyAreNotMissed) {
  FixedDrive drive({{0x1C13, {}, SdoAbort::kObjectDoesNotExist, Way::kRead}}, {}, [](esi::SiiImage& image) {
    std::erase_if(image.categories, [](const auto& category) { return category.type == esi::SiiCategoryType::kTxPdo; });
  });
  ASSERT_TRUE(drive.master().scan());
  ASSERT_TRUE(drive.master().enter_pre_op());
  ecat_master::StartupNotes notes;
  const auto& info = drive.master().slaves()[0].info;
  const auto found = read_pdo_configurations(drive.master().mailboxes(), {&info, 1}, notes);
  ASSERT_EQ(sentence(found[0]), "");
  EXPECT_EQ(found[0]->outputs.size(), 2U);
  EXPECT_THAT(found[0]->inputs, IsEmpty());
  EXPECT_THAT(notes, IsEmpty());
}

/// Sub-index 0 says two PDOs, the drive has one.
TEST(HiddenPdos, EndWhereTheListOfTheDriveEnds) {
  FixedDrive drive({{0x1C12, 2, SdoAbort::kSubindexDoesNotExist, Way::kRead}});
  ASSERT_TRUE(drive.master().scan());
  ASSERT_TRUE(drive.master().enter_pre_op());
  ecat_master::StartupNotes notes;
  const auto& info = drive.master().slaves()[0].info;
  const auto found = read_pdo_configurations(drive.master().mailboxes(), {&info, 1}, notes);
  ASSERT_EQ(sentence(found[0]), "");
  ASSERT_EQ(found[0]->outputs.size(), 1U);
  EXPECT_EQ(found[0]->inputs.size(), 2U);
  ASSERT_EQ(notes.size(), 1U);
  EXPECT_EQ(describe(notes[0]), "slave 0: object 1C12h:02 cannot be read, aborted with " +
                                    abort_text(SdoAbort::kSubindexDoesNotExist) +
                                    ": the list should have 2 elements, 1 are used");
}

TEST(HiddenPdos, EndWhereTheListEndsAlsoForATool) {
  FixedDrive drive({{0x1C12, 2, SdoAbort::kSubindexDoesNotExist, Way::kRead}});
  ASSERT_TRUE(drive.master().scan());
  ASSERT_TRUE(drive.master().enter_pre_op());
  ecat_master::CoeClient coe(*drive.master().mailbox(0));
  const auto outputs = read_assigned_pdos(coe, 0x1C12);
  ASSERT_EQ(sentence(outputs), "");
  ASSERT_EQ(outputs->size(), 1U);
  EXPECT_EQ(outputs->front().index, 0x1600);
}

TEST(NothingAssigned, IsNotedForADriveThatHasPdos) {
  FixedDrive drive({}, [](esi::DeviceDescription& device) {
    for (auto* pdos : {&device.rx_pdos, &device.tx_pdos}) {
      for (auto& pdo : *pdos) pdo.sync_manager.reset();
    }
  });
  EXPECT_EQ(drive.to_safe_op(own_pdos()), "");
  EXPECT_THAT(
      drive.notes(),
      ElementsAre(HasSubstr("slave 0: exchanges no process data: of its 5 PDOs none with objects is assigned")));
}

TEST(EntriesWithoutNames, HaveThoseOfTheProfile) {
  FixedDrive drive({}, [](esi::DeviceDescription& device) {
    for (auto* pdos : {&device.rx_pdos, &device.tx_pdos}) {
      for (auto& pdo : *pdos) {
        pdo.name.clear();
        for (auto& entry : pdo.entries) entry.name.clear();
      }
    }
  });
  auto plan = own_pdos();
  plan.name = "drive";
  ASSERT_EQ(drive.to_safe_op(plan), "");
  const ecat_master::ProcessVariables variables(drive.master().slaves(), drive.master().image());
  for (const char* name : {"drive.6041h", "drive.0x607A", "drive.606Ch:00"}) {
    EXPECT_TRUE(variables.find(name).has_value()) << name;
  }
}

// Sync manager types in the EEPROM.

void set_types(esi::SiiImage& image, const std::vector<std::uint8_t>& types) {
  for (auto& category : image.categories) {
    auto* managers = std::get_if<std::vector<esi::SiiSyncManager>>(&category.content);
    for (std::size_t n = 0; managers != nullptr && n < managers->size(); ++n) (*managers)[n].use = types.at(n);
  }
}

struct TypesCase {
  const char* name;
  std::vector<std::uint8_t> types;
  std::size_t notes;
};

class SyncManagerTypes : public testing::TestWithParam<TypesCase> {};

TEST_P(SyncManagerTypes, AreToldByTheControlByte) {
  FixedDrive drive({}, {}, [](esi::SiiImage& image) { set_types(image, GetParam().types); });
  EXPECT_EQ(drive.to_safe_op(own_pdos()), "");
  EXPECT_EQ(drive.slave().state(), AlState::kSafeOp);
  EXPECT_EQ(drive.master().image().places()[0].output_bytes, 10U);
  EXPECT_EQ(drive.master().image().places()[0].input_bytes, 10U);
  EXPECT_EQ(drive.notes().size(), GetParam().notes);
}

INSTANTIATE_TEST_SUITE_P(All, SyncManagerTypes,
                         testing::Values(TypesCase{"AsTheStandardSays", {1, 2, 3, 4}, 0},
                                         TypesCase{"AllMissing", {0, 0, 0, 0}, 4},
                                         TypesCase{"OutputsMissing", {1, 2, 0, 4}, 1},
                                         TypesCase{"ProcessDataSwapped", {1, 2, 4, 3}, 2},
                                         TypesCase{"MailboxesSwapped", {2, 1, 3, 4}, 2}),
                         [](const auto& test) { return std::string(test.param.name); });

TEST(SyncManagerTypesOfADrive, AreNamedInTheNote) {
  FixedDrive drive({}, {}, [](esi::SiiImage& image) { set_types(image, {1, 2, 4, 4}); });
  EXPECT_EQ(drive.to_safe_op(own_pdos()), "");
  EXPECT_THAT(drive.notes(), ElementsAre(testing::MatchesRegex(
                                 "slave 0: sync manager 2 has type 4 \\(inputs\\) in the EEPROM, its "
                                 "control byte 0x[0-9A-F]+ is that of outputs: it is used for outputs")));
}

// SAFEOP that is refused at first.

/// Refuses the first `refusals` requests of SAFEOP; counts all of them.
void refuse_safe_op(FixedDrive& drive, unsigned refusals, AlStatusCode code, unsigned& requests) {
  drive.device().judges = [refusals, code, &requests](AlState from, AlState to) {
    if (from != AlState::kPreOp || to != AlState::kSafeOp) return AlStatusCode::kNoError;
    return requests++ < refusals ? code : AlStatusCode::kNoError;
  };
}

class PassingRefusal : public testing::TestWithParam<AlStatusCode> {};

TEST_P(PassingRefusal, OfSafeOpIsFollowedByAnotherRequest) {
  for (const unsigned refusals : {1U, 2U}) {
    FixedDrive drive;
    unsigned requests = 0;
    refuse_safe_op(drive, refusals, GetParam(), requests);
    EXPECT_EQ(drive.to_safe_op(own_pdos()), "");
    EXPECT_EQ(drive.slave().state(), AlState::kSafeOp);
    EXPECT_EQ(requests, refusals + 1);
    EXPECT_THAT(drive.notes(),
                ElementsAre(testing::StartsWith(
                    refusals == 1 ? "slave 0: reached SAFEOP only after a refusal, AL status code 0x"
                                  : "slave 0: reached SAFEOP only after 2 refusals, AL status code 0x")));
  }
}

TEST_P(PassingRefusal, OfSafeOpThatStaysIsNamedAfterThreeRequests) {
  FixedDrive drive;
  unsigned requests = 0;
  refuse_safe_op(drive, 100, GetParam(), requests);
  EXPECT_THAT(drive.to_safe_op(own_pdos()), testing::StartsWith("slave 0: requested SAFEOP, is in PREOP + error"));
  EXPECT_EQ(requests, 3U);
}

INSTANTIATE_TEST_SUITE_P(Codes, PassingRefusal,
                         testing::Values(AlStatusCode::kUnspecifiedError, AlStatusCode::kNoValidInputs,
                                         AlStatusCode::kInvalidOutputConfiguration,
                                         AlStatusCode::kInvalidInputConfiguration, AlStatusCode::kInvalidInputMapping,
                                         AlStatusCode::kInvalidOutputMapping, AlStatusCode::kPllError,
                                         AlStatusCode::kExternalHardwareNotReady, static_cast<AlStatusCode>(0x8042)));

class LastingRefusal : public testing::TestWithParam<AlStatusCode> {};

TEST_P(LastingRefusal, OfSafeOpIsNotRepeated) {
  FixedDrive drive;
  unsigned requests = 0;
  refuse_safe_op(drive, 1, GetParam(), requests);
  EXPECT_THAT(drive.to_safe_op(own_pdos()), testing::StartsWith("slave 0: requested SAFEOP, is in PREOP + error"));
  EXPECT_EQ(requests, 1U);
}

INSTANTIATE_TEST_SUITE_P(Codes, LastingRefusal,
                         testing::Values(AlStatusCode::kNoValidFirmware, AlStatusCode::kInvalidSyncManagerConfiguration,
                                         AlStatusCode::kInvalidSyncManagerTypes, AlStatusCode::kInconsistentSettings,
                                         AlStatusCode::kInvalidWatchdogConfiguration, AlStatusCode::kNeedsColdStart,
                                         AlStatusCode::kSyncModeNotSupported, AlStatusCode::kDcSync0CycleTime));

TEST(PassingRefusalOfADrive, IsNotRepeatedWithoutRetries) {
  FixedDrive drive;
  unsigned requests = 0;
  refuse_safe_op(drive, 1, AlStatusCode::kNoValidInputs, requests);
  auto plan = own_pdos();
  plan.safe_op_retries.count = 0;
  EXPECT_THAT(drive.to_safe_op(plan), HasSubstr("AL status code 0x0018"));
  EXPECT_EQ(requests, 1U);
}

}  // namespace
}  // namespace driveline::bus_test
