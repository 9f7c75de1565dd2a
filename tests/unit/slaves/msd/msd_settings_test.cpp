// The effect of the drive's settings, and its time: cyclically (MSD manual 12.2.3), from PDOs (8.3.2), of its motor
// (8.2.2, 8.2.3), in its answers (8.2.2); movements across a change of mode.
#include "drive_rig.hpp"

namespace driveline::slaves::msd {
namespace {

constexpr std::int32_t kRev = 1 << 20;
constexpr std::uint16_t kReachedBit = 0x0400;
constexpr std::uint32_t kNotMappableAbort = 0x06040041;

std::uint32_t entry(std::uint16_t index, unsigned subindex, unsigned bits) {
  return std::uint32_t{index} << 16 | subindex << 8 | bits;
}

class MsdProfileVelocityCyclic : public testing::Test {
 protected:
  MsdProfileVelocityCyclic() {
    set(0x6083, 50 * kRev);
    set(0x6084, 100 * kRev);
    set(0x6085, 400 * kRev);
    rig.start(3);
  }
  void set(std::uint16_t index, std::int32_t value) {
    ASSERT_EQ(rig.write(index, 0, static_cast<std::uint32_t>(value), 4), 0U);
  }
  /// Revolutions per second squared over the next 20 ms.
  double acceleration() {
    const double before = rig.drive.velocity_rad_s();
    rig.cycles(160);
    return (rig.drive.velocity_rad_s() - before) / (2.0 * std::numbers::pi) / 20e-3;
  }
  DriveRig rig;
};

TEST_F(MsdProfileVelocityCyclic, LimitCountsWhileTheTargetStays) {
  rig.turn(10 * kRev, 4000);
  ASSERT_NEAR(rig.velocity, 10 * kRev, 5000);
  set(0x607F, 3 * kRev);
  rig.cycles(80);
  EXPECT_EQ(rig.status & kReachedBit, 0) << "10 rev/s is not what it runs at";
  rig.cycles(2000);
  EXPECT_NEAR(rig.velocity, 3 * kRev, 5000);
  EXPECT_TRUE(rig.status & 0x0800) << "internal limit";
  set(0x607F, 20 * kRev);
  rig.cycles(4000);
  EXPECT_NEAR(rig.velocity, 10 * kRev, 5000);
  EXPECT_TRUE(rig.status & kReachedBit);
}

TEST_F(MsdProfileVelocityCyclic, RampsCountOnTheWay) {
  rig.turn(30 * kRev, 160);
  EXPECT_NEAR(acceleration(), 50.0, 2.0);
  set(0x6083, 200 * kRev);
  rig.cycles(40);
  EXPECT_NEAR(acceleration(), 200.0, 8.0);
  rig.cycles(4000);
  rig.turn(0, 160);
  EXPECT_NEAR(acceleration(), -100.0, 4.0);
  set(0x6084, 25 * kRev);
  rig.cycles(40);
  EXPECT_NEAR(acceleration(), -25.0, 2.0);
}

/// A braking ramp also follows a change of its deceleration: quick stop 6085h, halt 6084h.
TEST_F(MsdProfileVelocityCyclic, BrakingRampsCountOnTheWay) {
  for (const bool quick : {true, false}) {
    rig.control = 0x0F;
    rig.enable(3);
    set(0x6084, 100 * kRev);
    set(0x6085, 100 * kRev);
    rig.turn(30 * kRev, 8000);
    rig.command(quick ? 0x02 : 0x10F, 80);
    EXPECT_NEAR(acceleration(), -100.0, 4.0) << quick;
    set(quick ? 0x6085 : 0x6084, 300 * kRev);
    rig.cycles(40);
    EXPECT_NEAR(acceleration(), -300.0, 12.0) << quick;
    rig.cycles(4000);
  }
}

/// A movement belongs to the mode that has started it: with bit 4 at 0 homing is not started and interpolation not
/// enabled (CiA 402), so the axis brakes with 6084h and stops.
TEST(MsdModes, AMovementEndsWithItsMode) {
  struct Change {
    std::int8_t from;
    std::int8_t to;
  };
  for (const auto& change : {Change{1, 6}, Change{1, 7}, Change{6, 1}, Change{6, 7}}) {
    SCOPED_TRACE(testing::Message() << int{change.from} << " to " << int{change.to});
    DriveRig rig;
    ASSERT_EQ(rig.write(0x6081, 0, 10 * kRev, 4), 0U);
    ASSERT_EQ(rig.write(0x6084, 0, 100 * kRev, 4), 0U);
    ASSERT_EQ(rig.write(0x6098, 0, 23, 1), 0U);  // to a missing home switch
    ASSERT_EQ(rig.write(0x6099, 1, 10 * kRev, 4), 0U);
    rig.start(change.from);
    rig.target_position = 1000 * kRev;
    rig.command(0x1F, 4000);
    ASSERT_NEAR(rig.velocity, 10 * kRev, 5000);
    const double before = rig.drive.position_rad() / (2.0 * std::numbers::pi);
    rig.mode = change.to;
    rig.command(0x0F, 400);
    EXPECT_NEAR(rig.velocity, 5 * kRev, 0.2 * kRev) << "half way of 0.1 s";
    rig.cycles(1600);
    EXPECT_NEAR(rig.velocity, 0, 3000);
    const double way = rig.drive.position_rad() / (2.0 * std::numbers::pi) - before;
    EXPECT_NEAR(way, 0.5, 0.05) << "v^2 / 2a";
    rig.cycles(4000);
    EXPECT_NEAR(rig.drive.position_rad() / (2.0 * std::numbers::pi) - before, way, 1e-3) << "and stands";
  }
}

TEST(MsdVelocityUnit, MadeRpmItReachesTheWholeSpeedRange) {
  DriveRig rig;
  rig.set({{0x604C, 1, 1'048'576, 4},  // increments
           {0x604C, 2, 60, 4},         // of a revolution per minute
           {0x6048, 1, 3000, 4},       // rpm in a second
           {0x6049, 1, 3000, 4}});
  rig.start(2);
  const auto order = [&](int rpm) { ASSERT_EQ(rig.write(0x6042, 0, static_cast<std::uint16_t>(rpm), 2), 0U); };
  rig.control = 0x6F;
  for (const int rpm : {100, 3000, 5700, -5700, 0}) {
    order(rpm);
    rig.cycles(8);
    EXPECT_EQ(rig.status & kReachedBit, 0) << rpm << ": on the way";
    rig.cycles(5 * 8000);
    EXPECT_TRUE(rig.status & kReachedBit) << rpm;
    EXPECT_NEAR(rig.drive.velocity_rad_s(), rpm * std::numbers::pi / 30.0, 0.3) << rpm;
  }
  order(3000);
  rig.cycles(4000);
  rig.control = 0x4F;  // the ramp is locked short of its target
  rig.cycles(4000);
  EXPECT_EQ(rig.status & kReachedBit, 0);
  EXPECT_NEAR(rig.drive.velocity_rad_s(), 1500.0 * std::numbers::pi / 30.0, 0.5);
}

TEST(MsdMapping, DeviceParametersCanBeMapped) {
  DriveRig rig;
  struct Parameter {
    unsigned number;
    unsigned bits;
    bool writable;
  };
  for (const auto& p : {Parameter{745, 32, true}, Parameter{320, 32, true}, Parameter{2208, 16, true},
                        Parameter{2060, 8, false}, Parameter{2209, 16, false}, Parameter{419, 32, false}}) {
    const auto mapping = entry(static_cast<std::uint16_t>(0x2000 + p.number), 0, p.bits);
    EXPECT_EQ(rig.write(0x1A00, 1, mapping, 4), 0U) << p.number;
    EXPECT_EQ(rig.write(0x1600, 1, mapping, 4), p.writable ? 0U : kNotMappableAbort) << p.number;
  }
  EXPECT_EQ(rig.write(0x1600, 1, entry(0x200B, 1, 8), 4), kNotMappableAbort) << "a command";
  EXPECT_EQ(rig.write(0x1600, 1, entry(0x21C9, 0, 32), 4), kNotMappableAbort) << "with the power stage off only";
  EXPECT_EQ(rig.write(0x1A00, 1, entry(0x2003, 0, 8), 4), kNotMappableAbort) << "a text";
}

TEST(MsdMapping, MappedParametersActAndKeepTheirRange) {
  DriveRig rig;
  rig.map(0x1600, {entry(0x22E9, 0, 32), entry(0x2065, 0, 16)});  // P 745, P 101
  rig.map(0x1A00, {entry(0x280C, 0, 8), entry(0x22E9, 0, 32)});   // P 2060, P 745
  ASSERT_EQ(rig.to(AlState::kPreOp, AlState::kSafeOp), AlStatusCode::kNoError);
  ASSERT_EQ(rig.to(AlState::kSafeOp, AlState::kOp), AlStatusCode::kNoError);
  const auto exchange = [&rig](float window, std::uint16_t function) {
    std::array<std::byte, 6> out{};
    bytes::store_le(std::span(out), std::bit_cast<std::uint32_t>(window));
    bytes::store_le(std::span(out).subspan(4), function);
    rig.device.write_outputs(2, out);
    rig.pass(1ms);
    std::array<std::byte, 5> in{};
    rig.device.read_inputs(3, in);
    EXPECT_EQ(std::to_integer<int>(in[0]), 5) << "OP";
    return std::bit_cast<float>(bytes::load_le<std::uint32_t>(std::span<const std::byte>(in).subspan(1)));
  };
  EXPECT_EQ(exchange(25.0F, 5), 25.0F);
  rig.drive.set_input(Input::kIsd00, true);
  rig.pass(250us);
  EXPECT_TRUE(rig.read(0x60FD) & 2U) << "ISD00 has become a positive limit switch";
  for (const float wrong : {-1.0F, 1e6F, std::numeric_limits<float>::quiet_NaN()}) {
    EXPECT_EQ(exchange(wrong, 7), 25.0F) << "as an SDO would refuse it";
    EXPECT_EQ(rig.read(0x2065), 5U) << "there is no function 7";
  }
}

TEST(MsdMotorData, IsWrittenWithThePowerStageOff) {
  DriveRig rig;
  EXPECT_EQ(std::bit_cast<float>(rig.read(0x21C7)), 200.0F) << "3000 rpm, four pole pairs";
  EXPECT_EQ(std::bit_cast<float>(rig.read(0x22DD, 4)), 200.0F) << "P 733[4] is the same frequency";
  rig.set({real_value(0x21C7, 0, 150.0F), {0x202D, 0, 1, 2}});
  EXPECT_EQ(rig.write(0x202D, 0, 2, 2), 0x06090031U) << "the motor is a PSM";
  rig.set({real_value(0x21C9, 0, 2.0F), real_value(0x21CC, 0, 2.0F)});
  EXPECT_EQ(rig.write_real(0x21CC, 0, 0.0F), 0x06090032U);
  ASSERT_EQ(rig.write(0x200B, 1, 1, 1), 0U);
  rig.pass(5ms);
  rig.restart();
  rig.pass(5ms);
  EXPECT_EQ(std::bit_cast<float>(rig.read(0x21C7)), 150.0F) << "kept";
  EXPECT_EQ(rig.read(0x6075), 2000U);
  EXPECT_EQ(rig.read(0x6076), 2000U);
  rig.start(10);
  EXPECT_EQ(rig.write_real(0x21C9, 0, 2.5F), 0x08000022U);
}

/// The drive gets wrong data of a motor with 2.4 Nm at 2.5 A: it commands the current according to these data, and the
/// motor converts it to torque.
TEST(MsdMotorData, WrongDataMakeWrongTorque) {
  struct Told {
    float current_a;
    float torque_nm;
  };
  for (const auto& told : {Told{2.5F, 2.4F}, Told{1.25F, 2.4F}, Told{2.5F, 1.2F}, Told{2.0F, 2.0F}}) {
    SCOPED_TRACE(testing::Message() << told.current_a << " A, " << told.torque_nm << " Nm");
    DriveRig rig;
    rig.set({real_value(0x21C9, 0, told.current_a), real_value(0x21CC, 0, told.torque_nm)});
    rig.start(10);
    rig.target_torque = 500;
    rig.cycles(40);
    EXPECT_NEAR(rig.drive.torque_nm(), 0.5 * told.current_a / 2.5 * 2.4, 1e-3);
    EXPECT_NEAR(static_cast<std::int16_t>(rig.read(0x6078)), 500, 1);
    EXPECT_EQ(rig.torque, 500) << "the drive knows nothing else";
    EXPECT_NEAR(std::bit_cast<float>(rig.read(0x21A3)), 0.5F * told.torque_nm, 1e-3);
  }
}

/// MSD manual Table 8.3: numbers come as 32-bit values, "filled with correct sign (00H and FFH)".
TEST(MsdCommunication, ShortIntegersAreFilledWithTheirSign) {
  DriveRig rig;
  const auto answer = [&rig](std::uint16_t index) {
    return rig.sdo({0x40, index & 0xFFU, unsigned{index} >> 8, 0, 0, 0, 0, 0});
  };
  using testing::ElementsAre;
  ASSERT_EQ(rig.write(0x605B, 0, 0xFFFF, 2), 0U);
  EXPECT_THAT(answer(0x605B), ElementsAre(0x4B, 0x5B, 0x60, 0, 0xFF, 0xFF, 0xFF, 0xFF)) << "INT16, -1";
  ASSERT_EQ(rig.write(0x6089, 0, 0xFD, 1), 0U);
  EXPECT_THAT(answer(0x6089), ElementsAre(0x4F, 0x89, 0x60, 0, 0xFD, 0xFF, 0xFF, 0xFF)) << "INT8, -3";
  ASSERT_EQ(rig.write(0x6089, 0, 0x03, 1), 0U);
  EXPECT_THAT(answer(0x6089), ElementsAre(0x4F, 0x89, 0x60, 0, 0x03, 0, 0, 0)) << "INT8, 3";
  ASSERT_EQ(rig.write(0x6072, 0, 0xFFFE, 2), 0U);
  EXPECT_THAT(answer(0x6072), ElementsAre(0x4B, 0x72, 0x60, 0, 0xFE, 0xFF, 0, 0)) << "UINT16 has no sign";
  ASSERT_EQ(rig.write(0x607C, 0, 0xFFFFFFFE, 4), 0U);
  EXPECT_THAT(answer(0x607C), ElementsAre(0x43, 0x7C, 0x60, 0, 0xFE, 0xFF, 0xFF, 0xFF)) << "INT32 is full";
}

}  // namespace
}  // namespace driveline::slaves::msd
