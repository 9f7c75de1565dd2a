#include "driveline/motion/axis/axis.hpp"

#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>

#include "driveline/bytes/endian.hpp"
#include "driveline/motion/axis/startup_sdos.hpp"
#include "support/bytes.hpp"

namespace driveline::motion {
namespace {

using bytes_test::hex;
using cia402::Goal;
using cia402::Mode;
using snapshot::AxisState;
using std::chrono::microseconds;
using std::chrono::nanoseconds;

/// 1000 increments per rad, 1000 per mille are 4 Nm, to keep the arithmetic simple.
AxisConfig config(Mode mode = Mode::kCyclicPosition) {
  AxisConfig c;
  c.mode = mode;
  c.increments_per_unit = 1000.0;
  c.rated_torque = 4.0;
  c.inertia = 0.5;
  c.position_gain_1_s = 10.0;
  c.velocity_gain = 0.25;
  return c;
}

/// Inputs: status word, mode, position, velocity, following error, torque, error code. An axis 5 bytes into the image.
constexpr std::size_t kOffset = 5;
std::vector<std::byte> inputs(std::string_view text) {
  auto bytes = hex(text);
  bytes.insert(bytes.begin(), kOffset, std::byte{0xEE});
  return bytes;
}
constexpr std::string_view kEnabledInputs = "3702 08 E8030000 D0070000 F6FFFFFF 7D00 1186";

struct Bench {
  explicit Bench(const AxisConfig& c) : axis(c, ImagePlace{kOffset, kOffset}, axis_pdo_configuration()) {}
  Bench(const AxisConfig& c, std::string_view in) : Bench(c) { read(in); }
  Axis axis;
  std::vector<std::byte> outputs = std::vector<std::byte>(kOffset + 19, std::byte{0xEE});

  void read(std::string_view in) { axis.read_inputs(inputs(in), true); }
  void write(Goal goal, const trajectory::AxisSetpoint& setpoint, bool reset = false) {
    axis.write_outputs(outputs, goal, reset, setpoint);
  }
  [[nodiscard]] std::vector<std::byte> written() const { return {outputs.begin() + kOffset, outputs.end()}; }
};

TEST(AxisInputs, AreDecodedAndScaled) {
  Bench bench(config(), kEnabledInputs);
  const auto& in = bench.axis.inputs();
  EXPECT_EQ(in.status_word, 0x0237);
  EXPECT_EQ(in.state, AxisState::kOperationEnabled);
  EXPECT_EQ(in.mode, 8);
  EXPECT_DOUBLE_EQ(in.position, 1.0);
  EXPECT_DOUBLE_EQ(in.velocity, 2.0);
  EXPECT_DOUBLE_EQ(in.drive_following_error, -0.01);
  EXPECT_DOUBLE_EQ(in.torque, 0.5) << "125 per mille of 4 Nm";
  EXPECT_EQ(in.error_code, 0x8611);
  EXPECT_TRUE(bench.axis.enabled());
  EXPECT_FALSE(bench.axis.fault());
}

TEST(AxisInputs, OfAnInvalidCycleKeepTheValuesButNotTheState) {
  Bench bench(config(), kEnabledInputs);
  bench.axis.read_inputs(inputs("0000 00 00000000 00000000 00000000 0000 0000"), false);
  EXPECT_EQ(bench.axis.inputs().state, AxisState::kUnavailable);
  EXPECT_DOUBLE_EQ(bench.axis.inputs().position, 1.0);
  EXPECT_EQ(bench.axis.inputs().status_word, 0x0237);
  EXPECT_FALSE(bench.axis.enabled());
}

TEST(AxisInputs, InAnotherModeThanWantedAreNotEnabled) {
  Bench bench(config(Mode::kCyclicVelocity), kEnabledInputs);
  EXPECT_FALSE(bench.axis.enabled());
}

TEST(AxisInputs, WithoutTheModeTheStateAloneTellsThatAnAxisIsEnabled) {
  const PdoConfiguration pdos{{}, {{0x1A00, {{0x6041, 0, 16}, {0x6064, 0, 32}}}}};
  Axis axis(config(Mode::kCyclicVelocity), ImagePlace{0, 0}, pdos);
  axis.read_inputs(hex("3702 E8030000"), true);
  EXPECT_TRUE(axis.enabled());
  axis.read_inputs(hex("3302 E8030000"), true);
  EXPECT_FALSE(axis.enabled());
}

TEST(AxisInputs, TellFaults) {
  Bench bench(config(), "1802 08 00000000 00000000 00000000 0000 0000");
  EXPECT_TRUE(bench.axis.fault());
  bench.read("1F02 08 00000000 00000000 00000000 0000 0000");
  EXPECT_TRUE(bench.axis.fault());
}

TEST(AxisOutputs, FrictionAndWeightArePartOfTheTorque) {
  auto c = config();
  c.feed_forward = {.viscous_friction = 0.1, .coulomb_friction = 0.2, .coulomb_velocity = 0.5, .gravity = -1.0};
  for (const auto mode : {Mode::kCyclicPosition, Mode::kCyclicVelocity}) {
    c.mode = mode;
    Bench bench(c, kEnabledInputs);
    bench.write(Goal::kEnabled, {2.0, 3.0, 4.0});
    // 0.5 * 4 + 0.1 * 3 + 0.2 - 1.0 = 1.5 of 4 Nm: 375 per mille.
    const auto written = bench.written();
    EXPECT_EQ(std::vector(written.end() - 2, written.end()), hex("7701")) << to_text(mode);
    bench.write(Goal::kEnabled, {2.0, 3.0, 4.0, 1.0});
    const auto of_the_source = bench.written();
    EXPECT_EQ(std::vector(of_the_source.end() - 2, of_the_source.end()), hex("FA00")) << "a source knows better";
  }
}

TEST(AxisOutputs, TorqueOffsetWaitsForTheDriveToBeThere) {
  auto c = config();
  c.offset_delay_cycles = 1.5;
  Bench bench(c);
  const auto offset = [&bench] {
    const auto written = bench.written();
    return std::to_integer<int>(*(written.end() - 2)) + 256 * std::to_integer<int>(written.back());
  };
  bench.read("3302 08 E8030000 00000000 00000000 0000 0000");
  for (int cycle = 0; cycle < 3; ++cycle) bench.write(Goal::kEnabled, {1.0, 0.0, 0.0});
  bench.read(kEnabledInputs);
  std::vector<int> offsets;
  for (int cycle = 0; cycle < 4; ++cycle) {
    bench.write(Goal::kEnabled, {1.0, 0.0, 1.6});
    offsets.push_back(offset());
  }
  EXPECT_THAT(offsets, testing::ElementsAre(0, 100, 200, 200)) << "0.5 * 1.6 of 4 Nm are 200 per mille";
}

TEST(AxisOutputs, AWeightIsHeldFromTheInstantOfEnablingOn) {
  auto c = config();
  c.feed_forward = {.viscous_friction = 0.1, .coulomb_friction = 0.2, .gravity = -1.0};
  for (const auto mode : {Mode::kCyclicPosition, Mode::kCyclicVelocity, Mode::kCyclicTorque}) {
    c.mode = mode;
    Bench bench(c, "3302 08 E8030000 00000000 00000000 0000 0000");
    bench.write(Goal::kEnabled, {2.0, 3.0, 4.0});
    const auto written = bench.written();
    // -250 per mille, as offset or target.
    EXPECT_EQ(std::vector(written.end() - 4, written.end()),
              hex(mode == Mode::kCyclicTorque ? "06FF 0000" : "0000 06FF"));
  }
}

/// A drive that gets the weight as a torque offset also gets it while it changes its mode.
TEST(AxisOutputs, AWeightStaysInTheTorqueOffsetWhileTheModeChanges) {
  for (const auto mode : {Mode::kCyclicPosition, Mode::kCyclicVelocity, Mode::kCyclicTorque}) {
    for (const auto to : {Mode::kCyclicPosition, Mode::kCyclicVelocity, Mode::kCyclicTorque}) {
      auto c = config(mode);
      c.feed_forward.gravity = -1.0;
      Bench bench(c);
      auto shown = inputs(kEnabledInputs);
      shown[kOffset + 2] = static_cast<std::byte>(mode);
      bench.axis.read_inputs(shown, true);
      bench.write(Goal::kEnabled, {1.0, 0.0, 0.0});
      ASSERT_TRUE(bench.axis.set_mode(to));
      bench.axis.read_inputs(shown, true);
      bench.write(Goal::kEnabled, {1.0, 0.0, 0.0});
      const auto written = bench.written();
      // -250 per mille. Nothing says that a drive which begins in CST uses offsets elsewhere.
      EXPECT_EQ(std::vector(written.end() - 2, written.end()), hex(mode == Mode::kCyclicTorque ? "0000" : "06FF"))
          << to_text(mode) << " to " << to_text(to);
    }
  }
}

TEST(AxisOutputs, InCspAreTargetAndFeedForward) {
  Bench bench(config(), kEnabledInputs);
  bench.write(Goal::kEnabled, {2.0, 3.0, 4.0});
  // 000Fh, mode 8, 2000, target velocity 0, offset 3000, target torque 0, offset 0.5 * 4 / 4 Nm = 500 per mille.
  EXPECT_EQ(bench.written(), hex("0F00 08 D0070000 00000000 B80B0000 0000 F401"));
  for (std::size_t i = 0; i < kOffset; ++i) EXPECT_EQ(bench.outputs[i], std::byte{0xEE}) << "not its own bytes";
}

TEST(AxisOutputs, InCsvCloseThePositionLoop) {
  Bench bench(config(Mode::kCyclicVelocity), "3702 09 E8030000 D0070000 00000000 0000 0000");
  bench.write(Goal::kEnabled, {1.5, 3.0, 4.0});
  // 3 + 10 * (1.5 - 1.0) = 8 rad/s; torque offset 500.
  EXPECT_EQ(bench.written(), hex("0F00 09 DC050000 401F0000 00000000 0000 F401"));
}

TEST(AxisOutputs, InCstCloseBothLoops) {
  Bench bench(config(Mode::kCyclicTorque), "3702 0A E8030000 D0070000 00000000 0000 0000");
  bench.write(Goal::kEnabled, {1.5, 3.0, 4.0});
  // Velocity wanted 8, is 2: 0.25 * 6 + 0.5 * 4 = 3.5 Nm = 875 per mille.
  EXPECT_EQ(bench.written(), hex("0F00 0A DC050000 401F0000 00000000 6B03 0000"));
}

TEST(AxisOutputs, FollowTheActualPositionWhileNotEnabled) {
  for (const auto mode : {Mode::kCyclicPosition, Mode::kCyclicVelocity, Mode::kCyclicTorque}) {
    for (const std::string_view status : {"5002", "3102", "3302", "1702", "1802"}) {
      Bench bench(config(mode), std::string(status) + "08 E8030000 D0070000 00000000 0000 0000");
      bench.write(Goal::kEnabled, {50.0, 3.0, 4.0});
      const auto written = bench.written();
      EXPECT_EQ(std::vector(written.begin() + 3, written.end()), hex("E8030000 00000000 00000000 0000 0000")) << status;
    }
  }
}

AxisConfig coasting() {
  auto settings = config();
  settings.limits = {50.0, 1000.0};
  settings.increments_per_unit = 1e6;
  return settings;
}

/// The drive may follow as soon as it has received the command to enable, before it confirms: the position of a
/// coasting axis is corrected no faster than the axis may accelerate.
TEST(AxisOutputs, OfAnAxisThatCoastsHaveNoStepOnceItIsToldToBeOn) {
  const auto settings = coasting();
  Bench bench(settings);
  const double period_s = std::chrono::duration<double>(settings.period).count();
  constexpr double kVelocity = 10.0;
  const double step = kVelocity * period_s;
  const double most = 0.5 * settings.limits.max_acceleration * period_s * period_s * (1.0 + 1e-9);
  constexpr double kSlower = 9.9;
  constexpr int kCycles = 400;
  bench.read("3302 08 E8030000 D0070000 F6FFFFFF 7D00 1186");  // Switched on
  bench.axis.hold_at(1.0, kVelocity);
  bench.write(Goal::kDisabled, {});
  bench.axis.hold_at(1.2, kVelocity);
  const double before = bench.axis.held().position;
  EXPECT_GT(before, 1.2) << "corrected at once: it is not told to be on";
  bench.write(Goal::kEnabled, {});
  ASSERT_TRUE(bench.axis.commanded_on());
  double last = before;
  for (int cycle = 0; cycle < kCycles; ++cycle) {
    // Further back than predicted, by another hundredth of a period's motion in each cycle, up to a fifth.
    const double behind = std::min(0.01 * cycle, 0.2) * step;
    bench.axis.hold_at(1.2 + (cycle + 1) * step - behind, kVelocity);
    const double now = bench.axis.held().position;
    EXPECT_NEAR(now - last, step, most) << cycle;
    last = now;
  }
  EXPECT_NEAR(last, before + (kCycles - 0.2) * step, 1e-9) << "it gets there";
  bench.axis.hold_at(1.2 + (kCycles + 0.8) * step, kSlower);
  EXPECT_NEAR(bench.axis.held().position - last, step, most) << "slower at once";
  bench.axis.hold_at(5.0);
  EXPECT_DOUBLE_EQ(bench.axis.held().position, 5.0) << "a new zero is another place";
}

/// During missed periods the axis has stopped: it is not at the position predicted from its velocity.
TEST(AxisOutputs, OfAnAxisThatHasCoastedHaveNoStepWhenItStands) {
  const auto settings = coasting();
  Bench bench(settings);
  const double period_s = std::chrono::duration<double>(settings.period).count();
  const double most = settings.limits.max_acceleration * period_s * period_s;
  bench.read("3302 08 E8030000 D0070000 F6FFFFFF 7D00 1186");  // Switched on
  bench.axis.hold_at(1.0, 0.2);
  bench.write(Goal::kEnabled, {});
  ASSERT_TRUE(bench.axis.commanded_on());
  double last = bench.axis.held().position;
  double step = 0.2 * period_s;
  constexpr double kRest = 1.0 - 2e-4;
  for (int cycle = 0; cycle < 200; ++cycle) {
    bench.axis.hold_at(kRest);
    bench.write(Goal::kEnabled, {});
    const double now = bench.axis.held().position;
    EXPECT_NEAR(now - last, step, most) << cycle;
    step = now - last;
    last = now;
  }
  EXPECT_DOUBLE_EQ(last, kRest) << "it gets there";
}

TEST(AxisOutputs, SaturateAndSurviveNan) {
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
  Bench bench(config(), kEnabledInputs);
  bench.write(Goal::kEnabled, {1e12, -1e12, 1e12});
  EXPECT_EQ(bench.written(), hex("0F00 08 FFFFFF7F 00000000 00000080 0000 FF7F"));
  bench.write(Goal::kEnabled, {-kInfinity, kInfinity, -kInfinity});
  EXPECT_EQ(bench.written(), hex("0F00 08 00000080 00000000 FFFFFF7F 0000 0080"));
  bench.write(Goal::kEnabled, {kNan, kNan, kNan});
  EXPECT_EQ(bench.written(), hex("0F00 08 00000000 00000000 00000000 0000 0000"));
}

TEST(AxisOutputs, RoundToTheNearestIncrement) {
  Bench bench(config(), kEnabledInputs);
  bench.write(Goal::kEnabled, {0.0016, -0.0016, 0.0});
  EXPECT_EQ(bench.written(), hex("0F00 08 02000000 00000000 FEFFFFFF 0000 0000"));
}

TEST(AxisOutputs, ResetFaultsOnlyOnRequestAndOnlyFaults) {
  Bench bench(config(), "1802 08 00000000 00000000 00000000 0000 0000");
  bench.write(Goal::kEnabled, {});
  EXPECT_EQ(bench.written()[0], std::byte{0x00});
  bench.write(Goal::kEnabled, {}, true);
  EXPECT_EQ(bench.written()[0], std::byte{0x80});
  bench.read(kEnabledInputs);
  bench.write(Goal::kEnabled, {}, true);
  EXPECT_EQ(bench.written()[0], std::byte{0x0F});
}

TEST(AxisWithoutObjects, ReadsZeroAndWritesNothing) {
  PdoConfiguration pdos;
  pdos.outputs = {{0x1600, {{0x6040, 0, 16}}}};
  pdos.inputs = {{0x1A00, {{0x6041, 0, 16}}}};
  Axis axis(config(), ImagePlace{0, 0}, pdos);
  axis.read_inputs(hex("3702"), true);
  EXPECT_EQ(axis.inputs().state, AxisState::kOperationEnabled);
  EXPECT_EQ(axis.inputs().position, 0.0);
  EXPECT_EQ(axis.inputs().error_code, 0);
  std::vector<std::byte> outputs(2, std::byte{0xEE});
  axis.write_outputs(outputs, Goal::kEnabled, false, {1.0, 1.0, 1.0});
  EXPECT_EQ(outputs, hex("0F00"));
}

TEST(AxisWithoutObjects, IgnoresThoseOfAnotherWidthOrBesideAByteBorder) {
  PdoConfiguration pdos;
  pdos.inputs = {{0x1A00, {{0x6064, 0, 16}, {0x2000, 1, 4}, {0x6041, 0, 16}, {0x2000, 2, 4}}}};
  Axis axis(config(), ImagePlace{0, 0}, pdos);
  axis.read_inputs(hex("FFFFFFFFFF"), true);
  EXPECT_EQ(axis.inputs().position, 0.0);
  EXPECT_EQ(axis.inputs().status_word, 0);
}

TEST(AxisSample, CarriesTargetsAndInputs) {
  Bench bench(config(), kEnabledInputs);
  bench.write(Goal::kEnabled, {2.0, 3.0, 4.0});
  snapshot::AxisSample sample;
  bench.axis.fill(sample);
  EXPECT_EQ(sample.control_word, 0x000F);
  EXPECT_EQ(sample.status_word, 0x0237);
  EXPECT_EQ(sample.state, AxisState::kOperationEnabled);
  EXPECT_EQ(sample.mode, 8);
  EXPECT_DOUBLE_EQ(sample.target_position, 2.0);
  EXPECT_DOUBLE_EQ(sample.actual_position, 1.0);
  EXPECT_DOUBLE_EQ(sample.target_velocity, 3.0);
  EXPECT_DOUBLE_EQ(sample.actual_velocity, 2.0);
  EXPECT_DOUBLE_EQ(sample.target_torque, 2.0);
  EXPECT_DOUBLE_EQ(sample.actual_torque, 0.5);
  EXPECT_DOUBLE_EQ(sample.following_error, 1.0);
  EXPECT_DOUBLE_EQ(sample.drive_following_error, -0.01);
}

TEST(AxisSample, HasTheDemandOfTheDriveAndItsInputsWhereTheyAreMapped) {
  auto reversed = config();
  reversed.reversed = true;
  const PdoConfiguration pdos{
      {{0x1600, {{0x6040, 0, 16}, {0x607A, 0, 32}}}},
      {{0x1A00, {{0x6041, 0, 16}, {0x6064, 0, 32}, {0x6062, 0, 32}, {0x606B, 0, 32}, {0x6074, 0, 16}}},
       {0x1A01, {{0x60FD, 0, 32}, {0x603F, 0, 16}}}}};
  Axis axis(reversed, ImagePlace{0, 0}, pdos);
  axis.read_inputs(hex("3702 FFFFFF7F 01000080 D0070000 7D00 0100FF80 1186"), true);
  snapshot::AxisSample sample;
  axis.fill(sample);
  EXPECT_DOUBLE_EQ(sample.demand_position, sample.actual_position - 0.002) << "across the end of the 32 bits";
  EXPECT_DOUBLE_EQ(sample.demand_velocity, -2.0);
  EXPECT_DOUBLE_EQ(sample.demand_torque, -0.5);
  EXPECT_EQ(sample.digital_inputs, 0x80FF0001);
  EXPECT_EQ(sample.error_code, 0x8611);

  Bench bench(config(), kEnabledInputs);
  snapshot::AxisSample none;
  bench.axis.fill(none);
  EXPECT_TRUE(std::isnan(none.demand_position));
  EXPECT_TRUE(std::isnan(none.demand_velocity));
  EXPECT_TRUE(std::isnan(none.demand_torque));
  EXPECT_EQ(none.digital_inputs, snapshot::kNoDigitalInputs);
}

TEST(AxisRange, IsWrappedAsTheDriveCounts) {
  for (const int direction : {1, -1}) {
    auto c = config();
    c.range_min = -500;
    c.range_max = 499;
    Bench bench(c);
    // Three rounds in steps of a fifth of the range; the target is a step ahead.
    for (int step = 0; step <= 15; ++step) {
      const auto place = [&](int at) { return ((200 * direction * at + 3500) % 1000 + 1000) % 1000 - 500; };
      auto image = inputs("3702 08 00000000 00000000 00000000 0000 0000");
      const auto bytes = bytes::to_le_bytes(static_cast<std::int32_t>(place(step)));
      std::copy(bytes.begin(), bytes.end(), image.begin() + kOffset + 3);
      bench.axis.read_inputs(image, true);
      EXPECT_NEAR(bench.axis.inputs().position, 0.2 * direction * step, 1e-12);
      bench.write(Goal::kEnabled, {0.2 * direction * (step + 1), 0.0, 0.0});
      const auto target = bytes::to_le_bytes(static_cast<std::int32_t>(place(step + 1)));
      EXPECT_TRUE(std::equal(target.begin(), target.end(), bench.outputs.begin() + kOffset + 3)) << step;
    }
  }
}

/// Requests to the drive are bits of the control word (CiA 402-2), of an enabled axis only.
TEST(AxisRequests, AreBitsOfTheControlWordOfAnEnabledAxis) {
  using Request = void (*)(DriveLink&);
  struct Row {
    Request request;
    const char* control_word;
  };
  const Row rows[] = {
      {[](DriveLink& drive) { drive.begin_homing(); }, "1F00"},
      {[](DriveLink& drive) { drive.begin_positioning(DriveLink::TargetChange::kAtOnce); }, "2F00"},
      {[](DriveLink& drive) { drive.begin_velocity(); }, "0F00"},
      {[](DriveLink& drive) { drive.begin_velocity_on_ramp(2.5); }, "7F00"},
      {[](DriveLink& drive) { drive.halt(); }, "0F01"},
      {[](DriveLink& drive) {
         drive.halt();
         drive.end_request();
       },
       "0F00"},
  };
  for (const auto& [request, control_word] : rows) {
    Bench bench(config(Mode::kProfilePosition));
    EXPECT_TRUE(bench.axis.complete());
    request(bench.axis.drive());
    bench.read("3702 01 E8030000 00000000 00000000 0000 0000");
    bench.write(Goal::kEnabled, {2.0, 3.0, 4.0});
    // 60FFh is the target of another mode, and remains.
    EXPECT_EQ(bench.written(), hex(std::string(control_word) + " 01 D0070000 EEEEEEEE 00000000 0000 0000"));
    bench.write(Goal::kQuickStop, {2.0, 3.0, 4.0});
    EXPECT_EQ(bench.written()[0], std::byte{0x02});
    EXPECT_EQ(bench.written()[1], std::byte{0x00});
    bench.read("3302 01 E8030000 00000000 00000000 0000 0000");
    bench.write(Goal::kEnabled, {2.0, 3.0, 4.0});
    EXPECT_EQ(bench.written()[0], std::byte{0x0F});
    EXPECT_EQ(bench.written()[1], std::byte{0x00});
  }
}

/// Following errors of an axis at standstill at 1 rad while the setpoints 2, 3, 4, ... are sent.
std::vector<double> errors(const AxisConfig& c, std::string_view status_and_mode, std::size_t cycles) {
  Bench bench(c);
  std::vector<double> result;
  for (std::size_t i = 0; i < cycles; ++i) {
    bench.read(std::string(status_and_mode) + "E8030000 00000000 00000000 0000 0000");
    bench.write(Goal::kEnabled, {2.0 + static_cast<double>(i), 0.0, 0.0});
    result.push_back(bench.axis.following_error());
  }
  return result;
}

TEST(AxisFollowingError, InCspIsThatOfTheSetpointFollowed) {
  auto c = config();
  c.setpoint_delay_cycles = 2.0;
  EXPECT_THAT(errors(c, "3702 08", 5), testing::ElementsAre(1.0, 1.0, 1.0, 2.0, 3.0));
  c.setpoint_delay_cycles = 1.25;
  EXPECT_THAT(errors(c, "3702 08", 5), testing::ElementsAre(1.0, 1.0, 1.75, 2.75, 3.75));
  c.setpoint_delay_cycles.reset();
  EXPECT_THAT(errors(c, "3702 08", 6), testing::ElementsAre(1.0, 1.0, 1.0, 1.0, 2.0, 3.0)) << "3 cycles";
}

TEST(AxisFollowingError, WhereTheMasterClosesTheLoopIsThatOfTheLoop) {
  EXPECT_THAT(errors(config(Mode::kCyclicVelocity), "3702 09", 3), testing::ElementsAre(1.0, 2.0, 3.0));
  EXPECT_THAT(errors(config(Mode::kCyclicTorque), "3702 0A", 3), testing::ElementsAre(1.0, 2.0, 3.0));
}

TEST(AxisFollowingError, OfAnAxisThatFollowsNothingIsZero) {
  EXPECT_THAT(errors(config(Mode::kCyclicVelocity), "3302 09", 3), testing::ElementsAre(0.0, 0.0, 0.0));
}

TEST(AxisFollowingError, WaitsForANewActualPosition) {
  Bench bench(config(Mode::kCyclicVelocity));
  const auto image = inputs("3702 09 E8030000 00000000 00000000 0000 0000");
  bench.axis.read_inputs(image, true);
  bench.write(Goal::kEnabled, {2.0, 0.0, 0.0});
  EXPECT_DOUBLE_EQ(bench.axis.following_error(), 1.0);
  bench.axis.read_inputs(image, true, false);
  bench.write(Goal::kEnabled, {5.0, 0.0, 0.0});
  EXPECT_DOUBLE_EQ(bench.axis.following_error(), 1.0) << "its group was not due";
  bench.write(Goal::kEnabled, {6.0, 0.0, 0.0});
  EXPECT_DOUBLE_EQ(bench.axis.following_error(), 1.0) << "its frame was lost";
  bench.axis.read_inputs(image, true);
  bench.write(Goal::kEnabled, {7.0, 0.0, 0.0});
  EXPECT_DOUBLE_EQ(bench.axis.following_error(), 6.0);
}

TEST(AxisFollowingError, OfADriveThatReportsNoneIsStillKnown) {
  const PdoConfiguration pdos{{{0x1600, {{0x6040, 0, 16}, {0x60FF, 0, 32}}}},
                              {{0x1A00, {{0x6041, 0, 16}, {0x6064, 0, 32}}}}};
  Axis axis(config(Mode::kCyclicVelocity), ImagePlace{0, 0}, pdos);
  axis.read_inputs(hex("3702 E8030000"), true);
  std::vector<std::byte> outputs(6);
  axis.write_outputs(outputs, Goal::kEnabled, false, {1.5, 0.0, 0.0});
  snapshot::AxisSample sample;
  axis.fill(sample);
  EXPECT_DOUBLE_EQ(sample.following_error, 0.5);
  EXPECT_TRUE(std::isnan(sample.drive_following_error));
}

TEST(SetpointDelay, IsTransportInterpolationAndTheWaitForSync0) {
  const auto cycles = [](std::uint32_t divider, unsigned interpolation, std::optional<nanoseconds> to_sync0) {
    return setpoint_delay_cycles({microseconds{1000}, divider, interpolation, to_sync0});
  };
  EXPECT_DOUBLE_EQ(cycles(1, 1, std::nullopt), 2.0);
  EXPECT_DOUBLE_EQ(cycles(1, motion::kSplinePeriods, std::nullopt), 3.0);
  EXPECT_DOUBLE_EQ(cycles(4, motion::kSplinePeriods, std::nullopt), 9.0);
  EXPECT_DOUBLE_EQ(cycles(1, motion::kSplinePeriods, microseconds{500}), 3.5625) << "and a control step of 62.5 us";
}

TEST(PdoConfiguration, OfAnAxisKeepsTheLimitsOfTheDrive) {
  const auto& pdos = axis_pdo_configuration();
  EXPECT_EQ(pdos.output_bytes(), 19U);
  EXPECT_EQ(pdos.input_bytes(), 19U);
  for (const auto* direction : {&pdos.outputs, &pdos.inputs}) {
    EXPECT_LE(direction->size(), 4U);
    for (const auto& pdo : *direction) EXPECT_LE(pdo.bits(), 64U) << "8 bytes a PDO (MSD manual 8.3.4)";
  }
}

TEST(PdoConfiguration, CodesEntriesAsTheStandardDoes) {
  // As read from another maker's drive, object 1600h:01 and 1602h:02: 6040h, 16 bits; 607Ah, 32 bits.
  EXPECT_EQ((MappedObject{0x6040, 0, 16}.raw()), 0x60400010U);
  EXPECT_EQ((MappedObject{0x607A, 0, 32}.raw()), 0x607A0020U);
}

TEST(PdoConfiguration, CountsALastByteThatIsNotFull) {
  PdoConfiguration pdos;
  EXPECT_EQ(pdos.output_bytes(), 0U);
  pdos.outputs = {{0x1600, {{0x2000, 1, 1}}}, {0x1601, {{0x2000, 2, 8}}}};
  EXPECT_EQ(pdos.output_bytes(), 2U);
}

TEST(InterpolationPeriod, HoldsTheUsualCycles) {
  struct Row {
    nanoseconds period;
    int value, exponent;
  };
  for (const auto& row :
       {Row{microseconds{125}, 125, -6}, Row{microseconds{250}, 25, -5}, Row{microseconds{500}, 5, -4},
        Row{microseconds{1000}, 1, -3}, Row{microseconds{2000}, 2, -3}, Row{microseconds{4000}, 4, -3},
        Row{microseconds{10'000}, 1, -2}, Row{nanoseconds{62'500}, 0, 0}, Row{microseconds{255}, 255, -6}}) {
    const auto period = to_interpolation_period(row.period);
    if (row.value == 0) {
      EXPECT_FALSE(period) << row.period.count();
      continue;
    }
    ASSERT_TRUE(period) << row.period.count();
    EXPECT_EQ(period->value, row.value);
    EXPECT_EQ(period->exponent, row.exponent);
  }
}

TEST(InterpolationPeriod, DoesNotRoundWhatItCannotHold) {
  for (const std::int64_t ns : {0LL, -125'000LL, 256'000LL, 312'500LL, 125'001LL}) {
    EXPECT_FALSE(to_interpolation_period(nanoseconds{ns})) << ns;
  }
}

/// "index:sub = bytes" of all, for comparison.
std::vector<std::vector<std::byte>> flat(const std::vector<StartupSdo>& sdos) {
  std::vector<std::vector<std::byte>> result;
  for (const auto& sdo : sdos) {
    std::vector<std::byte> one{static_cast<std::byte>(sdo.index >> 8), static_cast<std::byte>(sdo.index & 0xFF),
                               static_cast<std::byte>(sdo.subindex)};
    one.insert(one.end(), sdo.data.begin(), sdo.data.end());
    result.push_back(one);
  }
  return result;
}

TEST(ModeSdo, IsTheModeOfOperation) {
  EXPECT_THAT(flat({mode_sdo(Mode::kCyclicTorque)}), testing::ElementsAre(hex("6060 00 0A")));
}

TEST(Cia402Startup, TellsTheTimeFromOneSetpointToTheNext) {
  EXPECT_THAT(flat(motion::cia402_startup_sdos(microseconds{125})),  // 125 * 10^-6 s
              testing::ElementsAre(hex("60C2 01 7D"), hex("60C2 02 FA")));
  EXPECT_THROW(static_cast<void>(motion::cia402_startup_sdos(nanoseconds{312'500})), std::invalid_argument);
}

}  // namespace
}  // namespace driveline::motion
