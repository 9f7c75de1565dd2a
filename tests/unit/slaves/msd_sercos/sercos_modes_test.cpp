// Choice of the operation mode, changes in motion, and the start at the setpoint of the master.
#include "driveline/slaves/msd/core/sercos/sercos_modes.hpp"

#include "sercos_rig.hpp"

namespace driveline::slaves::msd::modes_test {
namespace {

using Kind = SercosModeKind;

constexpr std::uint16_t kFollow = 0xE000;
constexpr std::uint16_t kSecond = 0x0100;  ///< chooses S-0-0033
constexpr std::uint16_t kNotSetUp = 0x0200;

/// Table 6.2 of the manual has eleven modes, and no other word is one.
TEST(SercosMode, ElevenWordsAreModes) {
  int modes = 0;
  for (unsigned word = 0; word <= 0xFFFF; ++word) {
    const auto mode = SercosMode::of(static_cast<std::uint16_t>(word));
    if (mode.kind == Kind::kNone) continue;
    ++modes;
    EXPECT_EQ(mode.service_channel, (word & 0x4000U) != 0);
  }
  EXPECT_EQ(modes, 2 * 11);
}

struct Word {
  std::uint16_t word;
  Kind kind;
  bool feed_forward;
  int encoder;
};

TEST(SercosMode, AWordSaysWhatTheModeDoes) {
  for (const auto& [word, kind, feed_forward, encoder] : std::vector<Word>{
           {0x0000, Kind::kNone, false, 0},
           {0x0001, Kind::kTorque, false, 0},
           {0x0002, Kind::kSpeedRamps, false, 0},
           {0x0006, Kind::kSpeed, false, 0},
           {0x0003, Kind::kPosition, false, 1},
           {0x0004, Kind::kPosition, false, 2},
           {0x000B, Kind::kPosition, true, 1},
           {0x000C, Kind::kPosition, true, 2},
           {0x0013, Kind::kInterpolation, false, 1},
           {0x0014, Kind::kInterpolation, false, 2},
           {0x001B, Kind::kInterpolation, true, 1},
           {0x401C, Kind::kInterpolation, true, 2},
       }) {
    const auto mode = SercosMode::of(word);
    EXPECT_EQ(mode.kind, kind) << std::hex << word;
    EXPECT_EQ(mode.feed_forward, feed_forward) << std::hex << word;
    EXPECT_EQ(mode.encoder, encoder) << std::hex << word;
  }
}

TEST(SercosMode, OtherWordsAreRefused) {
  SercosRig rig(0x0006);
  for (std::uint16_t number = 32; number <= 35; ++number) {
    const EntryRow* row = sercos_table().find(static_cast<std::uint16_t>(0x2000 + 10000 + number), 0);
    ASSERT_NE(row, nullptr);
    for (const std::uint64_t word : {0x0000U, 0x001BU, 0x4006U}) EXPECT_TRUE(rig.drive.accept(*row, word)) << word;
    for (const std::uint64_t word : {0x0005U, 0x0007U, 0x8006U}) EXPECT_FALSE(rig.drive.accept(*row, word)) << word;
  }
}

TEST(SercosMode, ChangesInMotionWithoutALeap) {
  struct Change {
    std::uint16_t from;
    std::uint16_t to;
  };
  for (const auto& [from, to] :
       std::vector<Change>{{0x0006, 0x000B}, {0x0006, 0x0001}, {0x0002, 0x0006}, {0x0006, 0x001B}, {0x0002, 0x000C}}) {
    SCOPED_TRACE(testing::Message() << std::hex << from << " to " << to);
    SercosRig rig(from);
    rig.write(kSercosValue.modes[1], to);
    rig.write(kSercosValue.encoder_channels[1], std::uint16_t{1});
    rig.enable();
    rig.send(kSercosValue.velocity_command, 2'500'000);
    rig.cycles(2400);
    const double speed = rig.drive.velocity_rad_s();
    EXPECT_EQ(rig.status() & 0x0700, 0);
    double ahead = rig.drive.position_rad();
    const auto follow_axis = [&] {  // the master continues the motion in the new mode
      ahead += speed * 125e-6;
      rig.send(kSercosValue.position_command, static_cast<std::int32_t>(std::lrint(ahead / kUnitRad)));
      rig.send(kSercosValue.target_position, static_cast<std::int32_t>(std::lrint(ahead / kUnitRad)));
      rig.cycles(1);
    };
    rig.send(kSercosValue.control_word, static_cast<std::uint16_t>(kFollow | kSecond));
    double last = speed;
    for (int i = 0; i < 80; ++i) {
      follow_axis();
      EXPECT_LT(std::abs(rig.drive.velocity_rad_s() - last), 2.0) << i << ": more than the drive can";
      last = rig.drive.velocity_rad_s();
    }
    EXPECT_EQ(rig.status() & 0x0708, kSecond | 0x0008);
    EXPECT_EQ(rig.drive.fault(), std::nullopt);
  }
}

TEST(SercosMode, OneThatIsNotSetUpIsRefusedInMotion) {
  SercosRig rig(0x0006);
  rig.enable();
  rig.send(kSercosValue.velocity_command, 2'500'000);
  rig.cycles(2400);
  for (const std::uint16_t choice : {std::uint16_t{0x0100}, std::uint16_t{0x0800}}) {
    EXPECT_EQ(rig.get(kSercosValue.interface_status), 0);
    rig.control(static_cast<std::uint16_t>(kFollow | choice), 40);
    EXPECT_EQ(rig.get(kSercosValue.interface_status), kNotSetUp);
    EXPECT_EQ(rig.status() & 0x0700, 0);
    EXPECT_NEAR(rig.drive.velocity_rad_s(), 2'500'000 * kSpeedUnit, 1.0);
    rig.control(kFollow);
    EXPECT_EQ(rig.get(kSercosValue.interface_status), kNotSetUp) << "until S-0-0099";
    rig.write(kSercosValue.reset_class_1, std::uint16_t{3});
    rig.write(kSercosValue.reset_class_1, std::uint16_t{0});
  }
}

TEST(SercosMode, TheFractionOfAPositionCountsWithP379) {
  for (const bool counts : {true, false}) {
    SercosRig rig(0x000B);
    rig.write(kValue.position_format, static_cast<std::uint16_t>(counts ? 1 : 0));
    rig.enable();
    rig.send(kSercosValue.position_command, 100);
    rig.send(kSercosValue.position_fraction, std::uint16_t{49'152});
    rig.cycles(80);
    EXPECT_NEAR(rig.drive.motion().position_demand(), counts ? 100.75 : 100.0, 1e-6);
  }
}

/// P 370 = 2: the master sends speed and acceleration with each position, scaled by P 3054.
TEST(SercosMode, ExternalFeedForwardIsScaled) {
  SercosRig rig(0x000B);
  rig.write(kValue.interpolation_type, std::uint8_t{2});
  rig.write(kValue.total_inertia, 3e-4F);
  rig.write(kSercosValue.feed_forward_gain, 0.5F);
  rig.enable();
  rig.send(kSercosValue.velocity_feed_forward, 1'000'000);
  rig.send(kSercosValue.acceleration_feed_forward, 200'000);
  rig.cycles(1);
  EXPECT_NEAR(rig.drive.external_velocity_rad_s(), 50 * kRpm, 1e-6);
  EXPECT_NEAR(rig.drive.external_torque_nm(), 0.5 * 200.0 * 3e-4, 1e-6);
}

struct Start {
  const char* what;
  std::int32_t away;     ///< position units
  std::uint32_t most;    ///< P 743
  float speed;           ///< P 168[1]
  std::uint16_t option;  ///< P 156
  PowerState state;      ///< in the end
  double moved;          ///< position units
};

TEST(SercosStart, MoveCommandGoesToTheSetpointOfTheMaster) {
  for (const auto& [what, away, most, speed, option, state, moved] : std::vector<Start>{
           {"goes there", 40'000, 50'000, 200'000.0F, 1, PowerState::kOperationEnabled, 40'000},
           {"goes back", -40'000, 50'000, 200'000.0F, 1, PowerState::kOperationEnabled, -40'000},
           {"is there", 0, 50'000, 0.0F, 1, PowerState::kOperationEnabled, 0},
           {"too far", 60'000, 50'000, 200'000.0F, 1, PowerState::kFault, 0},
           {"without speed", 40'000, 50'000, 0.0F, 1, PowerState::kSwitchedOn, 0},
       }) {
    SCOPED_TRACE(what);
    SercosRig rig(0x000B);
    rig.write(kSercosValue.tracking_limit, most);
    rig.write(kSercosValue.enable_option, option);
    rig.write(kSercosValue.jog_speeds[1], speed);
    const auto begin = rig.get(kValue.position_actual);
    rig.send(kSercosValue.position_command, begin + away);
    for (const std::uint16_t word : {std::uint16_t{0}, std::uint16_t{0x4000}, kFollow}) rig.control(word, 4);
    double fastest = 0.0;
    for (const double v : rig.speeds(4000)) fastest = std::max(fastest, std::abs(v));
    EXPECT_EQ(rig.drive.state(), state);
    EXPECT_NEAR(rig.get(kValue.position_actual), begin + moved, 200);
    EXPECT_LT(fastest, 1.2 * speed * kSpeedUnit + 0.05);
    EXPECT_EQ(rig.drive.fault() == Fault::kFollowingError, state == PowerState::kFault);
  }
}

TEST(SercosStart, StatusIsNotInControlWhileTheAxisGoesToTheSetpoint) {
  SercosRig rig(0x000B);
  rig.write(kSercosValue.tracking_limit, 50'000U);
  rig.write(kSercosValue.enable_option, std::uint16_t{1});
  rig.write(kSercosValue.jog_speeds[1], 200'000.0F);
  rig.send(kSercosValue.position_command, rig.get(kValue.position_actual) + 40'000);
  for (const std::uint16_t word : {std::uint16_t{0}, std::uint16_t{0x4000}, kFollow}) rig.control(word, 4);
  rig.cycles(120);
  EXPECT_EQ(rig.status() & 0xE008, 0x8000);
  EXPECT_GT(std::abs(rig.drive.velocity_rad_s()), 0.5 * 200'000 * kSpeedUnit);
  rig.cycles(4000);
  EXPECT_EQ(rig.status() & 0xE008, 0xC008);
}

TEST(SercosStart, WithoutMonitoringOrMoveCommandTheSetpointActsAsItIs) {
  for (const std::uint16_t option : {std::uint16_t{0}, std::uint16_t{1}}) {
    SercosRig rig(0x000B);
    rig.write(kSercosValue.tracking_limit, option == 0 ? 50'000U : 0U);
    rig.write(kSercosValue.enable_option, option);
    rig.send(kSercosValue.position_command, rig.get(kValue.position_actual) + 40'000);
    for (const std::uint16_t word : {std::uint16_t{0}, std::uint16_t{0x4000}, kFollow}) rig.control(word, 4);
    EXPECT_EQ(rig.status() & 0xE008, 0xC008);
    double fastest = 0.0;
    for (const double v : rig.speeds(400)) fastest = std::max(fastest, std::abs(v));
    EXPECT_GT(fastest, 2.0) << "with a jerk";
  }
}

TEST(SercosStart, AModeOfAnotherEncoderThanP522IsAFault) {
  for (const std::uint16_t channel : {std::uint16_t{1}, std::uint16_t{3}}) {
    SercosRig rig(0x000C);
    rig.write(kSercosValue.encoder_channels[1], channel);
    for (const std::uint16_t word : {std::uint16_t{0}, std::uint16_t{0x4000}, kFollow}) rig.control(word, 8);
    if (channel == 1) {
      EXPECT_EQ(rig.drive.state(), PowerState::kOperationEnabled);
    } else {
      EXPECT_EQ(rig.drive.fault(), Fault::kInvalidConfiguration);
      EXPECT_EQ(rig.drive.state(), PowerState::kFault);
    }
  }
}

}  // namespace
}  // namespace driveline::slaves::msd::modes_test
