// Homing mode (MSD manual 12.2.4): every method from three start positions, on a machine with switches.
#include <limits>

#include "drive_rig.hpp"

namespace driveline::slaves::msd {
namespace {

constexpr double kIncrementsPerTurn = kRevolution;

constexpr double kEndless = std::numeric_limits<double>::infinity();
constexpr double kLimit = 4.3;    ///< limit switches beyond this number of revolutions on either side
constexpr double kEdge = 1.3;     ///< home switch of methods 3-6, active from here on outwards
constexpr double kCamLeft = 0.6;  ///< cam of methods 7-14
constexpr double kCamRight = 1.7;
constexpr std::uint16_t kAttained = 0x1000;
constexpr std::uint16_t kError = 0x2000;

int without_index(int method) {
  return method > 16 && method < 31 ? method - 16 : method;
}

MsdParameters machine(int method, double start_revolutions) {
  const int number = without_index(method);
  MsdParameters p;
  p.initial_position_rad = start_revolutions * kTurnRad;
  p.switches = {{Input::kIsd00, -kEndless, -kLimit * kTurnRad}, {Input::kIsd01, kLimit * kTurnRad, kEndless}};
  if (number == 3 || number == 4) {
    p.switches.push_back({Input::kIsd02, kEdge * kTurnRad, kEndless});
  } else if (number == 5 || number == 6) {
    p.switches.push_back({Input::kIsd02, -kEndless, -kEdge * kTurnRad});
  } else {
    p.switches.push_back({Input::kIsd02, kCamLeft * kTurnRad, kCamRight * kTurnRad});
  }
  return p;
}

enum class Contacts : std::uint8_t { kMake, kBreak };

/// The same machine with break contacts.
MsdParameters machine(int method, double start_revolutions, Contacts contacts) {
  MsdParameters p = machine(method, start_revolutions);
  for (auto& s : p.switches) s.normally_closed = contacts == Contacts::kBreak;
  return p;
}

/// A drive on that machine, enabled in homing mode, ISD00 negative limit, ISD01 positive limit, ISD02 home switch.
class HomingRig : public DriveRig {
 public:
  HomingRig(int method, double start_revolutions, std::int32_t offset = 0, Contacts contacts = Contacts::kMake)
      : DriveRig(machine(method, start_revolutions, contacts)), offset_(offset) {
    // P 120: ISD00 to ISD02 inverted.
    EXPECT_EQ(write(0x2078, 0, contacts == Contacts::kBreak ? 0x0E : 0, 4), 0U);
    EXPECT_EQ(write(0x2065, 0, 6, 2), 0U);
    EXPECT_EQ(write(0x2066, 0, 5, 2), 0U);
    EXPECT_EQ(write(0x2067, 0, 10, 2), 0U);
    EXPECT_EQ(write(0x6098, 0, static_cast<std::uint8_t>(method), 1), 0U);
    EXPECT_EQ(write(0x607C, 0, static_cast<std::uint32_t>(offset), 4), 0U);
    EXPECT_EQ(write(0x6099, 1, 2 * 1048576, 4), 0U);
    EXPECT_EQ(write(0x6099, 2, 104858, 4), 0U);
    operate();
    enable(6);
  }
  /// Runs homing to its end; false when it takes longer than a minute.
  bool home() {
    control = 0x1F;
    for (int i = 0; i < 480'000; ++i) {
      cycle();
      if ((status & (kAttained | kError)) != 0 && (status & kReached) != 0) return true;
      if (drive.state() != PowerState::kOperationEnabled) return true;
    }
    return false;
  }
  [[nodiscard]] double revolutions() const { return drive.position_rad() / kTurnRad; }
  /// The home position in revolutions of the motor, from the present position of the drive: zero is the sum of home
  /// position and offset.
  [[nodiscard]] double home_revolutions() const {
    return revolutions() - (double{0} + position + offset_) / kIncrementsPerTurn;
  }

 private:
  std::int32_t offset_;
};

struct Method {
  int number;
  double home;                ///< revolutions; index pulses are at whole ones
  int approach;               ///< direction in which home is passed (CiA 402, pictures of the methods)
  std::array<int, 3> begins;  ///< direction of the first movement from each of starts()
};

constexpr std::array kMethods = {
    Method{1, -4.0, 1, {1, -1, -1}},       Method{2, 4.0, -1, {-1, 1, 1}},
    Method{3, 1.0, -1, {1, -1, -1}},       Method{4, 2.0, 1, {1, -1, -1}},
    Method{5, -1.0, 1, {-1, 1, 1}},        Method{6, -2.0, -1, {-1, 1, 1}},
    Method{7, 0.0, -1, {1, -1, 1}},        Method{8, 1.0, 1, {1, -1, 1}},
    Method{9, 1.0, -1, {1, 1, 1}},         Method{10, 2.0, 1, {1, 1, 1}},
    Method{11, 2.0, 1, {-1, 1, -1}},       Method{12, 1.0, -1, {-1, 1, -1}},
    Method{13, 1.0, 1, {-1, -1, -1}},      Method{14, 0.0, -1, {-1, -1, -1}},
    Method{17, -kLimit, 1, {1, -1, -1}},   Method{18, kLimit, -1, {-1, 1, 1}},
    Method{19, kEdge, -1, {1, -1, -1}},    Method{20, kEdge, 1, {1, -1, -1}},
    Method{21, -kEdge, 1, {-1, 1, 1}},     Method{22, -kEdge, -1, {-1, 1, 1}},
    Method{23, kCamLeft, -1, {1, -1, 1}},  Method{24, kCamLeft, 1, {1, -1, 1}},
    Method{25, kCamRight, -1, {1, 1, 1}},  Method{26, kCamRight, 1, {1, 1, 1}},
    Method{27, kCamRight, 1, {-1, 1, -1}}, Method{28, kCamRight, -1, {-1, 1, -1}},
    Method{29, kCamLeft, 1, {-1, -1, -1}}, Method{30, kCamLeft, -1, {-1, -1, -1}},
};

/// On the switch and on both sides of it, as far as the method has these sides.
std::array<double, 3> starts(int method) {
  switch (without_index(method)) {
    case 1:
      return {-4.4, 0.2, 3.3};
    case 2:
      return {4.4, 0.2, -3.3};
    case 3:
    case 4:
      return {0.4, 1.31, 3.2};
    case 5:
    case 6:
      return {-0.4, -1.31, -3.2};
    default:
      return {-2.2, 1.1, 3.4};
  }
}

class MsdHomingMethods : public testing::TestWithParam<Method> {};

TEST_P(MsdHomingMethods, FindsTheSameHomeFromThreeStarts) {
  for (const double start : starts(GetParam().number)) {
    HomingRig rig(GetParam().number, start, 5000);
    EXPECT_EQ(rig.status & (kAttained | kError), 0);
    ASSERT_TRUE(rig.home()) << "from " << start;
    EXPECT_EQ(rig.status & (kAttained | kError | kReached), kAttained | kReached) << "from " << start;
    // An index pulse is latched exactly, an edge within one control cycle at the slow speed of 0.1 rev/s.
    const double tolerance = GetParam().number <= 14 ? 3e-6 : 3e-5;
    EXPECT_NEAR(rig.home_revolutions(), GetParam().home, tolerance) << "from " << start;
    EXPECT_EQ(rig.drive.state(), PowerState::kOperationEnabled);
    EXPECT_FALSE(rig.drive.fault().has_value());
  }
}

/// Break contacts with P 120 home to the same places as make contacts do, to the increment.
TEST_P(MsdHomingMethods, BreakContactsInvertedByP120AreTheSame) {
  for (const double start : starts(GetParam().number)) {
    HomingRig make(GetParam().number, start, 5000);
    HomingRig breaking(GetParam().number, start, 5000, Contacts::kBreak);
    EXPECT_EQ(breaking.read(0x2079) & 0x0EU, ~make.read(0x2079) & 0x0EU) << "2079h has the levels as they are";
    EXPECT_EQ(breaking.read(0x60FD), make.read(0x60FD)) << "60FDh what they mean";
    ASSERT_TRUE(make.home());
    ASSERT_TRUE(breaking.home());
    EXPECT_EQ(breaking.position, make.position) << "from " << start;
    EXPECT_EQ(breaking.drive.position_rad(), make.drive.position_rad()) << "from " << start;
  }
}

/// The motion of the axis.
struct Way {
  int begins = 0;            ///< direction of the first movement
  int approach = 0;          ///< direction in which it last passed home
  double speed_at_home = 0;  ///< rev/s, at that time
  double fastest = 0;        ///< rev/s, before it stopped
};

Way watch(HomingRig& rig, double home) {
  Way way;
  rig.control = 0x1F;
  double last = rig.revolutions();
  for (int i = 0; i < 480'000 && (rig.status & kAttained) == 0; ++i) {
    rig.cycle();
    const double now = rig.revolutions();
    const double speed = rig.drive.velocity_rad_s() / kTurnRad;
    if (way.begins == 0 && std::abs(speed) > 0.01) way.begins = speed > 0.0 ? 1 : -1;
    if ((last < home && now >= home) || (last > home && now <= home)) {
      way.approach = now > last ? 1 : -1;
      way.speed_at_home = std::abs(speed);
    }
    way.fastest = std::max(way.fastest, std::abs(speed));
    last = now;
  }
  return way;
}

TEST_P(MsdHomingMethods, TakesItsWayAtItsSpeedsToTheIncrement) {
  const Method& method = GetParam();
  constexpr std::int32_t kOffset = -12345;
  constexpr double kFast = 2.0;
  constexpr double kSlow = 0.1;
  const auto places = starts(method.number);
  for (std::size_t i = 0; i < places.size(); ++i) {
    HomingRig rig(method.number, places[i], kOffset);
    const Way way = watch(rig, method.home);
    ASSERT_TRUE(rig.status & kAttained) << "from " << places[i];
    EXPECT_EQ(way.begins, method.begins[i]) << "from " << places[i];
    EXPECT_EQ(way.approach, method.approach) << "from " << places[i];
    EXPECT_NEAR(way.speed_at_home, kSlow, 0.3 * kSlow) << "from " << places[i];
    // If the first edge counts, or a slow leg comes first, there is no fast motion.
    const bool fast = way.fastest > 2.0 * kSlow;
    EXPECT_TRUE(fast || method.begins[i] == method.approach) << "from " << places[i];
    EXPECT_LT(way.fastest, 1.05 * kFast) << "from " << places[i];
    // 6064h is exactly -607Ch at home: an index pulse is latched at its position, an edge in the following control
    // cycle.
    const auto count = static_cast<std::int64_t>(std::floor(rig.revolutions() * kIncrementsPerTurn));
    const std::int64_t home = count - rig.position - kOffset;
    const auto expected = std::llround(method.home * kIncrementsPerTurn);
    if (method.number <= 14) {
      EXPECT_EQ(home, expected) << "from " << places[i];
    } else {
      constexpr std::int64_t kWayOfACycle = 8;  // 0.1 rev/s in 62.5 us, and the speed's ripple
      EXPECT_GE((home - expected) * method.approach, -1) << "from " << places[i];
      EXPECT_LE((home - expected) * method.approach, kWayOfACycle) << "from " << places[i];
    }
  }
}

constexpr double kQuick = 0.5;  ///< 6099h:02 of the halts, rev/s

/// Brakes slowly when halted, so that the edge or pulse is often passed while braking.
class HaltedHoming : public HomingRig {
 public:
  HaltedHoming(int method, double start) : HomingRig(method, start) {
    EXPECT_EQ(write(0x6099, 2, static_cast<std::uint32_t>(kQuick * kIncrementsPerTurn), 4), 0U);
    EXPECT_EQ(write(0x6084, 0, static_cast<std::uint32_t>(2 * kIncrementsPerTurn), 4), 0U);  // 605Dh = 1: this ramp
    control = 0x1F;
  }
  /// The cycle in which the axis last passed `home`, in an undisturbed homing.
  int undisturbed(double home) {
    int passed = 0;
    double last = revolutions();
    for (int i = 0; i < 160'000 && (status & kAttained) == 0; ++i) {
      cycle();
      if ((last < home) != (revolutions() < home)) passed = i;
      last = revolutions();
    }
    EXPECT_TRUE(status & kAttained);
    return passed;
  }
  void halt_at(int moment) {
    cycles(moment);
    control = 0x11F;
    cycles(10'000);  // 1.25 s, to standstill from 6099h:01
    EXPECT_LT(std::abs(drive.velocity_rad_s()), 0.05) << "stands";
    control = 0x1F;
  }
};

TEST_P(MsdHomingMethods, HaltAtAnyMomentDoesNotMoveTheHome) {
  const Method& method = GetParam();
  const double start = starts(method.number)[1];
  const int passed = HaltedHoming(method.number, start).undisturbed(method.home);
  ASSERT_GT(passed, 8);
  // Moments during the whole motion, and close before home, which is then passed while the axis brakes.
  for (const int moment : {passed / 7, passed / 3, passed / 2, 3 * passed / 4, passed - 800, passed - 400, passed - 80,
                           passed - 8, passed + 8}) {
    HaltedHoming rig(method.number, start);
    rig.halt_at(std::max(moment, 1));
    ASSERT_TRUE(rig.home()) << "halted after " << moment << " cycles";
    EXPECT_EQ(rig.status & (kAttained | kError), kAttained) << "halted after " << moment << " cycles";
    const double tolerance = method.number <= 14 ? 3e-6 : 1.5 * kQuick * 62.5e-6;
    EXPECT_NEAR(rig.home_revolutions(), method.home, tolerance) << "halted after " << moment << " cycles";
  }
}

INSTANTIATE_TEST_SUITE_P(Cia402, MsdHomingMethods, testing::ValuesIn(kMethods),
                         [](const auto& instance) { return "Method" + std::to_string(instance.param.number); });

TEST(MsdHoming, IndexPulseInEitherDirection) {
  for (const double start : {-2.3, 0.4, 3.9}) {
    HomingRig negative(33, start);
    ASSERT_TRUE(negative.home());
    EXPECT_NEAR(negative.home_revolutions(), std::floor(start), 3e-6);
    HomingRig positive(34, start);
    ASSERT_TRUE(positive.home());
    EXPECT_NEAR(positive.home_revolutions(), std::ceil(start), 3e-6);
  }
}

TEST(MsdHoming, PresentPositionBecomesHomeWithoutMotion) {
  for (const int method : {35, 37}) {
    for (const double start : {-2.3, 0.4, 3.9}) {
      HomingRig rig(method, start, -700);
      const double before = rig.revolutions();
      ASSERT_TRUE(rig.home());
      EXPECT_NEAR(rig.revolutions(), before, 1e-4);
      EXPECT_NEAR(rig.position, 700, 60) << "zero is home plus offset";
    }
  }
}

TEST(MsdHoming, LaterTargetsReferToTheNewZero) {
  HomingRig rig(8, -2.2, 20'000);
  ASSERT_TRUE(rig.home());
  rig.mode = 1;
  rig.command(0x0F, 4);
  rig.target_position = 0;
  rig.command(0x1F, 16'000);
  EXPECT_TRUE(rig.status & kReached);
  EXPECT_NEAR(rig.revolutions(), 1.0 + 20'000 / kIncrementsPerTurn, 1e-4);
}

TEST(MsdHoming, PolarityTurnsDirectionsAndSwitches) {
  // For the user the machine is mirrored: method 2 moves to the positive limit, which is at negative shaft angles.
  DriveRig rig(machine(2, 0.2));
  rig.set({{0x607E, 0, 0xC0, 1}, {0x2065, 0, 5, 2}, {0x2066, 0, 6, 2}, {0x6098, 0, 18, 1}, {0x607C, 0, 1000, 4}});
  rig.start(6);
  rig.control = 0x1F;
  for (int i = 0; i < 160'000 && (rig.status & kAttained) == 0; ++i) rig.cycle();
  ASSERT_TRUE(rig.status & kAttained);
  const double home = rig.drive.position_rad() / kTurnRad + (rig.position + 1000.0) / kIncrementsPerTurn;
  EXPECT_NEAR(home, -kLimit, 1e-4);
}

TEST(MsdHoming, SpeedsAndAccelerationAreThoseOfTheObjects) {
  HomingRig rig(17, 3.3);
  rig.control = 0x1F;
  double fastest = 0.0;
  double fastest_back = 0.0;
  double steepest = 0.0;
  double last = 0.0;
  for (int i = 0; i < 160'000 && (rig.status & kAttained) == 0; ++i) {
    rig.cycle();
    const double v = rig.drive.velocity_rad_s() / kTurnRad;
    fastest = std::max(fastest, -v);
    fastest_back = std::max(fastest_back, v);
    steepest = std::max(steepest, std::abs(v - last) / 125e-6);
    last = v;
  }
  EXPECT_NEAR(fastest, 2.0, 0.1) << "6099h sub 1";
  EXPECT_NEAR(fastest_back, 0.1, 0.06) << "6099h sub 2";
  EXPECT_NEAR(steepest, 100.0, 60.0) << "609Ah";
}

TEST(MsdHoming, FallingStartBitInterrupts) {
  HomingRig rig(17, 3.3);
  rig.command(0x1F, 4000);
  EXPECT_LT(rig.velocity, -1'000'000);
  EXPECT_EQ(rig.status & (kReached | kAttained | kError), 0) << "in progress";
  rig.command(0x0F, 1600);
  EXPECT_NEAR(rig.velocity, 0, 2000);
  EXPECT_EQ(rig.status & (kReached | kAttained | kError), kReached) << "interrupted";
  rig.control = 0x1F;
  ASSERT_TRUE(rig.home());
  EXPECT_NEAR(rig.home_revolutions(), -kLimit, 3e-5);
}

TEST(MsdHoming, HaltPausesIt) {
  HomingRig rig(17, 3.3);
  rig.command(0x1F, 4000);
  rig.command(0x11F, 8);
  EXPECT_EQ(rig.status & kReached, 0) << "axis is braking";
  rig.cycles(1600);
  EXPECT_NEAR(rig.velocity, 0, 2000);
  EXPECT_EQ(rig.status & (kReached | kAttained | kError), kReached);
  rig.control = 0x1F;
  ASSERT_TRUE(rig.home());
  EXPECT_NEAR(rig.home_revolutions(), -kLimit, 3e-5);
}

TEST(MsdHoming, IndexPulsePassedWhileHaltedCounts) {
  for (const int method : {33, 34}) {
    const double home = method == 33 ? 0.0 : 1.0;
    for (int moment = 400; moment < 9200; moment += 800) {  // home is passed after 8000 to 9600 cycles
      HaltedHoming rig(method, 0.5);
      rig.halt_at(moment);
      ASSERT_TRUE(rig.home());
      EXPECT_NEAR(rig.home_revolutions(), home, 3e-6) << "method " << method << " halted after " << moment;
    }
  }
}

TEST(MsdHoming, TimeOutStandsStillWhileHalted) {
  MsdParameters parameters = machine(17, 3.3);
  parameters.homing_time_out = 1s;
  DriveRig rig(parameters);
  rig.set({{0x6098, 0, 17, 1}, {0x6099, 1, 1000, 4}});
  rig.start(6);
  rig.command(0x1F, 4000);
  rig.command(0x11F, 16'000);
  EXPECT_FALSE(rig.drive.fault().has_value());
  rig.command(0x1F, 3900);
  EXPECT_FALSE(rig.drive.fault().has_value());
  rig.cycles(200);
  EXPECT_EQ(rig.drive.fault(), Fault::kHoming);
}

TEST(MsdHoming, StartBitWhileEnablingIsNoStart) {
  DriveRig rig(machine(17, 0.0));
  ASSERT_EQ(rig.write(0x6098, 0, 17, 1), 0U);
  rig.operate();
  rig.mode = 6;
  for (const std::uint16_t word : {std::uint16_t{0x16}, std::uint16_t{0x17}, std::uint16_t{0x1F}}) {
    rig.command(word, 4);
  }
  rig.cycles(800);
  EXPECT_NEAR(rig.position, 0, 60);
}

TEST(MsdHoming, LimitSwitchOnTheWrongSideFails) {
  HomingRig rig(19, 0.2);
  ASSERT_EQ(rig.write(0x2067, 0, 0, 2), 0U);  // the home switch is not connected
  ASSERT_TRUE(rig.home());
  EXPECT_TRUE(rig.status & kError);
  EXPECT_EQ(rig.status & kAttained, 0);
  EXPECT_EQ(rig.drive.fault(), Fault::kHoming);
  rig.cycles(4000);
  EXPECT_EQ(rig.error_code, 0x8600);
  EXPECT_EQ(rig.drive.velocity_rad_s(), 0.0);
}

TEST(MsdHoming, CamThatIsOnNeitherSideFailsAtTheSecondLimit) {
  HomingRig rig(24, 0.2);
  ASSERT_EQ(rig.write(0x2067, 0, 0, 2), 0U);
  ASSERT_TRUE(rig.home());
  EXPECT_EQ(rig.drive.fault(), Fault::kHoming);
  EXPECT_LT(rig.revolutions(), -4.2) << "it has looked on both sides";
}

TEST(MsdHoming, TimeOutFails) {
  MsdParameters parameters = machine(17, 3.3);
  parameters.homing_time_out = 1s;
  DriveRig rig(parameters);
  rig.set({{0x6098, 0, 17, 1}, {0x6099, 1, 1000, 4}});
  rig.start(6);
  rig.command(0x1F, 7900);
  EXPECT_FALSE(rig.drive.fault().has_value());
  rig.cycles(200);
  EXPECT_EQ(rig.drive.fault(), Fault::kHoming);
}

TEST(MsdHoming, ANewStartForgetsTheResult) {
  HomingRig rig(35, 0.0);
  ASSERT_TRUE(rig.home());
  rig.command(0x0F, 4);
  EXPECT_TRUE(rig.status & kAttained) << "stays after the start bit is cleared";
  ASSERT_EQ(rig.write(0x6098, 0, 34, 1), 0U);
  rig.command(0x1F, 4);
  EXPECT_EQ(rig.status & kAttained, 0);
}

TEST(MsdHoming, ReservedMethodsAreRefused) {
  DriveRig rig;
  for (int method = -128; method < 128; ++method) {
    const bool valid = (method >= 0 && method <= 14) || (method >= 17 && method <= 30) ||
                       (method >= 33 && method <= 35) || method == 37;
    const std::uint32_t expected = valid ? 0U : method < 0 ? 0x06090032U : method > 37 ? 0x06090031U : 0x06090030U;
    EXPECT_EQ(rig.write(0x6098, 0, static_cast<std::uint8_t>(method), 1), expected) << method;
  }
}

TEST(MsdHoming, MethodZeroFails) {
  HomingRig rig(0, 0.0);
  rig.command(0x1F, 4);
  EXPECT_EQ(rig.drive.fault(), Fault::kHoming);
}

}  // namespace
}  // namespace driveline::slaves::msd
