// The ServoOne and the ServoOne junior on a CAN bus: the MSD but for the differences (ServoOne manual 4, 8).
#include "can_drive_rig.hpp"

namespace driveline::slaves::msd {
namespace {

MsdParameters servoone(Variant variant, std::optional<FirmwareVersion> firmware = {}) {
  MsdParameters parameters;
  parameters.variant = variant;
  parameters.firmware = firmware;
  return parameters;
}

class ServoOneCan : public ::testing::TestWithParam<Variant> {
 protected:
  ServoOneCan() { rig.run(5ms); }
  CanDriveRig rig{servoone(GetParam())};
};

TEST_P(ServoOneCan, IsThereWithItsIdentity) {
  EXPECT_EQ(rig.count(0x70C), 1U);
  EXPECT_EQ(rig.read(0x1018, 0), 4U);
  EXPECT_EQ(rig.read(0x1018, 1), 0x28U);
  EXPECT_EQ(rig.read(0x1018, 2), facts(GetParam()).product_code);
  EXPECT_EQ(rig.read(0x1018, 3), rig.value(0x1018, 3));
  EXPECT_EQ(rig.read(0x1018, 4), rig.value(0x1018, 4));
  EXPECT_EQ(rig.read(0x6502), 0x67U);
  EXPECT_EQ(rig.write(0x6060, 0, 8, 1), 0x0609'0030U);
  EXPECT_EQ(rig.read(0x27D6), 1000U);
}

// ServoOne manual 8.4: there is no heartbeat consumer; guarding and telegram failure watch the master.
TEST_P(ServoOneCan, HasNoHeartbeatConsumer) {
  EXPECT_EQ(rig.read(0x1016, 0), 0x0602'0000U);
  EXPECT_EQ(rig.write(0x1016, 1, 0x0005'0014, 4), 0x0602'0000U);
  rig.start();
  rig.send(0x705, "05");
  rig.run(200ms);
  EXPECT_EQ(rig.drive.core().fault(), std::nullopt);
}

INSTANTIATE_TEST_SUITE_P(Drives, ServoOneCan, ::testing::Values(Variant::kServoOne, Variant::kServoOneJunior),
                         drive_name);

// Switches 1 to 6 are the address of the junior, 7 its resistor (ServoOne manual Table 4.5).
TEST(ServoOneCanSwitch, HasSixBitsOnTheJunior) {
  CanDriveRig junior(servoone(Variant::kServoOneJunior), {DipSwitch{0x4C}, {}, 500us});
  junior.run(5ms);
  EXPECT_EQ(junior.count(0x70C), 1U);
  EXPECT_TRUE(junior.drive.terminates_bus());
  CanDriveRig large(servoone(Variant::kServoOne), {DipSwitch{0x4C}, {}, 500us}, 0x4C);
  large.run(5ms);
  EXPECT_EQ(large.count(0x74C), 1U);
  EXPECT_FALSE(large.drive.terminates_bus());
}

// Before firmware 4.15-02 a PDO has an even number of bytes (ServoOne manual 8.3.3).
TEST(ServoOneCanFirmware, OldOneNeedsAnEvenNumberOfBytes) {
  for (const auto& [firmware, abort] :
       {std::pair{FirmwareVersion{4, 15, 1}, 0x0604'0043U}, std::pair{FirmwareVersion{4, 15, 2}, 0U}}) {
    CanDriveRig rig(servoone(Variant::kServoOne, firmware));
    rig.run(5ms);
    ASSERT_EQ(rig.write(0x1A01, 1, 0x6061'0008, 4), 0U);
    EXPECT_EQ(rig.write(0x1A01, 0, 1, 1), abort);
  }
}

}  // namespace
}  // namespace driveline::slaves::msd
