// The ideal drives of a device with two CiA 402 drives, operated through its slave controller.
#include "driveline/slaves/generic/ideal_drives.hpp"

#include "device_bench.hpp"

namespace driveline::slaves::generic {
namespace {

constexpr std::uint16_t kShutdown = 0x0006;
constexpr std::uint16_t kEnable = 0x000F;
constexpr std::uint8_t kPosition = 8;  // 6060h: CSP
constexpr std::uint8_t kVelocity = 9;  // CSV

esi::DeviceDescription dual_drive() {
  std::ifstream stream("examples/dual_drive.xml", std::ios::binary);
  const std::string text{std::istreambuf_iterator<char>(stream), {}};
  const auto file = esi::read_esi(text, "examples/dual_drive.xml");
  EXPECT_TRUE(file) << esi::to_text(file.error());
  const auto device = file->choose({"DD2", {}, {}});
  EXPECT_TRUE(device) << describe(device.error());
  return **device;
}

struct DriveCommand {
  std::uint16_t control_word = 0;
  std::uint8_t mode = kPosition;
  std::int32_t position = 0;
  std::int32_t velocity = 0;
};

struct DriveAnswer {
  std::uint16_t status_word = 0;
  std::int8_t mode = 0;
  std::int32_t position = 0;
  std::int32_t velocity = 0;
  std::uint16_t error_code = 0;
};

/// The device in OP; an exchange takes a step of 125 us.
class IdealDrivesTest : public testing::Test {
 protected:
  static constexpr std::size_t kOutputs = 11;  // bytes of a drive
  static constexpr std::size_t kInputs = 13;

  void SetUp() override { start(dual_drive()); }
  void start(const esi::DeviceDescription& description) {
    device = std::make_unique<DeviceBench>(description);
    auto& bench = *device;
    bench.go_to_op();
    ASSERT_EQ(bench.output_bytes(), 2 * kOutputs);
    ASSERT_EQ(bench.input_bytes(), 2 * kInputs);
  }
  void exchange() {
    std::vector<std::byte> data(2 * kInputs);
    for (std::size_t n = 0; n < 2; ++n) {
      const auto part = std::span(data).subspan(n * kOutputs, kOutputs);
      driveline::bytes::store_le<std::uint16_t>(part, commands[n].control_word);
      part[2] = std::byte{commands[n].mode};
      driveline::bytes::store_le<std::int32_t>(part.subspan(3), commands[n].position);
      driveline::bytes::store_le<std::int32_t>(part.subspan(7), commands[n].velocity);
    }
    data = device->exchange(data, 3);
    for (std::size_t n = 0; n < 2; ++n) {
      const auto part = std::span<const std::byte>(data).subspan(n * kInputs, kInputs);
      answers[n] = {driveline::bytes::load_le<std::uint16_t>(part), std::to_integer<std::int8_t>(part[2]),
                    driveline::bytes::load_le<std::int32_t>(part.subspan(3)),
                    driveline::bytes::load_le<std::int32_t>(part.subspan(7)),
                    driveline::bytes::load_le<std::uint16_t>(part.subspan(11))};
    }
  }
  void exchange(int times) {
    for (int i = 0; i < times; ++i) exchange();
  }
  void enable(std::size_t drive) {
    commands[drive].control_word = kShutdown;
    exchange(3);
    commands[drive].control_word = kEnable;
    exchange(4);
    ASSERT_EQ(answers[drive].status_word, 0x1237) << "Operation enabled, remote, follows its target";
  }

  std::unique_ptr<DeviceBench> device;
  std::array<DriveCommand, 2> commands{};
  std::array<DriveAnswer, 2> answers{};
};

TEST_F(IdealDrivesTest, EachDriveHasItsOwnStates) {
  exchange(2);
  EXPECT_EQ(answers[0].status_word, 0x0250) << "Switch on disabled";
  EXPECT_EQ(answers[0].mode, 8);
  enable(1);
  EXPECT_EQ(answers[0].status_word, 0x0250);
  enable(0);
  commands[1].control_word = 0;
  exchange(3);
  EXPECT_EQ(answers[1].status_word, 0x0250);
  EXPECT_EQ(answers[0].status_word, 0x1237);
}

TEST_F(IdealDrivesTest, MovesWhereEachIsCommanded) {
  enable(0);
  enable(1);
  // 40 and -300 increments per exchange of 125 us: 320,000/s and -2,400,000/s.
  for (int i = 0; i < 20; ++i) {
    commands[0].position += 40;
    commands[1].position -= 300;
    exchange();
  }
  EXPECT_EQ(answers[0].velocity, 320'000);
  EXPECT_EQ(answers[1].velocity, -2'400'000);
  EXPECT_NEAR(answers[0].position, commands[0].position, 3 * 40);
  EXPECT_LT(answers[0].position, commands[0].position) << "it is on its way to the last setpoint";
  exchange(4);
  EXPECT_EQ(answers[0].position, 800);
  EXPECT_EQ(answers[1].position, -6000);
  EXPECT_EQ(answers[0].velocity, 0);
}

TEST_F(IdealDrivesTest, TurnsWithItsVelocityFromWhereItIs) {
  enable(0);
  enable(1);
  commands[0].position = 90;
  commands[1].mode = kVelocity;
  commands[1].velocity = 8'000'000;  // 1000 per step
  exchange(10);
  EXPECT_EQ(answers[1].mode, 9);
  EXPECT_EQ(answers[1].velocity, 8'000'000);
  EXPECT_EQ(answers[1].position % 1000, 0);
  EXPECT_GE(answers[1].position, 7000);
  EXPECT_EQ(answers[0].position, 90);
  commands[1].control_word = kShutdown;
  exchange(3);
  const auto rest = answers[1].position;
  exchange(5);
  EXPECT_EQ(answers[1].position, rest) << "a drive that is off stands still";
}

TEST_F(IdealDrivesTest, PositionsContinueAcrossTheEndOfTheirRange) {
  enable(0);
  constexpr std::int64_t kStep = 1 << 30;
  std::int64_t there = 0;
  for (int i = 0; i < 5; ++i) {
    there += kStep;
    commands[0].position = static_cast<std::int32_t>(static_cast<std::uint32_t>(there));
    exchange();
  }
  exchange(3);
  EXPECT_EQ(answers[0].position, commands[0].position);
  commands[0].position -= 700;
  exchange();
  exchange();
  exchange();
  EXPECT_EQ(answers[0].position, commands[0].position);
}

TEST_F(IdealDrivesTest, AModeThatItDoesNotHaveIsNotTaken) {
  enable(0);
  commands[0].mode = 10;  // CST
  exchange(4);
  EXPECT_EQ(answers[0].mode, 8);
}

TEST_F(IdealDrivesTest, TheWatchdogPutsBothIntoFaultUntilTheyAreReset) {
  enable(1);
  device->device().fall_back(AlState::kOp, AlState::kSafeOp, AlStatusCode::kSyncManagerWatchdog);
  device->pass(1ms);
  commands[1].control_word = 0;
  exchange(3);
  for (const auto& answer : answers) {
    EXPECT_EQ(answer.status_word & 0x4F, 0x0008) << "Fault";
    EXPECT_EQ(answer.error_code, IdealDrives::kNoMasterData);
  }
  commands[1].control_word = 0x80;
  exchange(3);
  EXPECT_EQ(answers[1].status_word, 0x0250);
  EXPECT_EQ(answers[1].error_code, 0);
  EXPECT_EQ(answers[0].status_word & 0x4F, 0x0008) << "it has not been reset";
}

TEST_F(IdealDrivesTest, OtherOutputsAreLoopedBack) {
  auto description = dual_drive();
  description.rx_pdos[1].entries[3].index = 0x68FE;  // digital outputs instead of the target velocity
  description.tx_pdos[1].entries[3].index = 0x68FD;  // digital inputs instead of the actual velocity
  start(description);
  commands[0].position = 70;
  commands[1].velocity = 0x1234567;
  exchange(3);
  EXPECT_EQ(answers[1].velocity, 0x1234567);
  EXPECT_EQ(answers[0].position, 0) << "it is off";
}

TEST_F(IdealDrivesTest, InterpolatesWhenItsControlWordSaysSo) {
  auto description = dual_drive();
  for (auto& entry : description.rx_pdos[0].entries) {
    if (entry.index != 0x607A) continue;
    entry.index = 0x60C1;
    entry.subindex = 1;
  }
  start(description);
  commands[0].mode = 7;
  commands[0].control_word = kShutdown;
  exchange(3);
  commands[0].control_word = kEnable;
  commands[0].position = 700;
  exchange(6);
  EXPECT_EQ(answers[0].mode, 7);
  EXPECT_EQ(answers[0].status_word, 0x0237) << "enabled, but bit 4 of the control word is not set";
  EXPECT_EQ(answers[0].position, 0);
  commands[0].control_word = kEnable | 0x10;
  exchange(6);
  EXPECT_EQ(answers[0].status_word, 0x1237) << "interpolated position is active";
  EXPECT_EQ(answers[0].position, 700);
}

TEST(IdealDrives, AreCountedByTheirWords) {
  const auto count = [](const esi::DeviceDescription& description) {
    return count_drives(model_of(description)->table());
  };
  EXPECT_EQ(count(dual_drive()), 2U);
  EXPECT_EQ(count(example("MX4")), 0U);
  auto description = dual_drive();
  description.tx_pdos[1].entries[0].index = 0x6842;
  EXPECT_EQ(count(description), 1U) << "the second has no status word";
  description = dual_drive();
  description.rx_pdos[0].entries[0].index = 0x6042;
  EXPECT_EQ(count(description), 0U) << "drives are numbered from 0 without gaps";
}

}  // namespace
}  // namespace driveline::slaves::generic
