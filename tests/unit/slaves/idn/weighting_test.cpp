// Weighting of SERCOS data: the manual's tables, numbers calculated by hand, and round trips of exact fractions.
#include "driveline/slaves/msd/core/sercos/weighting.hpp"

#include <gmock/gmock.h>

#include <random>
#include <string>
#include <vector>

namespace driveline::slaves::msd::sercos {
namespace {

using enum WeightedData;

/// A motor whose rated torque and encoder are no powers of ten.
constexpr WeightedMotor kMotor{.encoder_increments = 1U << 20U, .rated_torque_nm = 2.4};
constexpr std::int64_t kTurn = 1 << 20;  ///< increments

/// Type, factor and exponent of a weighting, and the unit that follows.
struct UnitCase {
  const char* what;
  WeightedData data;
  std::uint16_t type;
  std::uint16_t factor;
  std::int16_t exponent;
  const char* text;
  unsigned decimals;
  unsigned conversion;
  double si;
};

WeightingSettings settings_of(const UnitCase& c) {
  WeightingSettings s;
  switch (c.data) {
    case kPosition:
      s.position_type = c.type;
      s.position_factor = c.factor;
      s.position_exponent = c.exponent;
      break;
    case kSpeed:
      s.speed_type = c.type;
      s.speed_factor = c.factor;
      s.speed_exponent = c.exponent;
      break;
    case kAcceleration:
      s.acceleration_type = c.type;
      s.acceleration_factor = c.factor;
      s.acceleration_exponent = c.exponent;
      break;
    case kTorque:
      s.torque_type = c.type;
      s.torque_factor = c.factor;
      s.torque_exponent = c.exponent;
      break;
    case kTemperature:
      break;
  }
  return s;
}

void expect_unit(const UnitCase& c) {
  SCOPED_TRACE(c.what);
  const Weighting weighting(settings_of(c), kMotor);
  const auto& unit = weighting.unit(c.data);
  EXPECT_EQ(unit.text.view(), c.text);
  EXPECT_EQ(unit.decimals, c.decimals);
  EXPECT_EQ(unit.conversion_factor, c.conversion);
  EXPECT_NEAR(unit.si, c.si, 1e-13 * c.si);
  EXPECT_NEAR(weighting.to_si(c.data, -7321), -7321 * c.si, 1e-9 * c.si);
  EXPECT_EQ(weighting.from_si(c.data, -7321 * c.si), -7321);
}

/// SERCOS manual, Tables 7.2, 7.3, 7.8, 7.9, 7.13, 7.14, 7.17, 7.18 and line 1333. Factor and exponent have no effect.
TEST(SercosWeighting, PreferredWeightingsAreThoseOfTheManual) {
  for (const auto& c : {
           UnitCase{"0.1 um", kPosition, 0x01, 9, 5, "m", 7, 1, 1e-7},
           UnitCase{"0.0001 degrees", kPosition, 0x02, 9, 5, "deg", 4, 1, 1.7453292519943296e-6},
           UnitCase{"0.001 mm/min", kSpeed, 0x01, 9, 5, "m/min", 6, 1, 1.6666666666666667e-8},
           UnitCase{"0.0001 1/min", kSpeed, 0x02, 9, 5, "1/min", 4, 1, 1.0471975511965978e-5},
           UnitCase{"0.000 001 1/s", kSpeed, 0x22, 9, 5, "1/s", 6, 1, 6.283185307179586e-6},
           UnitCase{"0.001 mm/s2", kAcceleration, 0x01, 9, 5, "m/s2", 6, 1, 1e-6},
           UnitCase{"0.001 rad/s2", kAcceleration, 0x02, 9, 5, "rad/s2", 3, 1, 1e-3},
           UnitCase{"0.1 % of 2.4 Nm", kTorque, 0x00, 9, 5, "%", 1, 1, 2.4e-3},
           UnitCase{"1 N", kTorque, 0x01, 9, 5, "N", 0, 1, 1.0},
           UnitCase{"0.01 Nm", kTorque, 0x02, 9, 5, "Nm", 2, 1, 1e-2},
           UnitCase{"0.1 degrees Celsius", kTemperature, 0, 9, 5, "degC", 1, 1, 0.1},
       }) {
    expect_unit(c);
  }
}

/// 1 inch is 25.4 mm, 1 lbf is 4.4482216152605 N. The unit is from bit 4 of the type, the time from bit 5.
TEST(SercosWeighting, ParametersSetFactorAndExponent) {
  for (const auto& c : {
           UnitCase{"25 * 10^-4 in", kPosition, 0x19, 25, -4, "in", 4, 25, 6.35e-5},
           UnitCase{"3 * 10^-6 m", kPosition, 0x09, 3, -6, "m", 6, 3, 3e-6},
           UnitCase{"7 * 10^-3 in/s", kSpeed, 0x39, 7, -3, "in/s", 3, 7, 1.778e-4},
           UnitCase{"7 * 10^-3 in/min", kSpeed, 0x19, 7, -3, "in/min", 3, 7, 2.963333333333333e-6},
           UnitCase{"300 1/min", kSpeed, 0x0A, 3, 2, "1/min", 0, 300, 31.41592653589793},
           UnitCase{"60000 * 10^6 1/s", kSpeed, 0x2A, 60000, 6, "10^6 1/s", 0, 60000, 376991118430.77515},
           UnitCase{"2 * 10^-15 m/s", kSpeed, 0x29, 2, -15, "m/s", 15, 2, 2e-15},
           UnitCase{"3 * 10^-2 in/s2", kAcceleration, 0x19, 3, -2, "in/s2", 2, 3, 7.62e-4},
           UnitCase{"40 rad/s2", kAcceleration, 0x0A, 4, 1, "rad/s2", 0, 40, 40.0},
           UnitCase{"20 lbf", kTorque, 0x19, 2, 1, "lbf", 0, 20, 88.96443230521},
           UnitCase{"0.5 in lbf", kTorque, 0x1A, 5, -1, "in lbf", 1, 5, 0.05649241451380835},
       }) {
    expect_unit(c);
  }
}

/// The number of the display is value * factor / 10^decimals; where a degree has no such fraction, the text tells it.
TEST(SercosWeighting, RotaryResolutionIsDisplayedExactly) {
  struct Case {
    std::uint32_t resolution;
    const char* text;
    unsigned conversion;
    unsigned decimals;
  };
  for (const auto& c : {Case{3600000, "deg", 1, 4}, Case{1000000, "deg", 36, 5}, Case{5, "deg", 72, 0},
                        Case{64, "deg", 5625, 3}, Case{4096, "rev/4096", 1, 0}, Case{1 << 20, "rev/1048576", 1, 0},
                        Case{7, "rev/7", 1, 0}, Case{4294967295, "rev/4294967295", 1, 0}}) {
    WeightingSettings s;
    s.position_type = 0x0A;
    s.rotary_resolution = c.resolution;
    const auto unit = Weighting(s, kMotor).unit(kPosition);
    EXPECT_EQ(unit.text.view(), c.text);
    EXPECT_EQ(unit.conversion_factor, c.conversion);
    EXPECT_EQ(unit.decimals, c.decimals);
    EXPECT_NEAR(unit.si, 6.283185307179586 / c.resolution, 1e-20);
  }
}

TEST(SercosWeighting, WithoutMethodDataAreIncrementsOfTheEncoder) {
  WeightingSettings s;
  s.position_type = s.speed_type = s.acceleration_type = 0x48;  // "none" ignores the other bits
  const WeightedMotor motor{.encoder_increments = 5000, .rated_torque_nm = 2.4};
  const Weighting weighting(s, motor);
  EXPECT_EQ(weighting.unit(kPosition).text.view(), "incr");
  EXPECT_EQ(weighting.unit(kSpeed).text.view(), "incr/s");
  EXPECT_EQ(weighting.unit(kAcceleration).text.view(), "incr/s2");
  for (const auto data : {kPosition, kSpeed, kAcceleration}) {
    EXPECT_TRUE(weighting.unweighted(data));
    EXPECT_FALSE(Weighting().unweighted(data));
    EXPECT_NEAR(weighting.unit(data).si, 1.2566370614359173e-3, 1e-16);
  }
  EXPECT_FALSE(weighting.unweighted(kTorque)) << "percent";
  EXPECT_EQ(weighting.scaling().to_increments(-12345), -12345);
  EXPECT_NEAR(weighting.scaling().position_rad, 1.2566370614359173e-3, 1e-16);
  EXPECT_NEAR(weighting.scaling().velocity_rad_s, 1.2566370614359173e-3, 1e-16);
  EXPECT_NEAR(weighting.scaling().acceleration_rad_s2, 1.2566370614359173e-3, 1e-16);
}

/// A gear of 7 motor revolutions to 2 of the load, whose spindle moves 5 mm per revolution: with the data on the load
/// side, every unit is 7 / 2 times as much at the motor as with the data on the motor, and a torque 2 / 7.
TEST(SercosWeighting, LoadSideDiffersFromMotorSideByTheGear) {
  struct Case {
    const char* what;
    unsigned method;
    double position_rad;
    double velocity_rad_s;
    double acceleration_rad_s2;
    double torque_nm;
  };
  for (const auto& c :
       {Case{"rotary", 2, 1.7453292519943296e-6, 1.0471975511965978e-5, 1e-3, 1e-2},
        Case{"linear", 1, 1.2566370614359173e-4, 2.0943951023931954e-5, 1.2566370614359173e-3, 7.957747154594768e-4}}) {
    for (const unsigned side : {0x00U, 0x40U}) {
      SCOPED_TRACE(std::string(c.what) + (side == 0 ? " motor" : " load"));
      WeightingSettings s;
      s.gear_input = 7;
      s.gear_output = 2;
      s.feed_um = 5000;
      s.position_type = s.speed_type = s.acceleration_type = s.torque_type =
          static_cast<std::uint16_t>(c.method | side);
      const Weighting weighting(s, kMotor);
      const double gear = side == 0 ? 1.0 : 3.5;
      EXPECT_NEAR(weighting.scaling().position_rad, gear * c.position_rad, 1e-12 * c.position_rad);
      EXPECT_NEAR(weighting.scaling().velocity_rad_s, gear * c.velocity_rad_s, 1e-12 * c.velocity_rad_s);
      EXPECT_NEAR(weighting.scaling().acceleration_rad_s2, gear * c.acceleration_rad_s2, 1e-12 * c.acceleration_rad_s2);
      EXPECT_NEAR(weighting.motor_torque_nm(), c.torque_nm / gear, 1e-12 * c.torque_nm);
      EXPECT_FALSE(weighting.scaling().inverted);
      EXPECT_NEAR(static_cast<double>(weighting.scaling().to_increments(1'000'000'000)),
                  1e9 * gear * c.position_rad / 6.283185307179586 * kTurn, 0.51);
    }
  }
  WeightingSettings percent;
  percent.gear_input = 7;
  percent.torque_type = 0x40;
  EXPECT_NEAR(Weighting(percent, kMotor).motor_torque_nm(), 2.4e-3, 1e-15) << "of the rated torque on either side";
}

/// Fractions of units and increments in which one of both is finer than the other.
struct FractionCase {
  const char* what;
  WeightingSettings settings;
  std::uint32_t encoder;
  __int128 units;  ///< as many units are as many increments
  __int128 increments;
};

std::vector<FractionCase> fraction_cases() {
  std::vector<FractionCase> cases;
  cases.push_back({"preferred rotary", {}, 1U << 20U, 3600000, 1 << 20});
  WeightingSettings coarse;
  coarse.position_type = 0x0A;
  coarse.rotary_resolution = 1000;
  cases.push_back({"1000 per revolution", coarse, 1U << 20U, 1000, 1 << 20});
  coarse.position_type = 0x4A;
  coarse.rotary_resolution = 65521;
  coarse.gear_input = 7;
  coarse.gear_output = 3;
  cases.push_back({"65521 per revolution of a load", coarse, 1U << 20U, 65521 * 3, 7 << 20});
  WeightingSettings inch;
  inch.position_type = 0x59;
  inch.speed_type = inch.acceleration_type = 0x01;
  inch.position_factor = 3;
  inch.position_exponent = -5;
  inch.gear_input = 11;
  inch.gear_output = 13;
  inch.feed_um = 10007;
  // 3 * 10^-5 in = 0.762 um; one revolution of the load is 10007 um: 10007000 / 762 units, and 11 / 13 of the motor.
  cases.push_back({"inches behind a gear", inch, 4096, __int128{10007000} * 13, __int128{762} * 11 * 4096});
  return cases;
}

std::int64_t rounded(__int128 numerator, __int128 divisor) {
  return static_cast<std::int64_t>((2 * numerator + (numerator < 0 ? -divisor : divisor)) / (2 * divisor));
}

TEST(SercosWeighting, ConversionsAreExactFractionsAndLoseNothing) {
  std::mt19937_64 random(20140401);
  std::uniform_int_distribution<std::int64_t> numbers(-(std::int64_t{1} << 42), std::int64_t{1} << 42);
  for (const auto& c : fraction_cases()) {
    SCOPED_TRACE(c.what);
    const WeightedMotor motor{c.encoder, 2.4};
    ASSERT_TRUE(valid(c.settings, motor));
    const Weighting weighting(c.settings, motor);
    const auto& scaling = weighting.scaling();
    for (int i = 0; i < 20'000; ++i) {
      const std::int64_t number = i == 0 ? 1'000'000'000 : numbers(random);
      ASSERT_EQ(scaling.to_increments(number), rounded(number * c.increments, c.units)) << number;
      ASSERT_EQ(scaling.to_units(number), rounded(number * c.units, c.increments)) << number;
      if (c.units >= c.increments) {
        ASSERT_EQ(scaling.to_increments(scaling.to_units(number)), number);
      } else {
        ASSERT_EQ(scaling.to_units(scaling.to_increments(number)), number);
      }
    }
  }
}

/// A table behind a gear of 7 to 3 is at 0 again after 3 revolutions of its own, no matter how many it has made.
TEST(SercosWeighting, ModuloPositionsDoNotDriftInAMillionTurns) {
  WeightingSettings s;
  s.position_type = 0xC2;
  s.gear_input = 7;
  s.gear_output = 3;
  s.modulo = 1'200'000;
  s.modulo_divisor = 3;
  const Weighting weighting(s, kMotor);
  for (std::int64_t turns = -1'000'002; turns <= 1'000'002; turns += 3) {
    const std::int64_t increments = turns / 3 * 7 * kTurn;
    ASSERT_EQ(weighting.scaling().to_units(increments), turns * 3'600'000);
    ASSERT_EQ(weighting.range().wrap(weighting.scaling().to_units(increments)), 0);
    ASSERT_EQ(weighting.range().wrap(weighting.scaling().to_units(increments - 1)), 3'599'999)
        << "an increment is 1.47 units";
  }
}

TEST(SercosWeighting, ModuloRangeIsValueTimesDivisor) {
  WeightingSettings s;
  s.modulo = 700'000;
  s.modulo_divisor = 5;
  EXPECT_FALSE(Weighting(s, kMotor).range().limited()) << "absolute format";
  s.position_type = 0x82;
  const auto range = Weighting(s, kMotor).range();
  EXPECT_EQ(range.wrap(3'499'999), 3'499'999);
  EXPECT_EQ(range.wrap(3'500'000), 0);
  EXPECT_EQ(range.wrap(-1), 3'499'999);
  EXPECT_EQ(range.nearest(3'400'000, 20'000), 3'520'000) << "the short way, over the end (SERCOS manual 1146)";
  s.modulo_divisor = 1;
  EXPECT_EQ(Weighting(s, kMotor).range().wrap(700'000), 0) << "SERCOS manual 1150";
  s.modulo = 1U << 30U;
  s.modulo_divisor = 2;
  EXPECT_EQ(Weighting(s, kMotor).range().wrap(INT64_C(0x80000000)), 0) << "all positive numbers of 32 bits";
  EXPECT_TRUE(valid(s, kMotor));
}

/// Each bit of the polarity words (SERCOS manual, Tables 7.6, 7.11, 7.20) inverts its own value alone.
TEST(SercosWeighting, EachPolarityInvertsItsOwnValue) {
  using Word = std::uint16_t WeightingSettings::*;
  struct Case {
    Word word;
    unsigned bit;
    Polarity polarity;
  };
  constexpr Word kPositionWord = &WeightingSettings::position_polarity;
  constexpr Word kSpeedWord = &WeightingSettings::speed_polarity;
  constexpr Word kTorqueWord = &WeightingSettings::torque_polarity;
  const std::vector<Case> cases = {{kPositionWord, 0, Polarity::kPositionSetpoint},
                                   {kPositionWord, 1, Polarity::kPositionAdditive},
                                   {kPositionWord, 2, Polarity::kPosition1},
                                   {kPositionWord, 3, Polarity::kPosition2},
                                   {kPositionWord, 4, Polarity::kPositionLimits},
                                   {kSpeedWord, 0, Polarity::kSpeedSetpoint},
                                   {kSpeedWord, 1, Polarity::kSpeedAdditive},
                                   {kSpeedWord, 2, Polarity::kSpeed1},
                                   {kSpeedWord, 3, Polarity::kSpeed2},
                                   {kTorqueWord, 0, Polarity::kTorqueSetpoint},
                                   {kTorqueWord, 1, Polarity::kTorqueAdditive},
                                   {kTorqueWord, 2, Polarity::kTorque}};
  for (const auto& set : cases) {
    WeightingSettings s;
    s.*set.word = static_cast<std::uint16_t>(1U << set.bit);
    EXPECT_TRUE(valid(s, kMotor));
    const Weighting weighting(s, kMotor);
    for (const auto& c : cases) {
      EXPECT_EQ(weighting.turned(c.polarity, 4711), c.polarity == set.polarity ? -4711 : 4711);
    }
    EXPECT_EQ(weighting.turned(Polarity::kNever, 4711), 4711);
    EXPECT_GT(weighting.scaling().position_rad, 0.0) << "nothing in the loop is inverted";
    EXPECT_GT(weighting.scaling().velocity_rad_s, 0.0);
  }
}

/// IDNs of the rules that settings break, in the order of the rules.
std::vector<unsigned> broken(const WeightingSettings& s) {
  std::vector<unsigned> idns;
  for (const auto& rule : weighting_rules()) {
    if (!rule.broken(s)) continue;
    idns.push_back(rule.idn);
    EXPECT_FALSE(rule.reason.empty());
  }
  EXPECT_EQ(valid(s, kMotor), idns.empty());
  return idns;
}

TEST(SercosWeighting, SettingsThatContradictAreTold) {
  struct Case {
    const char* what;
    void (*change)(WeightingSettings& s);
    std::vector<unsigned> idns;
  };
  const std::vector<Case> cases = {
      {"default", [](WeightingSettings&) {}, {}},
      {"none at all", [](auto& s) { s.position_type = s.speed_type = s.acceleration_type = 0; }, {}},
      {"speed without weighting", [](auto& s) { s.speed_type = 0; }, {}},
      {"linear", [](auto& s) { s.position_type = s.speed_type = s.acceleration_type = 0x51; }, {}},
      {"force on a rotary axis", [](auto& s) { s.torque_type = 0x51; }, {}},
      {"torque in in lbf", [](auto& s) { s.torque_type = 0x52; }, {}},
      {"method 3", [](auto& s) { s.torque_type = 3; }, {86}},
      {"method 7", [](auto& s) { s.position_type = 7; }, {76, 44, 160}},
      {"position bit 5", [](auto& s) { s.position_type = 0x22; }, {76}},
      {"position bit 8", [](auto& s) { s.position_type = 0x102; }, {76}},
      {"position bit 15", [](auto& s) { s.position_type = 0x8002; }, {76}},
      {"rotary inches", [](auto& s) { s.position_type = 0x12; }, {76}},
      {"speed bit 7", [](auto& s) { s.speed_type = 0x82; }, {44}},
      {"speed in rotary inches", [](auto& s) { s.speed_type = 0x12; }, {44}},
      {"speed in seconds", [](auto& s) { s.speed_type = 0x22; }, {}},
      {"acceleration bit 5", [](auto& s) { s.acceleration_type = 0x22; }, {160}},
      {"acceleration bit 7", [](auto& s) { s.acceleration_type = 0x82; }, {160}},
      {"torque bit 5", [](auto& s) { s.torque_type = 0x20; }, {86}},
      {"torque bit 7", [](auto& s) { s.torque_type = 0x82; }, {86}},
      {"linear speed of a rotary position", [](auto& s) { s.speed_type = 1; }, {44}},
      {"linear acceleration of a rotary position", [](auto& s) { s.acceleration_type = 1; }, {160}},
      {"factors 0",
       [](auto& s) { s.position_factor = s.speed_factor = s.acceleration_factor = s.torque_factor = 0; },
       {77, 45, 161, 93}},
      {"resolution 0", [](auto& s) { s.rotary_resolution = 0; }, {79}},
      {"exponents 7",
       [](auto& s) { s.position_exponent = s.speed_exponent = s.acceleration_exponent = s.torque_exponent = 7; },
       {78, 46, 162, 94}},
      {"exponents -16",
       [](auto& s) { s.position_exponent = s.speed_exponent = s.acceleration_exponent = s.torque_exponent = -16; },
       {78, 46, 162, 94}},
      {"exponents -15 and 6",
       [](auto& s) {
         s.position_exponent = s.speed_exponent = -15;
         s.acceleration_exponent = s.torque_exponent = 6;
       },
       {}},
      {"temperature bit 0", [](auto& s) { s.temperature_type = 1; }, {208}},
      {"polarities beyond the last",
       [](auto& s) {
         s.speed_polarity = 0x10;
         s.position_polarity = 0x20;
         s.torque_polarity = 0x08;
       },
       {43, 55, 85}},
      {"modulo 0 of an absolute position", [](auto& s) { s.modulo = 0; }, {}},
      {"modulo 0",
       [](auto& s) {
         s.position_type = 0x82;
         s.modulo = 0;
       },
       {103}},
      {"modulo divisor 0",
       [](auto& s) {
         s.position_type = 0x82;
         s.modulo_divisor = 0;
       },
       {103}},
      {"modulo of 2147483649",
       [](auto& s) {
         s.position_type = 0x82;
         s.modulo = 715827883;
         s.modulo_divisor = 3;
       },
       {103}},
      {"modulo beyond 32 bits",
       [](auto& s) {
         s.position_type = 0x82;
         s.modulo = 0x80000000;
         s.modulo_divisor = 4;
       },
       {103}},
      {"gear and feed 0", [](auto& s) { s.gear_input = s.gear_output = s.feed_um = 0; }, {121, 122, 123}},
  };
  for (const auto& c : cases) {
    WeightingSettings s;
    c.change(s);
    EXPECT_EQ(broken(s), c.idns) << c.what;
    static_cast<void>(Weighting(s, kMotor));  // no division by zero
  }
}

TEST(SercosWeighting, AGearThatNoFractionOf63BitsConvertsIsInvalid) {
  WeightingSettings s;
  s.position_type = 0x4A;
  s.gear_input = 4294967291;  // primes
  s.gear_output = 4294967279;
  EXPECT_TRUE(exact(s, kMotor)) << "3600000 / 2^20 leaves enough bits";
  s.rotary_resolution = 4294967231;
  for (const auto& rule : weighting_rules()) EXPECT_FALSE(rule.broken(s)) << rule.reason;
  EXPECT_FALSE(exact(s, kMotor));
  EXPECT_FALSE(valid(s, kMotor));
}

}  // namespace
}  // namespace driveline::slaves::msd::sercos
