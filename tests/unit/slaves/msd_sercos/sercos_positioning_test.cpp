// Positioning by S-0-0346 and S-0-0393, and the override of the drive's profile.
#include "sercos_rig.hpp"

namespace driveline::slaves::msd::positioning_test {
namespace {

constexpr double kVelocity = 300 * kRpm;

class PositioningRig : public SercosRig {
 public:
  explicit PositioningRig(std::uint32_t modulo = 0) : SercosRig(0x001B) {
    write(kSercosValue.positioning_velocity, 3'000'000U);  // 300 rpm
    write(kSercosValue.positioning_acceleration, 2'000'000U);
    if (modulo != 0) {
      auto scale = SercosScale::preferred(1U << 20U);
      scale.modulo = modulo;
      drive.profile().sercos()->use(scale);
      drive.initialise_units();
    }
    drive.profile().sercos()->carry_positioning(true);
    enable();
  }

  /// Takes a target by the rise of bit 0; returns where the axis then stands, in turns.
  double go(std::int32_t target, std::uint16_t bits = 0) {
    send(kSercosValue.positioning_command, target);
    send(kSercosValue.positioning_control, static_cast<std::uint16_t>(bits | 1U));
    cycles(4);
    EXPECT_EQ(get(kSercosValue.setpoint_acknowledge), 1);
    send(kSercosValue.positioning_control, bits);
    cycles(2);
    EXPECT_EQ(get(kSercosValue.setpoint_acknowledge), 0);
    cycles(12'000);
    return drive.position_rad() / kTurnRad;
  }
};

struct Move {
  const char* what;
  std::int32_t target;
  std::uint16_t bits;
  double turns;  ///< where the axis stands then
};

TEST(SercosPositioning, TargetsAreAbsoluteOrRelative) {
  PositioningRig rig;
  for (const auto& [what, target, bits, turns] : std::vector<Move>{
           {"absolute", kTurn, 0, 1.0},
           {"absolute back", -kTurn / 2, 0, -0.5},
           {"relative to the target", kTurn, 0x08, 0.5},
           {"adds up", kTurn, 0x08, 1.5},
           {"relative to the actual position", -2 * kTurn, 0x18, -0.5},
       }) {
    EXPECT_NEAR(rig.go(target, bits), turns, 1e-4) << what;
    EXPECT_EQ(rig.get(kSercosValue.in_position), 1) << what;
    EXPECT_NEAR(rig.get(kSercosValue.active_target), turns * kTurn, 400) << what;
  }
}

/// Two relative targets at once add up; from the actual position the second begins where the axis is.
TEST(SercosPositioning, RelativeTargetsInMotion) {
  for (const bool from_actual : {false, true}) {
    PositioningRig rig;
    const auto bits = static_cast<std::uint16_t>(from_actual ? 0x18 : 0x08);
    rig.send(kSercosValue.positioning_command, 2 * kTurn);
    for (int i = 0; i < 2; ++i) {
      rig.send(kSercosValue.positioning_control, static_cast<std::uint16_t>(bits | 1U));
      rig.cycles(800);
      rig.send(kSercosValue.positioning_control, bits);
      rig.cycles(2);
    }
    rig.cycles(16'000);
    const double turns = rig.drive.position_rad() / kTurnRad;
    if (from_actual) {
      EXPECT_GT(turns, 2.1);
      EXPECT_LT(turns, 3.0);
    } else {
      EXPECT_NEAR(turns, 4.0, 1e-4);
    }
  }
}

TEST(SercosPositioning, JogsAndHalts) {
  PositioningRig rig;
  struct Step {
    std::uint16_t bits;
    double speed;
  };
  for (const auto& [bits, speed] :
       std::vector<Step>{{0x02, kVelocity}, {0x06, 0.0}, {0x04, -kVelocity}, {0x02, kVelocity}, {0x00, 0.0}}) {
    rig.send(kSercosValue.positioning_control, bits);
    rig.cycles(3000);
    EXPECT_NEAR(rig.drive.velocity_rad_s(), speed, 0.02 * kVelocity) << bits;
  }
  EXPECT_NEAR(rig.go(kTurn), 1.0, 1e-4) << "a new target goes on";
}

TEST(SercosPositioning, ATargetIsTakenOnceAndNotWhileJogging) {
  PositioningRig rig;
  rig.send(kSercosValue.positioning_command, kTurn);
  rig.send(kSercosValue.positioning_control, std::uint16_t{0x07});  // halt
  rig.cycles(4);
  EXPECT_EQ(rig.get(kSercosValue.setpoint_acknowledge), 0);
  rig.send(kSercosValue.positioning_control, std::uint16_t{0x01});  // bit 0 has not risen since
  rig.cycles(4000);
  EXPECT_NEAR(rig.drive.position_rad(), 0.0, 1e-3);
}

TEST(SercosPositioning, AChangeOfTheModeClearsTheAcknowledgement) {
  PositioningRig rig;
  rig.write(kSercosValue.modes[1], std::uint16_t{0x0006});
  rig.send(kSercosValue.positioning_command, kTurn);
  rig.send(kSercosValue.positioning_control, std::uint16_t{0x01});
  rig.cycles(4);
  ASSERT_EQ(rig.get(kSercosValue.setpoint_acknowledge), 1);
  rig.control(0xE100, 4);
  EXPECT_EQ(rig.get(kSercosValue.setpoint_acknowledge), 0);
}

TEST(SercosPositioning, WrittenByTheServiceChannelItActsFromThenOn) {
  SercosRig rig(0x001B);
  rig.enable();
  rig.send(kSercosValue.target_position, kTurn / 4);
  rig.cycles(4000);
  EXPECT_NEAR(rig.drive.position_rad(), kTurnRad / 4, 1e-3) << "interpolation";
  rig.send(kSercosValue.positioning_command, -kTurn / 4);
  rig.write(kSercosValue.positioning_control, std::uint16_t{1});
  rig.cycles(4000);
  EXPECT_NEAR(rig.drive.position_rad(), -kTurnRad / 4, 1e-3) << "positioning";
}

struct Way {
  const char* what;
  std::uint16_t direction;  ///< S-0-0393
  std::uint32_t near;       ///< S-0-0418
  std::int32_t slow;        ///< S-0-0417
  std::int32_t target;      ///< in 1000 units per turn
  double turns;             ///< from the start at 0.1
};

/// An endless axis with 1000 units per half turn of the shaft, at 100 to begin with.
TEST(SercosPositioning, AnEndlessAxisTakesTheWayOfS0393) {
  constexpr std::uint32_t kModulo = 1'800'000;
  for (const auto& [what, direction, near, slow, target, turns] : std::vector<Way>{
           {"positive", 0, 0, 0, 50, 0.475},
           {"negative", 1, 0, 0, 50, -0.025},
           {"shortest", 2, 0, 0, 50, -0.025},
           {"shortest, the other way", 2, 0, 0, 200, 0.05},
           {"negative to the other side", 1, 0, 0, 200, -0.45},
           {"inside the window the short way", 0, 100'000, 0, 50, -0.025},
           {"outside the window", 0, 50'000, 0, 50, 0.475},
           {"below the speed the short way", 0, 0, 10'000, 50, -0.025},
       }) {
    SCOPED_TRACE(what);
    PositioningRig rig(kModulo);
    rig.go(static_cast<std::int32_t>(kModulo / 10));
    const double begin = rig.drive.position_rad() / kTurnRad;
    rig.write(kSercosValue.positioning_mode, direction);
    rig.write(kSercosValue.short_way_window, near);
    rig.write(kSercosValue.short_way_velocity, slow);
    EXPECT_NEAR(rig.go(target * 1800) - begin, turns, 1e-4);
    EXPECT_NEAR(rig.get(kValue.position_actual), target * 1800, 400);
  }
}

TEST(SercosPositioning, TheOverrideScalesTheSpeedInMotion) {
  SercosRig rig(0x001B);
  rig.write(kSercosValue.positioning_velocity, 3'000'000U);
  rig.enable();
  rig.send(kSercosValue.target_position, 20 * kTurn);
  for (const std::uint16_t override : {std::uint16_t{4'000}, std::uint16_t{0}, std::uint16_t{12'000}}) {
    rig.send(kSercosValue.feed_rate_override, override);
    rig.cycles(1600);
    EXPECT_NEAR(rig.drive.velocity_rad_s(), kVelocity * override / 1e4, 0.02 * kVelocity) << override;
  }
  rig.cycles(40'000);
  EXPECT_NEAR(rig.drive.position_rad(), 20 * kTurnRad, 1e-3);
}

}  // namespace
}  // namespace driveline::slaves::msd::positioning_test
