// Setpoints of speed and torque within the limits of each direction; the least counts.
#include "driveline/slaves/msd/core/sercos/sercos_limits.hpp"

#include "sercos_rig.hpp"

namespace driveline::slaves::msd::limits_test {
namespace {

constexpr double kRated = 2.4;  // Nm
constexpr double kMost = 3.0 * kRated;
constexpr double kTorqueUnit = 2.4e-3;  // Nm
constexpr double kRatedSpeed = 3000.0 * kRpm;

struct Row {
  const char* what;
  std::function<void(ObjectDictionary&)> set;
  double lowest;
  double highest;
};

TEST(SercosLimits, TheLeastSpeedOfADirectionCounts) {
  Scaling scaling;
  scaling.velocity_rad_s = kSpeedUnit;
  for (const auto& [what, set, lowest, highest] : std::vector<Row>{
           {"defaults: the rated speed", [](auto&) {}, -kRatedSpeed, kRatedSpeed},
           {"S-0-0038", [](auto& d) { d.set(kSercosValue.positive_velocity_limit, 2'000'000); }, -kRatedSpeed,
            200 * kRpm},
           {"S-0-0039", [](auto& d) { d.set(kSercosValue.negative_velocity_limit, -3'000'000); }, -300 * kRpm,
            kRatedSpeed},
           {"S-0-0091", [](auto& d) { d.set(kSercosValue.velocity_limit, 2'500'000U); }, -250 * kRpm, 250 * kRpm},
           {"P 328", [](auto& d) { d.set(kSercosValue.speed_share, 40.0F); }, -1200 * kRpm, 1200 * kRpm},
           {"P 333", [](auto& d) { d.set(kSercosValue.negative_speed_share, 30.0F); }, -900 * kRpm, kRatedSpeed},
           {"P 334", [](auto& d) { d.set(kSercosValue.positive_speed_share, 20.0F); }, -kRatedSpeed, 600 * kRpm},
           {"P 458", [](auto& d) { d.set(kSercosValue.rated_speed, 700.0F); }, -700 * kRpm, 700 * kRpm},
       }) {
    SCOPED_TRACE(what);
    ObjectDictionary dictionary(sercos_table());
    set(dictionary);
    const auto range = speed_limits(dictionary, scaling);
    EXPECT_NEAR(range.lowest, lowest, 1e-4);
    EXPECT_NEAR(range.highest, highest, 1e-4);
    dictionary.set(kSercosValue.velocity_command, 50'000'000);
    EXPECT_NEAR(speed_command(dictionary, scaling), highest, 1e-4);
    dictionary.set(kSercosValue.velocity_command, -50'000'000);
    EXPECT_NEAR(speed_command(dictionary, scaling), lowest, 1e-4);
  }
}

TEST(SercosLimits, TheLeastTorqueOfADirectionCounts) {
  for (const auto& [what, set, lowest, highest] : std::vector<Row>{
           {"defaults: three times P 460", [](auto&) {}, -kMost, kMost},
           {"S-0-0082", [](auto& d) { d.set(kSercosValue.positive_torque_limit, std::int16_t{700}); }, -kMost,
            0.7 * kRated},
           {"S-0-0083", [](auto& d) { d.set(kSercosValue.negative_torque_limit, std::int16_t{-600}); }, -0.6 * kRated,
            kMost},
           {"S-0-0092", [](auto& d) { d.set(kSercosValue.torque_limit, std::uint16_t{500}); }, -0.5 * kRated,
            0.5 * kRated},
           {"P 329", [](auto& d) { d.set(kSercosValue.torque_share, 200.0F); }, -2 * kRated, 2 * kRated},
           {"P 330", [](auto& d) { d.set(kSercosValue.negative_torque_share, 30.0F); }, -0.3 * kMost, kMost},
           {"P 331", [](auto& d) { d.set(kSercosValue.positive_torque_share, 20.0F); }, -kMost, 0.2 * kMost},
           {"P 332", [](auto& d) { d.set(kSercosValue.online_torque_share, 10.0F); }, -0.1 * kMost, 0.1 * kMost},
       }) {
    SCOPED_TRACE(what);
    ObjectDictionary dictionary(sercos_table());
    set(dictionary);
    dictionary.set(kSercosValue.torque_command, std::int16_t{32'000});
    EXPECT_NEAR(torque_command(dictionary, kTorqueUnit, kRated), highest, 1e-6);
    dictionary.set(kSercosValue.torque_command, std::int16_t{-32'000});
    EXPECT_NEAR(torque_command(dictionary, kTorqueUnit, kRated), lowest, 1e-6);
  }
}

TEST(SercosLimits, CommandsAreSumsAndTheSpeedIsScaled) {
  ObjectDictionary dictionary(sercos_table());
  Scaling scaling;
  scaling.velocity_rad_s = kSpeedUnit;
  dictionary.set(kSercosValue.velocity_command, 3'000'000);
  dictionary.set(kSercosValue.additive_velocity, -1'000'000);
  dictionary.set(kSercosValue.speed_override, 30.0F);
  EXPECT_NEAR(speed_command(dictionary, scaling), 60 * kRpm, 1e-6);
  dictionary.set(kSercosValue.torque_command, std::int16_t{300});
  dictionary.set(kSercosValue.additive_torque, std::int16_t{-120});
  EXPECT_NEAR(torque_command(dictionary, kTorqueUnit, kRated), 180 * kTorqueUnit, 1e-9);
}

/// With inverted polarity the limits of the operation data are those of the other direction of the shaft.
TEST(SercosLimits, FollowThePolarity) {
  ObjectDictionary dictionary(sercos_table());
  Scaling scaling;
  scaling.velocity_rad_s = -kSpeedUnit;
  dictionary.set(kSercosValue.positive_velocity_limit, 2'000'000);
  dictionary.set(kSercosValue.velocity_command, 9'000'000);
  EXPECT_NEAR(speed_command(dictionary, scaling), -200 * kRpm, 1e-6);
  dictionary.set(kSercosValue.positive_torque_limit, std::int16_t{400});
  dictionary.set(kSercosValue.torque_command, std::int16_t{700});
  EXPECT_NEAR(torque_command(dictionary, -kTorqueUnit, kRated), -400 * kTorqueUnit, 1e-9);
}

TEST(SercosLimits, ATorqueUnitIsAShareOfP460UnlessTheScaleHasOne) {
  SercosScale scale;
  EXPECT_NEAR(torque_unit(scale, kRated), kTorqueUnit, 1e-12);
  scale.torque_nm = -0.01;
  EXPECT_NEAR(torque_unit(scale, kRated), -0.01, 1e-12);
}

}  // namespace
}  // namespace driveline::slaves::msd::limits_test
