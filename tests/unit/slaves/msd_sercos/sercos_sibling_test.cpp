// The modes of the profile SERCOS against those of CiA 402 on the same motor: the shaft does the same.
#include "sercos_rig.hpp"

namespace driveline::slaves::msd::sibling_test {
namespace {

constexpr std::int32_t kIncrements = 1 << 20;  ///< position units of the sibling per turn
constexpr double kIncrementRad = kTurnRad / kIncrements;

std::int32_t whole(double value) {
  return static_cast<std::int32_t>(std::lrint(value));
}

struct Pair {
  const char* name;
  std::uint16_t mode;   ///< S-0-0032
  std::int8_t sibling;  ///< 6060h
  std::function<void(SercosRig&)> prepare;
  std::function<void(SiblingRig&)> prepare_sibling;
  std::function<void(SercosRig&, double)> command;  ///< sends the setpoint at this time in s
  std::function<void(SiblingRig&, double)> command_sibling;
};

/// A turn and a half in half a second, smoothly.
double path_rad(double t) {
  return 1.5 * kTurnRad * (0.5 - 0.5 * std::cos(std::numbers::pi * std::min(t / 0.5, 1.0)));
}

void send_position(SercosRig& rig, double t) {
  rig.send(kSercosValue.position_command, whole(path_rad(t) / kUnitRad));
}
void send_position_sibling(SiblingRig& rig, double t) {
  rig.send(kValue.target_position, whole(path_rad(t) / kIncrementRad));
}
void nothing(SercosRig& /*rig*/) {}
void nothing_sibling(SiblingRig& /*rig*/) {}

constexpr double kSpeed = 37.0;          // rad/s
constexpr double kAcceleration = 310.0;  // rad/s2
constexpr double kDeceleration = 170.0;  // rad/s2

void set_ramps_sibling(SiblingRig& rig) {
  rig.write(kValue.max_profile_velocity, static_cast<std::uint32_t>(whole(3 * kSpeed / kIncrementRad)));
  rig.write(kValue.profile_velocity, static_cast<std::uint32_t>(whole(kSpeed / kIncrementRad)));
  rig.write(kValue.profile_acceleration, static_cast<std::uint32_t>(whole(kAcceleration / kIncrementRad)));
  rig.write(kValue.profile_deceleration, static_cast<std::uint32_t>(whole(kDeceleration / kIncrementRad)));
}

void set_profile(SercosRig& rig) {
  rig.write(kSercosValue.positioning_velocity, static_cast<std::uint32_t>(whole(kSpeed / kSpeedUnit)));
  rig.write(kSercosValue.positioning_acceleration, static_cast<std::uint32_t>(whole(kAcceleration / 1e-3)));
  rig.write(kSercosValue.positioning_deceleration, static_cast<std::uint32_t>(whole(kDeceleration / 1e-3)));
}

void no_feed_forward(SiblingRig& rig) {
  rig.write(kValue.speed_feed_forward_scale, 0.0F);
  rig.write(kValue.torque_feed_forward_scale, 0.0F);
}

void send_new_target(SiblingRig& rig, double t) {
  rig.send(kValue.target_position, whole(2.5 * kTurnRad / kIncrementRad));
  rig.send(kValue.control_word, static_cast<std::uint16_t>(t > 0.0005 ? 0x1F : 0x0F));
}

double pulse(double t) {
  return t < 0.2 ? 1.0 : -0.5;
}

/// Of torque: the speed stays below its limits, which differ.
double push(double t) {
  return t < 0.05 ? 1.0 : t < 0.15 ? -0.5 : 0.0;
}

std::vector<Pair> pairs() {
  return {
      {"torque", 0x0001, 10, nothing, nothing_sibling,
       [](auto& rig, double t) {
         rig.send(kSercosValue.torque_command, static_cast<std::int16_t>(whole(110 * push(t))));
       },
       [](auto& rig, double t) { rig.send(kValue.target_torque, static_cast<std::int16_t>(whole(110 * push(t)))); }},
      {"speed", 0x0006, 9, nothing, nothing_sibling,
       [](auto& rig, double t) { rig.send(kSercosValue.velocity_command, whole(kSpeed * pulse(t) / kSpeedUnit)); },
       [](auto& rig, double t) { rig.send(kValue.target_velocity, whole(kSpeed * pulse(t) / kIncrementRad)); }},
      {"speed with ramps", 0x0002, 3,
       [](auto& rig) {
         rig.write(kSercosValue.speed_acceleration, static_cast<std::uint32_t>(whole(kAcceleration / 1e-3)));
         rig.write(kSercosValue.speed_deceleration, static_cast<std::uint32_t>(whole(kDeceleration / 1e-3)));
       },
       set_ramps_sibling,
       [](auto& rig, double t) { rig.send(kSercosValue.velocity_command, whole(kSpeed * pulse(t) / kSpeedUnit)); },
       [](auto& rig, double t) { rig.send(kValue.target_velocity, whole(kSpeed * pulse(t) / kIncrementRad)); }},
      {"position with lag", 0x0003, 8, nothing, no_feed_forward, send_position, send_position_sibling},
      {"position 2 with lag", 0x0004, 8,
       [](auto& rig) { rig.write(kSercosValue.encoder_channels[1], std::uint16_t{1}); }, no_feed_forward, send_position,
       send_position_sibling},
      {"position without lag", 0x000B, 8, nothing, nothing_sibling, send_position, send_position_sibling},
      {"interpolation without lag", 0x001B, 1, set_profile, set_ramps_sibling,
       [](auto& rig, double t) {
         if (t > 0.0005) rig.send(kSercosValue.target_position, whole(2.5 * kTurnRad / kUnitRad));
       },
       send_new_target},
      {"interpolation with lag", 0x0013, 1, set_profile,
       [](auto& rig) {
         set_ramps_sibling(rig);
         no_feed_forward(rig);
       },
       [](auto& rig, double t) {
         if (t > 0.0005) rig.send(kSercosValue.target_position, whole(2.5 * kTurnRad / kUnitRad));
       },
       send_new_target},
  };
}

TEST(SercosSibling, EveryModeMovesTheShaftAsThatOfCia402) {
  for (const auto& pair : pairs()) {
    SCOPED_TRACE(pair.name);
    SercosRig rig(pair.mode);
    SiblingRig sibling(pair.sibling);
    pair.prepare(rig);
    pair.prepare_sibling(sibling);
    rig.enable();
    sibling.enable();
    double furthest = 0.0;
    double apart = 0.0;
    for (int i = 0; i < 8000; ++i) {
      pair.command(rig, i * 125e-6);
      pair.command_sibling(sibling, i * 125e-6);
      rig.cycles(1);
      sibling.cycles(1);
      furthest = std::max(furthest, std::abs(sibling.drive.position_rad()));
      apart = std::max(apart, std::abs(sibling.drive.position_rad() - rig.drive.position_rad()));
    }
    EXPECT_GT(furthest, 2.0);
    EXPECT_LT(apart, 0.01 * furthest);
    EXPECT_EQ(rig.drive.fault(), std::nullopt);
    EXPECT_EQ(sibling.drive.fault(), std::nullopt);
  }
}

/// The lag of the modes without feed-forward is speed by gain; without lag there is none at constant speed.
TEST(SercosSibling, OnlyModesWithoutFeedForwardLag) {
  for (const bool lags : {true, false}) {
    SercosRig rig(lags ? 0x0003 : 0x000B);
    rig.enable();
    constexpr double kRate = 20.0;  // rad/s
    for (int i = 0; i < 4000; ++i) {
      rig.send(kSercosValue.position_command, whole(kRate * i * 125e-6 / kUnitRad));
      rig.cycles(1);
    }
    const double gain = rig.drive.motion().settings().controller.position_gain_per_s;
    const double lag = rig.get(kValue.following_error) * kUnitRad;
    EXPECT_NEAR(lag, lags ? kRate / gain : 0.0, 0.03 * kRate / gain);
    EXPECT_EQ(rig.get(kSercosValue.feed_forward_shown), lags ? 0 : 1);
  }
}

}  // namespace
}  // namespace driveline::slaves::msd::sibling_test
