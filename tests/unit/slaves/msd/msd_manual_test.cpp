// Tables of the MSD manual, checked row by row, and behaviour that is independent of the mode.
#include "drive_rig.hpp"
#include "driveline/slaves/msd/core/drive_values.hpp"

namespace driveline::slaves::msd {
namespace {

using esi::DataType;

struct Listed {
  std::uint16_t index;
  std::uint8_t subindex;
  DataType type;
  bool writable;
};

/// Objects of the modes (Tables 12.3, 12.6, 12.9, 12.12, 12.15, 12.19, 12.21, 12.23), the option codes (10.3), the
/// factor group (10.4), touch probe (14.1) and round table (14.7). Where two tables disagree about a type, CiA 402
/// decides.
constexpr std::array kListed = {
    Listed{0x607A, 0, DataType::kInteger32, true},   Listed{0x607D, 1, DataType::kInteger32, true},
    Listed{0x607D, 2, DataType::kInteger32, true},   Listed{0x6081, 0, DataType::kUnsigned32, true},
    Listed{0x6083, 0, DataType::kUnsigned32, true},  Listed{0x6084, 0, DataType::kUnsigned32, true},
    Listed{0x6085, 0, DataType::kUnsigned32, true},  Listed{0x6064, 0, DataType::kInteger32, false},
    Listed{0x607E, 0, DataType::kUnsigned8, true},   Listed{0x6042, 0, DataType::kInteger16, true},
    Listed{0x6046, 1, DataType::kUnsigned32, true},  Listed{0x6046, 2, DataType::kUnsigned32, true},
    Listed{0x6048, 1, DataType::kUnsigned32, true},  Listed{0x6048, 2, DataType::kUnsigned32, true},
    Listed{0x6049, 1, DataType::kUnsigned32, true},  Listed{0x6049, 2, DataType::kUnsigned32, true},
    Listed{0x606C, 0, DataType::kInteger32, false},  Listed{0x60FF, 0, DataType::kInteger32, true},
    Listed{0x6094, 1, DataType::kUnsigned32, false}, Listed{0x607F, 0, DataType::kUnsigned32, true},
    Listed{0x607C, 0, DataType::kInteger32, true},   Listed{0x6098, 0, DataType::kInteger8, true},
    Listed{0x6099, 1, DataType::kUnsigned32, true},  Listed{0x6099, 2, DataType::kUnsigned32, true},
    Listed{0x609A, 0, DataType::kUnsigned32, true},  Listed{0x60C0, 0, DataType::kInteger16, true},
    Listed{0x60C1, 1, DataType::kInteger32, true},   Listed{0x60C2, 1, DataType::kUnsigned8, true},
    Listed{0x60C2, 2, DataType::kInteger8, true},    Listed{0x60B1, 0, DataType::kInteger32, true},
    Listed{0x60B2, 0, DataType::kInteger16, true},   Listed{0x6071, 0, DataType::kInteger16, true},
    Listed{0x605A, 0, DataType::kInteger16, true},   Listed{0x605B, 0, DataType::kInteger16, true},
    Listed{0x605C, 0, DataType::kInteger16, true},   Listed{0x605D, 0, DataType::kInteger16, true},
    Listed{0x605E, 0, DataType::kInteger16, true},   Listed{0x6089, 0, DataType::kInteger8, true},
    Listed{0x608A, 0, DataType::kUnsigned8, true},   Listed{0x608B, 0, DataType::kInteger8, true},
    Listed{0x608C, 0, DataType::kUnsigned8, true},   Listed{0x608D, 0, DataType::kInteger8, true},
    Listed{0x608E, 0, DataType::kUnsigned8, true},   Listed{0x608F, 1, DataType::kUnsigned32, true},
    Listed{0x6090, 1, DataType::kUnsigned32, true},  Listed{0x6091, 1, DataType::kUnsigned32, true},
    Listed{0x6092, 1, DataType::kUnsigned32, true},  Listed{0x6093, 1, DataType::kUnsigned32, false},
    Listed{0x6097, 1, DataType::kUnsigned32, false}, Listed{0x60B8, 0, DataType::kUnsigned16, true},
    Listed{0x60B9, 0, DataType::kUnsigned16, false}, Listed{0x60BA, 0, DataType::kInteger32, false},
    Listed{0x60BB, 0, DataType::kInteger32, false},  Listed{0x60BC, 0, DataType::kInteger32, false},
    Listed{0x60BD, 0, DataType::kInteger32, false},  Listed{0x607B, 1, DataType::kInteger32, true},
    Listed{0x607B, 2, DataType::kInteger32, true},   Listed{0x60F2, 0, DataType::kUnsigned16, true},
};

TEST(MsdManual, ObjectsOfTheTablesHaveTheirTypesAndAccess) {
  DriveRig rig;
  for (const auto& l : kListed) {
    SCOPED_TRACE(testing::Message() << std::hex << l.index << ':' << int{l.subindex});
    const auto* row = dictionary_table().find(l.index, l.subindex);
    ASSERT_NE(row, nullptr);
    EXPECT_EQ(row->type, l.type);
    const auto value = rig.read(l.index, l.subindex);
    const auto answer = rig.write(l.index, l.subindex, value, static_cast<unsigned>(byte_size(l.type)));
    EXPECT_EQ(answer, l.writable ? 0U : 0x06010002U);
  }
}

TEST(MsdManual, ParametersAreAt2000hPlusTheirNumber) {
  struct Parameter {
    unsigned number;
    std::uint16_t index;
  };
  // MSD manual 8.2.3, 7.5.3, 10.4, 13.2, 8.3.3
  for (const auto& parameter : {Parameter{455, 0x21C7}, Parameter{11, 0x200B}, Parameter{121, 0x2079},
                                Parameter{143, 0x208F}, Parameter{153, 0x2099}, Parameter{2055, 0x2807}}) {
    EXPECT_EQ(0x2000 + parameter.number, parameter.index);
    EXPECT_FALSE(dictionary_table().object(parameter.index).empty());
  }
  // Every parameter named in the chapters on EtherCAT and CiA 402.
  for (const unsigned number :
       {3U,   11U,  33U,  34U,  45U,  100U, 106U, 107U, 110U, 121U,  122U,  123U,  124U,  126U,  143U,  153U, 154U,
        159U, 165U, 306U, 370U, 375U, 376U, 379U, 455U, 745U, 2011U, 2055U, 2060U, 2208U, 2209U, 2266U, 2285U}) {
    EXPECT_FALSE(dictionary_table().object(static_cast<std::uint16_t>(0x2000 + number)).empty()) << "P " << number;
  }
}

TEST(MsdManual, AliasesAreOneValue) {
  struct Alias {
    std::uint16_t parameter;
    std::uint16_t object;
    unsigned size;
    std::uint32_t value;
  };
  DriveRig rig;
  for (const auto& a : {Alias{0x28A0, 0x6040, 2, 0x06}, Alias{0x28AA, 0x605A, 2, 7}, Alias{0x28AB, 0x605B, 2, 1},
                        Alias{0x28AC, 0x605C, 2, 0}, Alias{0x28AD, 0x605D, 2, 3}, Alias{0x28AE, 0x605E, 2, 1},
                        Alias{0x28C3, 0x6086, 2, 3}, Alias{0x28D5, 0x6098, 1, 17}}) {
    ASSERT_EQ(rig.write(a.parameter, 0, a.value, a.size), 0U) << std::hex << a.parameter;
    EXPECT_EQ(rig.read(a.object), a.value) << std::hex << a.object;
  }
}

TEST(MsdManual, NetworkStateIsZeroDuringStartAndOneInInit) {
  MsdParameters parameters;
  parameters.start_up_time = 10ms;
  MsdDrive device(parameters);
  const DriveCore& drive = device.core();
  device.advance(0ms);
  EXPECT_EQ(drive.dictionary().get(kValue.nmt_state), 0);
  device.advance(20ms);
  EXPECT_EQ(drive.dictionary().get(kValue.nmt_state), 1);
}

TEST(MsdManual, CyclicModesHaveNoModeBitsInTheControlWord) {
  for (const std::int8_t mode : {std::int8_t{8}, std::int8_t{9}, std::int8_t{10}}) {
    const auto run = [mode](std::uint16_t bits) {
      EnabledRig rig(mode);
      rig.target_position = 50'000;
      rig.target_velocity = kRevolution;
      rig.target_torque = 30;
      rig.command(static_cast<std::uint16_t>(0x0F | bits), 200);
      return std::pair(rig.drive.position_rad(), rig.status);
    };
    const auto plain = run(0);
    for (const std::uint16_t bit :
         {std::uint16_t{0x10}, std::uint16_t{0x20}, std::uint16_t{0x40}, std::uint16_t{0x100}}) {
      EXPECT_EQ(run(bit), plain) << int{mode} << ' ' << bit;
    }
  }
}

TEST(MsdManual, Bit13IsReservedInModes7And9And10) {
  for (const std::int8_t mode : {std::int8_t{7}, std::int8_t{9}, std::int8_t{10}}) {
    DriveRig rig;
    rig.set({{0x6065, 0, 1, 4}, {0x6066, 0, 0, 2}});
    rig.start(mode);
    rig.control = 0x1F;
    ASSERT_EQ(rig.write(0x60C1, 1, 50'000, 4), 0U);
    rig.target_velocity = 5 * kRevolution;
    rig.target_torque = 100;
    for (int i = 0; i < 400; ++i) {
      rig.cycle();
      ASSERT_EQ(rig.status & 0x2000, 0) << int{mode};
    }
  }
}

TEST(MsdManual, StandstillWindowIsP0745) {
  for (const std::int8_t mode : {std::int8_t{1}, std::int8_t{6}, std::int8_t{7}, std::int8_t{8}, std::int8_t{9},
                                 std::int8_t{10}, std::int8_t{2}, std::int8_t{3}}) {
    const bool shows = mode != 2 && mode != 3;
    OperatingRig rig;
    rig.run_at(kRevolution / 2);  // 30 rpm
    rig.mode = mode;
    rig.target_position = rig.position + 66;
    rig.target_torque = 13;
    rig.cycle();
    EXPECT_EQ(rig.status & 0x4000, 0) << int{mode} << " window 10 rpm";
    ASSERT_EQ(rig.write_real(0x22E9, 0, 100.0F), 0U);
    rig.cycle();
    EXPECT_EQ(rig.status & 0x4000, 0) << int{mode} << " standstill takes 4 ms";
    rig.cycles(40);
    EXPECT_EQ((rig.status & 0x4000) != 0, shows) << int{mode} << " window 100 rpm";
  }
}

TEST(MsdManual, ProfileGeneratorIsInactiveInTheCyclicModes) {
  DriveRig rig;
  ASSERT_EQ(rig.write(0x6081, 0, kRevolution / 100, 4), 0U);
  ASSERT_EQ(rig.write(0x607F, 0, kRevolution / 100, 4), 0U);
  ASSERT_EQ(rig.write(0x6083, 0, 1, 4), 0U);
  rig.start(8);
  for (int i = 0; i < 4000; ++i) {
    rig.target_position += 131;  // a revolution per second
    rig.cycle();
  }
  EXPECT_NEAR(rig.velocity, kRevolution, 5000);
  rig.mode = 9;
  rig.turn(2 * kRevolution, 400);
  EXPECT_NEAR(rig.velocity, 2 * kRevolution, 5000);
}

TEST(MsdManual, QuickStopIsSmoothedLikeTheProfileAndTheFaultRampIsNot) {
  const auto speed_after_20_ms = [](bool smooth, bool fault) {
    DriveRig rig;
    EXPECT_EQ(rig.write(0x6086, 0, smooth ? 3 : 0, 2), 0U);
    EXPECT_EQ(rig.write_real(0x20A6, 0, 40.0F), 0U);
    EXPECT_EQ(rig.write(0x6085, 0, 100 * kRevolution, 4), 0U);
    rig.operate();
    rig.run_at(10 * kRevolution);
    rig.control = fault ? 0x0F : 0x02;
    if (fault) rig.device.fall_back(AlState::kOp, AlState::kSafeOp, AlStatusCode::kSyncManagerWatchdog);
    rig.pass(125us);
    rig.cycles(160);
    return rig.drive.velocity_rad_s() * kIncrementsPerRadian / kRevolution;
  };
  const double trapezoid = 10.0 - 2.0;  // 100 rev/s2 for 20 ms
  const double smoothed = 10.0 - 0.5;   // the deceleration has reached half of it: a t^2 / 2 T
  EXPECT_NEAR(speed_after_20_ms(false, false), trapezoid, 0.1);
  EXPECT_NEAR(speed_after_20_ms(true, false), smoothed, 0.1);
  EXPECT_NEAR(speed_after_20_ms(false, true), trapezoid, 0.1);
  EXPECT_NEAR(speed_after_20_ms(true, true), trapezoid, 0.1);
}

/// Largest jerk of the shaft, from the mean acceleration over 2 ms, while this control word stops a movement of mode 1
/// or 3 at its full acceleration.
double jerk_of_stop(std::int8_t mode, std::uint16_t word, std::uint32_t halt_option) {
  DriveRig rig;
  rig.set({{0x6086, 0, 3, 2}, real_value(0x20A6, 0, 40.0F)});
  for (const std::uint16_t ramp : {std::uint16_t{0x6083}, std::uint16_t{0x6084}, std::uint16_t{0x6085}}) {
    EXPECT_EQ(rig.write(ramp, 0, 100 * kRevolution, 4), 0U);
  }
  EXPECT_EQ(rig.write(0x6081, 0, 50 * kRevolution, 4), 0U);
  EXPECT_EQ(rig.write(0x605D, 0, halt_option, 2), 0U);
  rig.start(mode);
  rig.target_position = 500 * kRevolution;
  rig.target_velocity = 30 * kRevolution;
  rig.command(mode == 1 ? 0x1F : 0x0F, 640);  // 80 ms: the acceleration is at its limit
  rig.control = word;
  double largest = 0.0;
  double last_speed = rig.drive.velocity_rad_s();
  double last_acceleration = 200.0 * std::numbers::pi;
  for (int i = 0; i < 60; ++i) {
    rig.cycles(16);
    const double speed = rig.drive.velocity_rad_s();
    const double acceleration = (speed - last_speed) / 2e-3;
    largest = std::max(largest, std::abs(acceleration - last_acceleration) / 2e-3);
    last_speed = speed;
    last_acceleration = acceleration;
  }
  EXPECT_LT(rig.drive.velocity_rad_s(), 20.0 * std::numbers::pi) << "it brakes";
  return largest;
}

TEST(MsdManual, StopsDuringAccelerationKeepTheJerkLimit) {
  constexpr double kJerk = 200.0 * std::numbers::pi / 40e-3;
  for (const auto mode : {std::int8_t{1}, std::int8_t{3}}) {
    SCOPED_TRACE(int{mode});
    EXPECT_LT(jerk_of_stop(mode, 0x10F, 1), 1.5 * kJerk) << "halt, slow down ramp";
    EXPECT_LT(jerk_of_stop(mode, 0x10F, 2), 1.5 * kJerk) << "halt, quick stop ramp";
    EXPECT_LT(jerk_of_stop(mode, 0x002, 1), 1.5 * kJerk) << "quick stop";
  }
}

TEST(MsdManual, DemandValuesAreWhatTheControllerFollows) {
  EnabledRig rig(8);
  for (int i = 0; i < 800; ++i) {
    rig.target_position += 500;
    rig.cycle();
  }
  EXPECT_NEAR(static_cast<std::int32_t>(rig.read(0x6062)), rig.target_position, 1000) << "position";
  EXPECT_EQ(static_cast<std::int32_t>(rig.read(0x6062)) - rig.position, rig.following_error);
  rig.mode = 9;
  rig.turn(3'000'000, 800);
  EXPECT_EQ(rig.read(0x606B), 3'000'000U) << "speed";
  rig.mode = 10;
  rig.target_torque = 123;
  rig.cycles(8);
  EXPECT_NEAR(static_cast<std::int16_t>(rig.read(0x6074)), 123, 1) << "torque";
}

TEST(MsdManual, VelocityOffsetHasTheUnitsOfTheFactorGroup) {
  DriveRig rig;
  rig.set({{0x6092, 1, 25'200, 4},  // tenths of a degree in 7 revolutions
           {0x6092, 2, 7, 4},
           {0x608B, 0, 1, 1},  // speeds in degrees per second
           {0x217B, 1, 1, 2}});
  rig.start(9);
  rig.velocity_offset = 720;
  rig.cycles(1600);
  EXPECT_NEAR(rig.drive.velocity_rad_s(), 4.0 * std::numbers::pi, 0.02);
  EXPECT_NEAR(rig.velocity, 720, 1);
}

TEST(MsdManual, ExternalTorqueFeedForwardCountsRatedTorque) {
  for (const float scale : {100.0F, 50.0F, 0.0F}) {
    DriveRig rig;
    rig.set({{0x217B, 2, 1, 2},
             real_value(0x2178, 0, scale),
             real_value(0x2140, 0, 0.0F)});  // no speed control, only the feed-forward
    rig.start(9);
    rig.torque_offset = 200;  // 20 % of the rated torque
    rig.cycles(40);
    EXPECT_NEAR(rig.drive.torque_nm(), 0.2 * 2.4 * scale / 100.0, 1e-3);
  }
}

TEST(MsdManual, FeedForwardParametersHaveTheRangesOfTheManual) {
  DriveRig rig;
  for (const std::uint16_t index : {std::uint16_t{0x2177}, std::uint16_t{0x2178}}) {
    EXPECT_EQ(rig.write_real(index, 0, 100.5F), 0x06090031U);
    EXPECT_EQ(rig.write_real(index, 0, -0.5F), 0x06090032U);
  }
  EXPECT_EQ(rig.read(0x217B, 0), 0U);
  EXPECT_EQ(rig.read(0x217B, 1), 0U);
  EXPECT_EQ(rig.read(0x217B, 2), 0U);
  EXPECT_EQ(rig.write(0x217B, 0, 1, 2), 0x06090031U) << "32-bit setpoints only";
  EXPECT_EQ(rig.write(0x217B, 1, 2, 2), 0x06090031U);
}

TEST(MsdManual, InterpolationWithExternalFeedForwardTakesBothOffsets) {
  DriveRig rig;
  ASSERT_EQ(rig.write(0x2172, 0, 2, 1), 0U);
  rig.start(8, 1000);
  double largest = 0.0;
  for (int i = 0; i < 2000; ++i) {
    const double t = i * 1e-3;
    const double w = 2.0 * std::numbers::pi * 2.0;
    rig.target_position = static_cast<std::int32_t>(0.5 * kRevolution * (1.0 - std::cos(w * t)));
    rig.velocity_offset = static_cast<std::int32_t>(0.5 * kRevolution * w * std::sin(w * t));
    rig.cycle();
    if (i > 500) largest = std::max(largest, std::abs(double{0} + rig.following_error));
  }
  EXPECT_LT(largest, 800.0);
  EXPECT_EQ(rig.drive.state(), PowerState::kOperationEnabled);
}

TEST(MsdManual, MotorValuesAreThoseOfTheProfileInUnitsOfTheMotor) {
  DriveRig rig;
  rig.set({{0x6092, 1, 39'600, 4},  // tenths of a degree in 11 revolutions
           {0x6092, 2, 11, 4}});
  rig.start(9);
  rig.turn(3600, 4000);
  const auto real = [&](std::uint16_t index) { return std::bit_cast<float>(rig.read(index)); };
  EXPECT_NEAR(real(0x219F), 60.0F, 0.1F);
  EXPECT_NEAR(real(0x21A0), 60.0F, 0.1F);
  EXPECT_NEAR(real(0x21A3), rig.drive.torque_nm(), 1e-6);
  EXPECT_NEAR(rig.read(0x219C), rig.drive.position_rad() * kIncrementsPerRadian, 2.0);
  EXPECT_EQ(rig.read(0x219D) - rig.read(0x219C), rig.read(0x219E));
  EXPECT_NEAR(real(0x21CC), 2.4F, 1e-6);  // rated torque
  EXPECT_EQ(rig.read(0x21CF), 4U);        // pole pairs
  EXPECT_EQ(rig.read(0x202D), 1U) << "PSM";
}

}  // namespace
}  // namespace driveline::slaves::msd
