// Touch probe (MSD manual 14.1): the function alone with timing diagrams, then in the drive.
#include "driveline/slaves/msd/core/touch_probe.hpp"

#include "drive_rig.hpp"

namespace driveline::slaves::msd {
namespace {

using Variant = TouchProbe::Variant;

// 60B8h of the CiA 402 variant.
constexpr std::uint16_t kActive1 = 0x0001;
constexpr std::uint16_t kContinuous1 = 0x0002;
constexpr std::uint16_t kZero1 = 0x0004;
constexpr std::uint16_t kPositive1 = 0x0010;
constexpr std::uint16_t kNegative1 = 0x0020;

struct Probe {
  TouchProbe probe;
  Variant variant = Variant::kCia402;
  std::uint16_t control(std::uint16_t function) {
    probe.control(variant, function);
    return probe.status();
  }
  std::uint16_t edge(std::size_t which, bool rising, std::int32_t position) {
    probe.edge(which, rising, position);
    return probe.status();
  }
  std::int32_t value(unsigned which) { return probe.value(static_cast<TouchProbe::Value>(which)); }
};

TEST(TouchProbeCia402, SingleTriggerModeLatchesOncePerArming) {
  Probe p;
  EXPECT_EQ(p.edge(0, true, 1), 0) << "not active";
  EXPECT_EQ(p.control(kActive1 | kPositive1 | kNegative1), 0x0001);
  EXPECT_EQ(p.edge(0, true, 10), 0x0003);
  EXPECT_EQ(p.edge(0, false, 20), 0x0007);
  EXPECT_EQ(p.edge(0, true, 30), 0x0007);
  EXPECT_EQ(p.edge(0, false, 40), 0x0007);
  EXPECT_EQ(p.value(0), 10);
  EXPECT_EQ(p.value(1), 20);
  EXPECT_EQ(p.control(0), 0x0000);
  EXPECT_EQ(p.value(0), 10) << "the value stays";
  EXPECT_EQ(p.control(kActive1 | kPositive1), 0x0001);
  EXPECT_EQ(p.edge(0, true, 50), 0x0003);
  EXPECT_EQ(p.value(0), 50);
}

TEST(TouchProbeCia402, SwitchingTheEdgeOffAndOnArmsAgain) {
  Probe p;
  p.control(kActive1 | kPositive1);
  p.edge(0, true, 10);
  EXPECT_EQ(p.control(kActive1), 0x0001);
  EXPECT_EQ(p.control(kActive1 | kPositive1), 0x0001);
  EXPECT_EQ(p.edge(0, true, 20), 0x0003);
  EXPECT_EQ(p.value(0), 20);
}

TEST(TouchProbeCia402, ContinuousTriggerModeTakesEveryEdgeAndToggles) {
  Probe p;
  p.control(kActive1 | kContinuous1 | kPositive1 | kNegative1);
  EXPECT_EQ(p.edge(0, true, 10), 0x0001 | 0x0002 | 0x0040);
  EXPECT_EQ(p.edge(0, false, 20), 0x0001 | 0x0002 | 0x0040 | 0x0004 | 0x0080);
  EXPECT_EQ(p.edge(0, true, 30), 0x0001 | 0x0002 | 0x0004 | 0x0080);
  EXPECT_EQ(p.value(0), 30);
  EXPECT_EQ(p.edge(0, false, 40), 0x0001 | 0x0002 | 0x0004);
  EXPECT_EQ(p.value(1), 40);
}

TEST(TouchProbeCia402, SecondProbeHasTheBitsEightPlacesHigher) {
  Probe p;
  EXPECT_EQ(p.control(static_cast<std::uint16_t>((kActive1 | kContinuous1 | kPositive1 | kNegative1) << 8)), 0x0100);
  EXPECT_EQ(p.edge(0, true, 5), 0x0100) << "the other input";
  EXPECT_EQ(p.edge(1, true, 10), 0x0100 | 0x0200 | 0x4000);
  EXPECT_EQ(p.edge(1, false, 20), 0x0100 | 0x0200 | 0x4000 | 0x0400 | 0x8000);
  EXPECT_EQ(p.value(2), 10);
  EXPECT_EQ(p.value(3), 20);
}

TEST(TouchProbeCia402, OnlyTheSelectedEdgeCounts) {
  Probe p;
  p.control(kActive1 | kNegative1);
  EXPECT_EQ(p.edge(0, true, 10), 0x0001);
  EXPECT_EQ(p.edge(0, false, 20), 0x0005);
}

TEST(TouchProbeCia402, ZeroPulseReplacesTheInputAndHasOnlyARisingEdge) {
  Probe p;
  p.control(kActive1 | kZero1 | kPositive1 | kNegative1);
  EXPECT_EQ(p.edge(0, true, 10), 0x0001);
  p.probe.zero_pulse(77);
  EXPECT_EQ(p.probe.status(), 0x0003);
  EXPECT_EQ(p.value(0), 77);
  EXPECT_EQ(p.value(1), 0);
  p.control(0);
  p.control((kActive1 | kZero1 | kPositive1) << 8);
  p.probe.zero_pulse(88);
  EXPECT_EQ(p.value(2), 88);
}

TEST(TouchProbeCia402, UnusedBitsOfTheFunctionDoNothing) {
  Probe p;
  EXPECT_EQ(p.control(0xC8C8), 0x0000);
  p.edge(0, true, 10);
  p.edge(1, true, 10);
  p.probe.zero_pulse(10);
  EXPECT_EQ(p.probe.status(), 0x0000);
}

class TouchProbeVendor : public testing::TestWithParam<Variant> {
 protected:
  TouchProbeVendor() { p.variant = GetParam(); }
  Probe p;
};

TEST_P(TouchProbeVendor, FiveLatchesAreArmedByTheirBitsAndReadByTheirNumber) {
  EXPECT_EQ(p.control(0x001F), 0x0000);
  EXPECT_EQ(p.edge(0, true, 100), 0x0001);
  EXPECT_EQ(p.edge(0, false, 200), 0x0003);
  EXPECT_EQ(p.edge(1, true, 300), 0x0007);
  EXPECT_EQ(p.edge(1, false, 400), 0x000F);
  p.probe.zero_pulse(500);
  EXPECT_EQ(p.probe.status(), 0x001F);
  for (unsigned i = 0; i < 4; ++i) EXPECT_EQ(p.value(i), 0) << "nothing read yet";
  const bool all_in_first = GetParam() == Variant::kBeck2;
  for (unsigned code = 1; code <= 5; ++code) {
    EXPECT_EQ(p.control(static_cast<std::uint16_t>(0x001F | code << 8)), 0x001F | code << 8);
    const unsigned object = all_in_first || code == 5 ? 0 : code - 1;
    EXPECT_EQ(p.value(object), static_cast<std::int32_t>(100 * code));
  }
  EXPECT_EQ(p.control(0x001F), 0x001F) << "no request, no acknowledgement";
}

TEST_P(TouchProbeVendor, ANewMeasurementNeedsTheBitResetAndSetAgain) {
  p.control(0x0001);
  p.edge(0, true, 100);
  EXPECT_EQ(p.edge(0, true, 200), 0x0001);
  p.control(0x0101);
  EXPECT_EQ(p.value(0), 100);
  EXPECT_EQ(p.control(0x0000), 0x0000);
  EXPECT_EQ(p.control(0x0001), 0x0000);
  EXPECT_EQ(p.edge(0, true, 300), 0x0001);
  p.control(0x0101);
  EXPECT_EQ(p.value(0), 300);
}

TEST_P(TouchProbeVendor, ReadingWhatIsNotValidIsNotAcknowledged) {
  p.control(0x0003);
  p.edge(0, true, 100);
  EXPECT_EQ(p.control(0x0203), 0x0001);
  EXPECT_EQ(p.control(0x0603), 0x0001) << "no such latch";
  EXPECT_EQ(p.control(0xE0E3), 0x0001) << "reserved bits stay 0";
}

INSTANTIATE_TEST_SUITE_P(Variants, TouchProbeVendor, testing::Values(Variant::kBeck2, Variant::kSpecific));

class MsdTouchProbe : public testing::Test {
 protected:
  MsdTouchProbe() {
    rig.set({{0x206A, 0, 15, 2}, {0x206B, 0, 15, 2}});
    rig.operate();
    rig.run_at(10'000'000);
  }
  /// Runs for `cycles` and changes the input in the middle of a control cycle; returns the axis position at that time.
  double change(Input input, bool level, std::chrono::nanoseconds into) {
    const double before = rig.drive.position_rad();
    EXPECT_TRUE(rig.drive.schedule_input(input, level, rig.now + into));
    rig.cycle();
    const double after = rig.drive.position_rad();
    const double share = static_cast<double>(into.count()) / 125e3;
    return (before + share * (after - before)) * kIncrementsPerRadian;
  }
  DriveRig rig;
};

TEST_F(MsdTouchProbe, LatchesBetweenTheControlCycles) {
  ASSERT_EQ(rig.write(0x60B8, 0, 0x3131, 2), 0U);
  rig.cycle();
  EXPECT_EQ(rig.read(0x60B9), 0x0101U);
  const double p1 = change(Input::kIsd05, true, 20us);
  const double p2 = change(Input::kIsd06, true, 93us);
  const double n1 = change(Input::kIsd05, false, 61us);
  const double n2 = change(Input::kIsd06, false, 117us);
  EXPECT_EQ(rig.read(0x60B9), 0x0707U);
  // One cycle is 1250 increments: the latch is 100 times finer.
  EXPECT_NEAR(static_cast<std::int32_t>(rig.read(0x60BA)), p1, 6.0);
  EXPECT_NEAR(static_cast<std::int32_t>(rig.read(0x60BB)), n1, 6.0);
  EXPECT_NEAR(static_cast<std::int32_t>(rig.read(0x60BC)), p2, 6.0);
  EXPECT_NEAR(static_cast<std::int32_t>(rig.read(0x60BD)), n2, 6.0);
}

TEST_F(MsdTouchProbe, ZeroPulseIsAWholeRevolution) {
  ASSERT_EQ(rig.write(0x60B8, 0, 0x0015, 2), 0U);
  rig.cycles(1600);
  EXPECT_EQ(rig.read(0x60B9), 0x0003U);
  EXPECT_EQ(rig.read(0x60BA) % 1048576U, 0U);
  EXPECT_NE(rig.read(0x60BA), 0U);
}

TEST_F(MsdTouchProbe, NeedsTheProbeFunctionAtItsTerminal) {
  rig.set({{0x206A, 0, 0, 2}, {0x60B8, 0, 0x1111, 2}});
  rig.cycle();
  change(Input::kIsd05, true, 20us);
  EXPECT_EQ(rig.read(0x60B9), 0x0101U);
  change(Input::kIsd06, true, 20us);
  EXPECT_EQ(rig.read(0x60B9), 0x0301U);
}

TEST_F(MsdTouchProbe, SelectorChoosesTheVariant) {
  rig.set({{0x28ED, 0, 2, 2}, {0x60B8, 0, 0x0004, 2}});
  rig.cycle();
  const double position = change(Input::kIsd06, true, 40us);
  EXPECT_EQ(rig.read(0x60B9), 0x0004U);
  ASSERT_EQ(rig.write(0x60B8, 0, 0x0304, 2), 0U);
  rig.cycle();
  EXPECT_EQ(rig.read(0x60B9), 0x0304U);
  EXPECT_NEAR(static_cast<std::int32_t>(rig.read(0x60BA)), position, 6.0);
  ASSERT_EQ(rig.write(0x28ED, 0, 0, 2), 0U);
  rig.cycle();
  EXPECT_EQ(rig.read(0x60B9), 0U);
  EXPECT_EQ(rig.write(0x28ED, 0, 4, 2), 0x06090031U);
}

TEST_F(MsdTouchProbe, ObjectsCanBeMapped) {
  DriveRig fresh;
  fresh.map(0x1600, {0x60B80010});
  fresh.map(0x1A00, {0x60B90010, 0x60BA0020});
  fresh.map(0x1A01, {0x60BB0020, 0x60BC0020});
  fresh.map(0x1A02, {0x60BD0020});
  EXPECT_EQ(fresh.device.process_data_size(3), 18U);
}

TEST(MsdTouchProbeSwitch, SwitchOfTheMachineIsLatchedAtItsEdge) {
  MsdParameters parameters;
  parameters.switches = {{Input::kIsd05, 3.0, 4.0}};
  DriveRig rig(parameters);
  rig.set({{0x206A, 0, 15, 2}, {0x60B8, 0, 0x0031, 2}});
  rig.operate();
  rig.run_at(5'000'000);
  EXPECT_EQ(rig.read(0x60B9), 0x0007U);
  EXPECT_NEAR(rig.read(0x60BA), 3.0 * kIncrementsPerRadian, 1.0);
  EXPECT_NEAR(rig.read(0x60BB), 4.0 * kIncrementsPerRadian, 1.0);
}

TEST(MsdInputs, ScheduledChangesHappenInOrderAndAreLimited) {
  DriveRig rig;
  EXPECT_TRUE(rig.drive.schedule_input(Input::kIsd00, false, rig.now + 3ms));
  EXPECT_TRUE(rig.drive.schedule_input(Input::kIsd00, true, rig.now + 1ms));
  rig.pass(2ms);
  EXPECT_EQ(rig.read(0x2079) & 2U, 2U);
  rig.pass(2ms);
  EXPECT_EQ(rig.read(0x2079) & 2U, 0U);
  for (int i = 0; i < 16; ++i) EXPECT_TRUE(rig.drive.schedule_input(Input::kIsd01, i % 2 == 0, rig.now + 1s));
  EXPECT_FALSE(rig.drive.schedule_input(Input::kIsd01, true, rig.now + 1s));
}

}  // namespace
}  // namespace driveline::slaves::msd
