// Protection of motor and power stage, faults with a persistent cause, warnings (MSD manual 4.7, 11.3.2, 13).
#include <set>

#include "drive_rig.hpp"

namespace driveline::slaves::msd {
namespace {

using testing::ElementsAre;

std::string text(DriveRig& rig, std::uint16_t index, unsigned sub) {
  const auto answer = rig.sdo({0x40, index & 0xFFU, unsigned{index} >> 8, sub, 0, 0, 0, 0});
  std::string result;
  for (std::size_t i = 8; i < answer.size() && answer[i] != 0; ++i) result += static_cast<char>(answer[i]);
  return result;
}

class MsdCause : public testing::TestWithParam<Fault> {};

TEST_P(MsdCause, RaisesItsFaultAndCannotBeAcknowledgedWhileItLasts) {
  EnabledRig rig(9);
  const FaultFacts& f = facts(GetParam());
  rig.drive.set_cause(GetParam(), true);
  rig.pass(1s);
  EXPECT_EQ(rig.drive.fault(), GetParam());
  EXPECT_EQ(rig.drive.state(), PowerState::kFault);
  EXPECT_EQ(rig.status & 0x08, 0x08) << "fault bit";
  EXPECT_EQ(rig.error_code, f.error_code);
  rig.fetch_emergencies();
  const unsigned error_register = f.error_register | 1U;
  EXPECT_THAT(rig.emergencies, ElementsAre(ElementsAre(f.error_code & 0xFFU, f.error_code >> 8U, error_register,
                                                       f.number, f.location, 0, 0, 0)));
  EXPECT_EQ(rig.read(0x1001), error_register);
  EXPECT_EQ(text(rig, 0x2021, 0), f.text);
  EXPECT_TRUE(rig.drive.display().starts_with("Er. "));
  rig.emergencies.clear();
  rig.command(0x80, 4);
  EXPECT_EQ(rig.drive.state(), PowerState::kFault);
  rig.fetch_emergencies();
  ASSERT_EQ(rig.emergencies.size(), 2U) << "acknowledgement, and the fault again";
  EXPECT_THAT(rig.emergencies[0], ElementsAre(0, 0, 0, 0, 0, 0, 0, 0));
  rig.drive.set_cause(GetParam(), false);
  EXPECT_TRUE(rig.drive.display().starts_with("Er "));
  rig.command(0, 4);
  rig.command(0x80, 4);
  EXPECT_EQ(rig.drive.state(), PowerState::kSwitchOnDisabled);
  EXPECT_EQ(text(rig, 0x2021, 0), "");
}

INSTANTIATE_TEST_SUITE_P(Faults, MsdCause,
                         testing::Values(Fault::kOvercurrent, Fault::kEncoder, Fault::kEepromData, Fault::kInternalRam,
                                         Fault::kMotorTemperature, Fault::kAmplifierTemperature));

TEST(MsdProtection, EtherCatFaultsHaveTheNumbersOfTheManual) {
  // MSD manual 5.3.3
  EXPECT_EQ(facts(Fault::kBusWatchdog).location, 1);
  EXPECT_EQ(facts(Fault::kEepromData).location, 2);
  EXPECT_EQ(facts(Fault::kInternalRam).location, 3);
  EXPECT_EQ(facts(Fault::kInvalidConfiguration).location, 4);
  EXPECT_EQ(facts(Fault::kMissingOutputs).location, 5);
  EXPECT_EQ(facts(Fault::kLocalError).location, 6);
  for (const auto& f : kFaults) {
    if (f.number == 14) {
      EXPECT_EQ(f.error_code, 0xFF00) << "13.1";
    }
  }
}

TEST(MsdProtection, NumbersAndLocationsAreUnique) {
  std::set<std::pair<int, int>> seen;
  for (const auto& f : kFaults) EXPECT_TRUE(seen.insert({f.number, f.location}).second) << f.text;
}

TEST(MsdProtection, OverloadTripsAndIsShown) {
  DriveRig rig;
  ASSERT_EQ(rig.write_real(0x22DD, 7, 10.0F), 0U);  // Tth
  rig.start(9);
  rig.drive.heat(1.0, 100s);
  rig.pass(5ms);
  EXPECT_FALSE(rig.drive.fault().has_value()) << "rated current is allowed for ever";
  EXPECT_TRUE(rig.status & 0x80) << "but near the limit";
  EXPECT_EQ(rig.read(0x2022), 1U);
  EXPECT_EQ(text(rig, 0x2021, 1), "I2t near its limit");
  EXPECT_EQ(rig.drive.state(), PowerState::kOperationEnabled) << "a warning changes no state";
  rig.drive.heat(1.2, 10s);
  rig.pass(500ms);
  EXPECT_EQ(rig.drive.fault(), Fault::kMotorOverload);
  EXPECT_EQ(rig.drive.display(), "Er. 09 01");
  rig.pass(4s);
  EXPECT_EQ(rig.drive.display(), "Er 09 01") << "cooled down";
}

TEST(MsdProtection, OverloadOfTypeFreqAllows150PercentFor120Seconds) {
  ThermalModel model;
  OverloadLimits limits;
  limits.thermal = false;
  for (int i = 0; i < 119; ++i) model.step(1.5, 100.0, limits, 1.0);
  EXPECT_LT(model.overload_percent(), 100.0);
  for (int i = 0; i < 2; ++i) model.step(1.5, 100.0, limits, 1.0);
  EXPECT_GT(model.overload_percent(), 100.0);
  for (int i = 0; i < 1000; ++i) model.step(0.0, 100.0, limits, 1.0);
  EXPECT_EQ(model.overload_percent(), 0.0);
  limits.standstill = 0.5;  // half the current is allowed at standstill
  model.step(0.5, 0.0, limits, 100.0);
  EXPECT_EQ(model.overload_percent(), 0.0);
  model.step(1.0, 0.0, limits, 10.0);
  EXPECT_GT(model.overload_percent(), 10.0);
}

TEST(MsdProtection, OverloadOfTypeThermReachesItsShareWithItsTimeConstant) {
  ThermalModel model;
  OverloadLimits limits;
  limits.time_constant_s = 10.0;
  for (int i = 0; i < 10000; ++i) model.step(1.0, 0.0, limits, 1e-3);
  EXPECT_NEAR(model.overload_percent(), 100.0 * (1.0 - std::exp(-1.0)), 0.1);
  EXPECT_NEAR(model.motor_c(), 25.0 + 65.0 * (1.0 - std::exp(-10.0 / 600.0)), 0.1);
}

/// An axis that pushes with 1.5 times its rated current against an end stop, until a protection trips.
double seconds_of_stall(DriveRig& rig, std::uint32_t overload_type) {
  EXPECT_EQ(rig.write(0x22DF, 0, overload_type, 2), 0U);
  EXPECT_EQ(rig.write(0x22DC, 0, 0, 2), 0U);  // no temperature sensor
  rig.start(10);
  rig.target_torque = 1500;
  rig.cycles(80);
  for (int i = 0; i < 2000; ++i) {
    rig.pass(100ms);
    if (rig.drive.fault()) return i * 0.1;
  }
  return 1e9;
}

TEST(MsdProtection, OverloadCountsTheCurrentOfTheRunningMotor) {
  constexpr double kThermalS = 40.3;  // 60 s * ln(2.25 / (2.25 - 1.1))
  constexpr double kFrequencyS = 120.0;
  for (const bool saturated : {false, true}) {
    MsdParameters parameters;
    parameters.motor.load.end_stop_max_rad = 0.5;
    parameters.motor.winding.simulated = saturated;
    parameters.motor.winding.saturation_current_a = saturated ? 6.0 : 0.0;
    for (const std::uint32_t type : {1U, 0U}) {
      DriveRig rig(parameters);
      EXPECT_NEAR(seconds_of_stall(rig, type), type == 1 ? kThermalS : kFrequencyS, 1.0)
          << "type " << type << (saturated ? ", saturated" : "");
      EXPECT_EQ(rig.drive.fault(), Fault::kMotorOverload);
    }
  }
}

TEST(MsdProtection, TemperaturesRiseWithTheCurrentOfTheRunningMotor) {
  MsdParameters parameters;
  parameters.motor.load.end_stop_max_rad = 0.5;
  parameters.motor.winding.simulated = true;
  parameters.motor.winding.saturation_current_a = 6.0;
  parameters.thermal.motor_time_constant_s = 5.0;
  EnabledRig rig(parameters, 10);
  rig.target_torque = 1000;
  rig.cycles(80);
  rig.pass(9s);
  rig.pass(9s);
  rig.pass(9s);
  EXPECT_NEAR(std::bit_cast<float>(rig.read(0x22BD, 1)), 90.0, 1.0) << "65 K above 25 degrees at rated current";
}

TEST(MsdProtection, CurrentIsThatOfTheWindingsAndNotTheTorque) {
  MsdParameters parameters;
  parameters.motor.load.end_stop_max_rad = 0.5;
  parameters.motor.load.end_stop_min_rad = -0.5;
  parameters.motor.winding.simulated = true;
  parameters.motor.winding.saturation_current_a = 5.0;
  EnabledRig rig(parameters, 10);
  const auto current = [&rig] { return static_cast<std::int16_t>(rig.read(0x6078)); };
  for (const int sign : {1, -1}) {
    rig.target_torque = static_cast<std::int16_t>(sign * 2500);
    rig.cycles(8000);
    const double amplitude = 2.5 * std::numbers::sqrt2 * 2.5;
    EXPECT_NEAR(current(), sign * 2500, 25) << "the current loop carries what was asked for";
    EXPECT_NEAR(rig.torque, sign * 2500 / std::sqrt(1.0 + std::pow(amplitude / 5.0, 2.0)), 25);
  }
  parameters.motor.winding.saturation_current_a = 0.0;
  EnabledRig plain(parameters, 10);
  plain.target_torque = 800;
  plain.cycles(8000);
  EXPECT_NEAR(static_cast<std::int16_t>(plain.read(0x6078)), 800, 8);
  EXPECT_NEAR(plain.torque, 800, 8);
}

TEST(MsdProtection, MotorTemperatureIsMonitoredWithASensor) {
  DriveRig rig;
  rig.drive.heat(1.3, 4000s);  // 135 degC
  rig.set({{0x22DC, 0, 0, 2}, real_value(0x22DD, 7, 0.1F)});
  rig.pass(1s);
  if (rig.drive.fault()) {
    ASSERT_EQ(rig.write(0x2099, 0, 1, 1), 0U);
    rig.pass(5ms);
  }
  EXPECT_FALSE(rig.drive.fault().has_value()) << "no sensor";
  ASSERT_EQ(rig.write(0x22DC, 0, 1, 2), 0U);
  rig.pass(5ms);
  EXPECT_EQ(rig.drive.fault(), Fault::kMotorTemperature);
  EXPECT_EQ(rig.write(0x22DC, 0, 5, 2), 0x06090030U) << "not used";
}

/// The axis can run continuously at the default speed limits, 6000 rpm in 607Fh and 6080h.
TEST(MsdProtection, TheHighestSpeedNeedsNoMoreThanFriction) {
  for (const bool windings : {false, true}) {
    for (const std::int8_t mode : {std::int8_t{9}, std::int8_t{3}, std::int8_t{10}}) {
      for (const int sign : {1, -1}) {
        MsdParameters parameters;
        parameters.motor.winding.simulated = windings;
        EnabledRig rig(parameters, mode);
        rig.target_velocity = sign * 104857600;  // 100 rev/s
        rig.target_torque = static_cast<std::int16_t>(sign * 1000);
        const double friction_nm = 0.03 + 2e-4 * 628.3;
        for (int second = 0; second < 12; ++second) {
          rig.cycles(8000);
          ASSERT_FALSE(rig.drive.fault().has_value())
              << "mode " << int{mode} << " after " << second << " s: " << facts(*rig.drive.fault()).text;
          if (second == 0) continue;  // the acceleration phase
          EXPECT_NEAR(rig.drive.velocity_rad_s(), sign * 628.3, 0.003 * 628.3) << "mode " << int{mode};
          EXPECT_NEAR(rig.drive.torque_nm(), sign * friction_nm, 0.1 * friction_nm) << "mode " << int{mode};
        }
      }
    }
  }
}

/// Work of the torque against friction and inertia, while the drive accelerates to its limit and stays there.
TEST(MsdProtection, NoTorqueVanishesAtTheSpeedLimit) {
  EnabledRig rig(10);
  rig.target_torque = 1000;
  double work_j = 0.0;
  double friction_j = 0.0;
  double last = 0.0;
  for (int i = 0; i < 4 * 8000; ++i) {
    rig.cycle();
    const double mean = 0.5 * (last + rig.drive.velocity_rad_s());
    last = rig.drive.velocity_rad_s();
    work_j += rig.drive.torque_nm() * mean * 125e-6;
    friction_j += (0.03 + 2e-4 * mean) * mean * 125e-6;
  }
  EXPECT_GT(last, 620.0);
  EXPECT_NEAR(work_j, friction_j + 0.5 * 3e-4 * last * last, 0.01 * work_j);
}

TEST(MsdProtection, DcLinkVoltageHasLimitsBothWays) {
  EnabledRig rig(9);
  rig.drive.set_dc_link_voltage(270.0);
  rig.cycles(16);
  EXPECT_TRUE(rig.status & 0x80);
  EXPECT_EQ(rig.read(0x2022), 1U << 9U);
  EXPECT_EQ(rig.read(0x6079), 270'000U);
  EXPECT_EQ(std::bit_cast<float>(rig.read(0x219A)), 270.0F);
  rig.drive.set_dc_link_voltage(240.0);
  rig.cycles(16);
  EXPECT_EQ(rig.drive.fault(), Fault::kDcLinkUndervoltage);
  EXPECT_EQ(rig.status & 0x10, 0) << "voltage enabled";
  rig.drive.set_dc_link_voltage(560.0);
  rig.command(0x80, 4);
  EXPECT_EQ(rig.drive.state(), PowerState::kSwitchOnDisabled);
  rig.drive.set_dc_link_voltage(900.0);
  rig.cycles(16);
  EXPECT_EQ(rig.drive.fault(), Fault::kDcLinkOvervoltage);
}

TEST(MsdProtection, OperatingHoursCountInTheEmergency) {
  struct Case {
    std::uint32_t hours;
    std::array<unsigned, 3> bytes;
  };
  for (const auto& c :
       {Case{0x0302, {0x02, 0x03, 0x00}}, Case{0x0F0302, {0x02, 0x03, 0x0F}}, Case{0x1000000, {0xFF, 0xFF, 0xFF}}}) {
    MsdParameters parameters;
    parameters.operating_hours = std::chrono::hours(c.hours);
    DriveRig rig(parameters);
    rig.drive.set_cause(Fault::kEncoder, true);
    rig.pass(5ms);
    rig.fetch_emergencies();
    ASSERT_EQ(rig.emergencies.size(), 1U);
    EXPECT_THAT(rig.emergencies[0], ElementsAre(0x00, 0x73, 0x21, 10, 1, c.bytes[0], c.bytes[1], c.bytes[2]));
  }
}

TEST(MsdProtection, ALaterFaultThatForbidsTorqueEndsTheReaction) {
  OperatingRig rig;
  rig.run_at(20'000'000);
  rig.device.fall_back(AlState::kOp, AlState::kSafeOp, AlStatusCode::kSyncManagerWatchdog);
  rig.pass(5ms);
  EXPECT_LT(rig.torque, -100);
  rig.drive.set_cause(Fault::kEncoder, true);
  rig.pass(5ms);
  EXPECT_EQ(rig.torque, 0);
  EXPECT_EQ(rig.drive.fault(), Fault::kBusWatchdog);
}

}  // namespace
}  // namespace driveline::slaves::msd
