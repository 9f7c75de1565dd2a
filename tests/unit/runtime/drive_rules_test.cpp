// Rules of the master for drives of known families, selected by the expected identity.
#include "driveline/runtime/devices/drive_rules.hpp"

#include <gmock/gmock.h>

#include <numbers>

#include "acme/acme_family.hpp"
#include "driveline/runtime/config/line_config.hpp"
#include "driveline/runtime/setup/clock_plan.hpp"
#include "driveline/runtime/setup/composition.hpp"
#include "driveline/slaves/msd/core/variant.hpp"

namespace driveline::runtime {
namespace {

using motion::cia402::Mode;
using std::chrono::microseconds;
using std::chrono::nanoseconds;
using testing::ElementsAre;

/// Objects and values, e.g. "2132:00 0000003E", with the bytes in wire order.
std::vector<std::string> written(const std::vector<motion::StartupSdo>& sdos) {
  constexpr auto kDigits = "0123456789ABCDEF";
  std::vector<std::string> texts;
  for (const auto& sdo : sdos) {
    std::string text;
    for (int shift = 12; shift >= 0; shift -= 4) text += kDigits[sdo.index >> shift & 0xF];
    text += {':', kDigits[sdo.subindex >> 4], kDigits[sdo.subindex & 0xF], ' '};
    for (const auto byte : sdo.data) {
      text +=
          {kDigits[std::to_integer<unsigned>(byte >> 4)], kDigits[std::to_integer<unsigned>(byte & std::byte{0xF})]};
    }
    texts.push_back(text);
  }
  return texts;
}

const DriveRules& msd() {
  static const DeviceRegistry kDevices;
  return kDevices.rules_for({slaves::msd::kVendorId, slaves::msd::kProductCode});
}

motion::AxisConfig axis(Mode mode = Mode::kCyclicPosition) {
  motion::AxisConfig config;
  config.mode = mode;
  config.inertia = 0.5;
  return config;
}

TEST(MsdStartup, OfACspAxis) {
  // P 306 = 2132h: 0.125 ms as IEEE 754; 60C2h: 125 * 10^-6 s; P 370 = 2172h: 3; P 1516 = 25ECh: 0.5 kg m^2.
  EXPECT_THAT(written(msd().startup_sdos(axis(), microseconds{125})),
              ElementsAre("2132:00 0000003E", "60C2:01 7D", "60C2:02 FA", "2172:00 03", "25EC:00 0000003F"));
}

TEST(MsdStartup, LeavesOutWhatIsNotKnown) {
  auto one = axis();
  one.inertia = 0.0;
  EXPECT_EQ(msd().startup_sdos(one, microseconds{1000}).size(), 4U);
  one = axis();
  one.kind = trajectory::AxisKind::kLinear;
  EXPECT_EQ(msd().startup_sdos(one, microseconds{1000}).size(), 4U) << "P 1516 is in kg m^2";
}

TEST(MsdStartup, OfAnAxisThatMayChangeToCspIsThatOfCsp) {
  const auto csp = written(msd().startup_sdos(axis(), microseconds{1000}));
  for (const auto mode : {Mode::kCyclicVelocity, Mode::kCyclicTorque}) {
    EXPECT_EQ(written(msd().startup_sdos(axis(mode), microseconds{1000})), csp);
  }
}

TEST(MsdStartup, TakesTheTorqueFromTheMasterWhereThatKnowsMoreThanTheInertia) {
  auto one = axis();
  one.feed_forward.coulomb_friction = 0.1;
  // P 379 = 217Bh: sub 2, the torque comes from 60B2h.
  EXPECT_THAT(written(msd().startup_sdos(one, microseconds{1000})), testing::Contains("217B:02 0100"));
  one.mode = Mode::kCyclicVelocity;
  EXPECT_THAT(written(msd().startup_sdos(one, microseconds{1000})), testing::Contains("217B:02 0100"));
  one.mode = Mode::kCyclicTorque;
  EXPECT_THAT(written(msd().startup_sdos(one, microseconds{1000})), testing::Not(testing::Contains("217B:02 0100")))
      << "part of the target there";
}

TEST(MsdStartup, RefusesAPeriodTheDriveCannotBeTold) {
  EXPECT_THROW(static_cast<void>(msd().startup_sdos(axis(), nanoseconds{312'500})), std::invalid_argument);
}

LineConfig parse(const std::string& text) {
  DeviceRegistry devices;
  static_cast<void>(devices.add(std::make_shared<acme::AcmeFamily>()));
  auto config = parse_line_config(text, "line.toml", devices);
  if (!config) throw std::runtime_error(describe(config.error()));
  return *config;
}

/// The SDOs for a slave with these keys and an axis.
std::vector<std::string> startup_of(const std::string& keys) {
  return written(
      make_slave_plans(parse("[[slave]]\nname = \"x\"\n" + keys + "[[axis]]\nname = \"x\"\n")).at(0).startup_sdos);
}

TEST(DriveRules, GoByTheIdentityThatIsExpected) {
  EXPECT_EQ(startup_of("").front(), "2132:00 0000003E") << "an MSD, without a word";
  EXPECT_EQ(startup_of("model = \"servoone\"\n").front(), "2132:00 0000003E");
  const auto cia402 = ElementsAre("60C2:01 7D", "60C2:02 FA");
  EXPECT_THAT(startup_of("vendor_id = 0x1234\nproduct_code = 1\n"), cia402) << "a drive that nobody knows";
  const auto acme = ElementsAre("60C2:01 7D", "60C2:02 FA", "4001:00 7D000000");
  EXPECT_THAT(startup_of("model = \"acme\"\n"), acme);
  EXPECT_THAT(startup_of("vendor_id = 0xE000ACE0\nproduct_code = 1\n"), acme)
      << "a real one, of which no model is said";
}

TEST(DriveRules, ThePlanExpectsWhatTheFamilySays) {
  const auto plan = make_slave_plans(parse("[[slave]]\nname = \"x\"\nmodel = \"acme\"\n")).at(0);
  EXPECT_EQ(plan.vendor_id, acme::kVendorId);
  EXPECT_EQ(plan.product_code, acme::kProductCode);
  EXPECT_EQ(make_slave_plans(parse("[[slave]]\nname = \"x\"\nmodel = \"acme\"\nproduct_code = 5\n")).at(0).product_code,
            5U);
}

TEST(DriveRules, GiveAnAxisWhatTheFileLeavesOut) {
  const std::string slave = "[[slave]]\nname = \"x\"\nmodel = \"acme\"\n[[axis]]\nname = \"x\"\n";
  const auto left_out = parse(slave).axes.at(0);
  EXPECT_DOUBLE_EQ(left_out.increments_per_unit * 2.0 * std::numbers::pi, 65536.0);
  EXPECT_EQ(left_out.rated_torque, 1.3);
  EXPECT_EQ(left_out.limits.max_velocity, 100.0);
  EXPECT_EQ(left_out.limits.max_acceleration, 1000.0);
  const auto said =
      parse(slave + "increments_per_revolution = 100\nrated_torque_nm = 2\nmax_velocity = 3\n").axes.at(0);
  EXPECT_DOUBLE_EQ(said.increments_per_unit * 2.0 * std::numbers::pi, 100.0);
  EXPECT_EQ(said.rated_torque, 2.0);
  EXPECT_EQ(said.limits.max_velocity, 3.0);
}

TEST(DriveRules, SayOfWhatTheCycleOfTheClockIsAMultiple) {
  const auto base = [](const std::string& keys) {
    const auto config = parse("[dc]\n[[slave]]\nname = \"x\"\n" + keys);
    return make_clock_plan(config, std::vector<ecat_master::ConfiguredSlave>(1))->slaves.at(0).base;
  };
  EXPECT_EQ(base(""), microseconds{125});
  EXPECT_EQ(base("model = \"acme\"\n"), microseconds{250});
  EXPECT_EQ(base("vendor_id = 0x1234\n"), nanoseconds{0}) << "nobody knows";
}

}  // namespace
}  // namespace driveline::runtime
