// Actual values that the bus does not send in its cycle wait in the drive until they are read. The reader finds the
// same as in the dictionary of a drive that publishes all values in every cycle.
#include "driveline/slaves/device_status.hpp"

#include <functional>

#include "drive_rig.hpp"
#include "driveline/slaves/msd/core/drive_values.hpp"

namespace driveline::slaves::msd {
namespace {

/// Two drives with the same commands, which send 6064h and the status word only; `complete` publishes everything.
class MsdPublication : public testing::Test {
 protected:
  MsdPublication() {
    static_cast<void>(complete.drive.dictionary());
    both([](DriveRig& rig) {
      rig.map(0x1600, {0x60400010, 0x60600008, 0x28070008, 0x607A0020});
      rig.map(0x1A00, {0x60410010, 0x60610008, 0x28070008, 0x60640020});
      rig.set({{0x2065, 0, 5, 2}, {0x206A, 0, 15, 2}, {0x60B8, 0, 0x11, 2}});
      rig.set({{0x60C2, 1, 125, 1}, {0x60C2, 2, 0xFA, 1}, real_value(0x2132, 0, 0.125F)});
      ASSERT_EQ(rig.to(AlState::kPreOp, AlState::kSafeOp), AlStatusCode::kNoError);
      ASSERT_EQ(rig.to(AlState::kSafeOp, AlState::kOp), AlStatusCode::kNoError);
      rig.enable(8);
    });
    move(200);
  }
  void both(const std::function<void(DriveRig&)>& act) {
    act(lazy);
    act(complete);
  }
  void move(int cycles) {
    for (int i = 0; i < cycles; ++i) {
      both([i](DriveRig& rig) {
        rig.target_position += 10 * (i % 50);
        rig.cycle();
      });
    }
  }
  /// Reads all values that can wait, by SDO, and compares them.
  void expect_same_values() {
    for (const auto& [index, sub] : kObjects) {
      EXPECT_EQ(lazy.read(index, sub), complete.read(index, sub)) << std::hex << index << ':' << sub;
    }
  }

  struct Object {
    std::uint16_t index;
    unsigned sub;
  };
  static constexpr std::array kObjects = {
      Object{0x6062, 0}, Object{0x6064, 0}, Object{0x606B, 0}, Object{0x606C, 0}, Object{0x6074, 0}, Object{0x6077, 0},
      Object{0x6078, 0}, Object{0x60F4, 0}, Object{0x219C, 0}, Object{0x219D, 0}, Object{0x219E, 0}, Object{0x219F, 0},
      Object{0x21A0, 0}, Object{0x21A2, 0}, Object{0x21A3, 0}, Object{0x60B9, 0}, Object{0x60BA, 0}, Object{0x60BB, 0},
      Object{0x60FD, 0}, Object{0x2079, 0}, Object{0x208F, 0}};

  DriveRig lazy;
  DriveRig complete;
};

TEST_F(MsdPublication, AnSdoFindsEveryValue) {
  expect_same_values();
  EXPECT_NE(lazy.read(0x606B), 0U);
  EXPECT_NE(lazy.read(0x6078), 0U);
  move(7);
  expect_same_values();
}

/// Inputs of the machine act on the values at the end of the next control cycle, not before.
TEST_F(MsdPublication, AnInputShowsInTheNextCycle) {
  for (const Input input : {Input::kIsd00, Input::kIsd05}) {
    both([input](DriveRig& rig) { rig.drive.set_input(input, true); });
    expect_same_values();
    move(1);
    expect_same_values();
  }
  EXPECT_EQ(lazy.read(0x60FD) & 2U, 2U);
  EXPECT_EQ(lazy.read(0x60B9), 3U);
}

TEST_F(MsdPublication, AnEncoderCableThatIsPulledOut) {
  for (const double connected : {0.0, 1.0}) {
    both([connected](DriveRig& rig) { rig.drive.set_machine_input(MachineInput::kEncoderCable, connected); });
    expect_same_values();
    move(20);
    if (connected > 0.0) continue;
    both([](DriveRig& rig) { rig.drive.set_machine_input(MachineInput::kEncoderCable, 1.0); });
    expect_same_values();
  }
}

TEST_F(MsdPublication, APositionThatIsHeld) {
  both([](DriveRig& rig) { rig.drive.set_machine_input(MachineInput::kPositionHeld, 1.0); });
  const auto held = lazy.read(0x6064);
  move(20);
  expect_same_values();
  EXPECT_EQ(lazy.read(0x6064), held);
}

TEST_F(MsdPublication, TheStatusPageIsComplete) {
  DeviceStatus shown;
  DeviceStatus expected;
  lazy.device.show(shown);
  complete.device.show(expected);
  const auto of = [](const DeviceStatus& status) {
    std::vector<double> values;
    for (const auto& row : status.shown()) values.push_back(row.value);
    return values;
  };
  EXPECT_EQ(of(shown), of(expected));
  EXPECT_GT(of(shown).size(), 5U);
}

/// A caller may keep the dictionary: its values are current from then on.
TEST_F(MsdPublication, TheDictionaryStaysCurrent) {
  const DriveCore& drive = lazy.drive;
  const ObjectDictionary& values = drive.dictionary();
  for (int i = 0; i < 20; ++i) {
    move(1);
    EXPECT_EQ(values.get(kValue.velocity_demand),
              static_cast<const DriveCore&>(complete.drive).dictionary().get(kValue.velocity_demand));
    EXPECT_EQ(values.get(kValue.actual_increments),
              static_cast<const DriveCore&>(complete.drive).dictionary().get(kValue.actual_increments));
  }
}

/// A mapping that is written later sends the values of its own cycle.
TEST_F(MsdPublication, ANewMappingIsSent) {
  both([](DriveRig& rig) {
    rig.command(0x00, 4);
    ASSERT_EQ(rig.to(AlState::kOp, AlState::kPreOp), AlStatusCode::kNoError);
    rig.map(0x1A01, {0x60620020});
    ASSERT_EQ(rig.to(AlState::kPreOp, AlState::kSafeOp), AlStatusCode::kNoError);
    ASSERT_EQ(rig.to(AlState::kSafeOp, AlState::kOp), AlStatusCode::kNoError);
    rig.enable(8);
  });
  const auto sent = [](DriveRig& rig) {
    std::array<std::byte, 12> in{};
    rig.device.read_inputs(3, in);
    return bytes::load_le<std::int32_t>(std::span<const std::byte>(in).subspan(8));
  };
  for (int i = 0; i < 20; ++i) {
    move(3);
    EXPECT_EQ(sent(lazy), sent(complete));
    EXPECT_EQ(sent(lazy), lazy.drive.complete_values().get(kValue.position_demand));
  }
}

}  // namespace
}  // namespace driveline::slaves::msd
