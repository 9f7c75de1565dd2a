// The six methods of acknowledging a fault (MSD manual 13.2), and faults that cannot be acknowledged (4.7: the point).
#include <functional>

#include "drive_rig.hpp"

namespace driveline::slaves::msd {
namespace {

using testing::ElementsAre;

class MsdAcknowledge : public testing::Test {
 protected:
  MsdAcknowledge() {
    EXPECT_EQ(rig.write(0x2068, 0, 1, 2), 0U);  // ISD03: reset
    rig.operate();
    trip();
  }
  /// A watchdog time-out, whose cause has ended when it is reported.
  void trip() {
    rig.device.fall_back(AlState::kOp, AlState::kSafeOp, AlStatusCode::kSyncManagerWatchdog);
    rig.pass(1ms);
    rig.fetch_emergencies();
    rig.emergencies.clear();
    ASSERT_EQ(rig.drive.state(), PowerState::kFault);
    ASSERT_EQ(rig.drive.display(), "Er 14 01") << "without the point: can be acknowledged";
  }
  void expect_acknowledged() {
    rig.pass(1ms);
    EXPECT_EQ(rig.drive.state(), PowerState::kSwitchOnDisabled);
    EXPECT_EQ(rig.drive.display(), "2");
    rig.fetch_emergencies();
    EXPECT_THAT(rig.emergencies, ElementsAre(ElementsAre(0, 0, 0, 0, 0, 0, 0, 0))) << "Table 13.2, once";
    EXPECT_EQ(rig.read(0x603F), 0U);
    EXPECT_EQ(rig.read(0x1001), 0U);
    EXPECT_EQ(rig.read(0x1003), 1U) << "the history stays";
    EXPECT_EQ(rig.status & 0x08, 0) << "the fault bit of the status word";
  }
  void expect_fault(const char* why) {
    rig.pass(1ms);
    EXPECT_EQ(rig.drive.state(), PowerState::kFault) << why;
    rig.fetch_emergencies();
    EXPECT_THAT(rig.emergencies, testing::IsEmpty()) << why;
  }
  /// The same with a lasting cause: the fault returns with its emergency after every method (13.3), until the cause has
  /// ended.
  void expect_only_after_remedy(const std::function<void()>& acknowledge) {
    const FaultFacts& f = facts(Fault::kEncoder);
    rig.drive.set_cause(Fault::kEncoder, true);
    rig.pass(5ms);
    ASSERT_EQ(rig.drive.display(), "Er. 10 01") << "with the point";
    rig.fetch_emergencies();
    rig.emergencies.clear();
    acknowledge();
    rig.pass(1ms);
    EXPECT_EQ(rig.drive.state(), PowerState::kFault);
    EXPECT_EQ(rig.drive.display(), "Er. 10 01");
    rig.fetch_emergencies();
    ASSERT_THAT(rig.emergencies, testing::SizeIs(2));
    EXPECT_THAT(rig.emergencies[0], ElementsAre(0, 0, 0, 0, 0, 0, 0, 0));
    EXPECT_THAT(rig.emergencies[1], ElementsAre(f.error_code & 0xFFU, f.error_code >> 8U, f.error_register | 1U,
                                                f.number, f.location, 0, 0, 0));
    rig.emergencies.clear();
    rig.drive.set_cause(Fault::kEncoder, false);
    rig.pass(1ms);
    EXPECT_EQ(rig.drive.display(), "Er 10 01") << "the point goes with the cause, the fault does not";
    acknowledge();
    rig.pass(1ms);
    EXPECT_EQ(rig.drive.state(), PowerState::kSwitchOnDisabled);
    rig.fetch_emergencies();
    EXPECT_THAT(rig.emergencies, ElementsAre(ElementsAre(0, 0, 0, 0, 0, 0, 0, 0)));
  }
  DriveRig rig;
};

TEST_F(MsdAcknowledge, Way1ControlWordBit7) {
  ASSERT_EQ(rig.write(0x6040, 0, 0x80, 2), 0U);
  expect_acknowledged();
  trip();
  ASSERT_EQ(rig.write(0x6040, 0, 0x8F, 2), 0U);
  expect_fault("still set: no edge");
  ASSERT_EQ(rig.write(0x6040, 0, 0x00, 2), 0U);
  expect_fault("the falling edge");
  ASSERT_EQ(rig.write(0x28A0, 0, 0x80, 2), 0U);  // P 2208 is the same object
  expect_acknowledged();
  expect_only_after_remedy([this] { rig.set({{0x6040, 0, 0x00, 2}, {0x6040, 0, 0x80, 2}}); });
}

TEST_F(MsdAcknowledge, Way2InputWithResetFunction) {
  const auto press = [this] {
    rig.drive.set_input(Input::kIsd03, false);
    rig.drive.set_input(Input::kIsd03, true);
  };
  rig.drive.set_input(Input::kIsd02, true);
  expect_fault("an input without the function");
  press();
  expect_acknowledged();
  trip();
  expect_fault("a level is no edge");
  rig.drive.set_input(Input::kIsd03, false);
  expect_fault("the falling edge");
  press();
  expect_acknowledged();
  expect_only_after_remedy(press);
}

TEST_F(MsdAcknowledge, Way3RisingEdgeOfEnpo) {
  const auto cycle = [this] {
    rig.drive.set_enpo(false);
    rig.pass(1ms);
    rig.drive.set_enpo(true);
  };
  rig.drive.set_enpo(false);
  expect_fault("the falling edge");
  rig.drive.set_enpo(true);
  expect_acknowledged();
  trip();
  rig.drive.set_isdsh(false);
  rig.drive.set_isdsh(true);
  expect_fault("ISDSH is none");
  cycle();
  expect_acknowledged();
  expect_only_after_remedy(cycle);
}

TEST_F(MsdAcknowledge, Way4ButtonsUnderTheDisplay) {
  rig.drive.press_buttons();
  expect_acknowledged();
  expect_only_after_remedy([this] { rig.drive.press_buttons(); });
}

TEST_F(MsdAcknowledge, Way6ParameterP153) {
  ASSERT_EQ(rig.write(0x2099, 0, 0, 1), 0U);
  expect_fault("0 does nothing");
  ASSERT_EQ(rig.write(0x2099, 0, 1, 1), 0U);
  expect_acknowledged();
  EXPECT_EQ(rig.read(0x2099), 0U);
  EXPECT_EQ(rig.write(0x2099, 0, 2, 1), 0x06090031U);
  expect_only_after_remedy([this] { ASSERT_EQ(rig.write(0x2099, 0, 1, 1), 0U); });
}

TEST_F(MsdAcknowledge, CommandsWithoutTheEdgeLeaveTheFaultAlone) {
  for (const std::uint32_t word : {0x00U, 0x06U, 0x07U, 0x0FU, 0x02U}) {
    ASSERT_EQ(rig.write(0x6040, 0, word, 2), 0U);
    expect_fault("no bit 7");
  }
}

TEST_F(MsdAcknowledge, NothingHappensWhileTheReactionRuns) {
  expect_fault("to begin with");
  ASSERT_EQ(rig.write(0x2099, 0, 1, 1), 0U);
  expect_acknowledged();
  rig.to(AlState::kSafeOp, AlState::kOp);
  rig.command(0);
  rig.run_at(10'000'000);
  rig.device.fall_back(AlState::kOp, AlState::kSafeOp, AlStatusCode::kSyncManagerWatchdog);
  rig.pass(5ms);
  ASSERT_EQ(rig.drive.state(), PowerState::kFaultReactionActive);
  const double speed = rig.drive.velocity_rad_s();
  rig.drive.press_buttons();
  rig.pass(1ms);
  EXPECT_EQ(rig.drive.state(), PowerState::kFaultReactionActive);
  EXPECT_LT(rig.drive.velocity_rad_s(), speed) << "the ramp goes on";
  rig.pass(100ms);
  EXPECT_EQ(rig.drive.state(), PowerState::kFault) << "what was pressed before is not remembered";
}

TEST_F(MsdAcknowledge, HistoryIsClearedByWritingZero) {
  EXPECT_EQ(rig.write(0x1003, 0, 1, 1), 0x06090030U);
  EXPECT_EQ(rig.write(0x1003, 0, 0, 1), 0U);
  EXPECT_EQ(rig.read(0x1003, 1), 0U);
}

}  // namespace
}  // namespace driveline::slaves::msd
