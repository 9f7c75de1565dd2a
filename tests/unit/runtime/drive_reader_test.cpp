// The machine behind a simulated drive in the line description: numbers, switches, scripts, and their reference.
#include "devices/msd/drive_reader.hpp"

#include <fmt/format.h>
#include <gmock/gmock.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <fstream>
#include <numbers>
#include <sstream>

#include "driveline/esi/sii.hpp"
#include "driveline/runtime/config/line_config.hpp"
#include "driveline/runtime/devices/msd_device.hpp"
#include "driveline/runtime/setup/composition.hpp"
#include "driveline/slaves/msd/msd_drive.hpp"
#include "support/must.hpp"

namespace driveline::runtime {
namespace {

using namespace std::chrono_literals;
using slaves::msd::DriveCore;
using slaves::msd::Input;
using slaves::msd::MsdDrive;
using slaves::msd::Output;
using testing::HasSubstr;

constexpr double kRevolution = 2.0 * std::numbers::pi;

Result<LineConfig> parse(const std::string& rest) {
  return parse_line_config("[[slave]]\nname = \"x\"\n" + rest, "line.toml");
}

std::string error(const std::string& rest) {
  const auto config = parse(rest);
  return config ? "no error" : describe(config.error());
}

const slaves::msd::MsdParameters& drive_of(const SlaveConfig& slave) {
  return dynamic_cast<const MsdDevice&>(*slave.device).parameters();
}

std::string number(const PlantKey& row, double value) {
  return row.integer() ? fmt::format("{}", static_cast<std::int64_t>(value)) : fmt::format("{}", value);
}

/// Whether the key completes or limits values that the others leave out.
bool completes_others(const PlantKey& row) {
  constexpr std::array kRating = {"rated_torque_nm", "peak_torque_nm", "rated_current_a",
                                  "rated_speed_rpm", "max_speed_rpm",  "pole_pairs"};
  return std::find(kRating.begin(), kRating.end(), row.key) != kRating.end();
}

TEST(PlantKeys, EachComesToItsPlaceAndNoOther) {
  for (const PlantKey& row : plant_keys()) {
    if (completes_others(row)) continue;
    // Within the range, but different from the default of the model.
    const double value = std::floor(0.25 * row.minimum + 0.75 * row.maximum);
    const auto coupling = row.key == "stiffness_nm_rad" || row.key == "damping_nm_s" ? "inertia_kg_m2 = 1.0\n" : "";
    const auto config =
        must(parse(fmt::format("[slave.{}]\n{}{} = {}\n", row.table, coupling, row.key, number(row, value))));
    slaves::msd::MsdParameters expected;
    expected.motor.winding.simulated = row.table == "plant.winding";
    if (*coupling != '\0') expected.motor.load.inertia_kg_m2 = 1.0;
    const auto set = [&](auto* place) {
      *place = static_cast<std::remove_pointer_t<decltype(place)>>(value * row.scale);
    };
    std::visit(set, row.place(expected));
    auto found = drive_of(config->slaves[0]);
    for (const PlantKey& other : plant_keys()) {
      const auto of = [&other](slaves::msd::MsdParameters& parameters) {
        return std::visit([](const auto* place) { return static_cast<double>(*place); }, other.place(parameters));
      };
      EXPECT_DOUBLE_EQ(of(found), of(expected)) << row.table << '.' << row.key << " in " << other.key;
    }
    EXPECT_EQ(found.motor.winding.simulated, expected.motor.winding.simulated);
  }
}

TEST(PlantKeys, RangesAreKept) {
  for (const PlantKey& row : plant_keys()) {
    const double step = row.integer() ? 1.0 : std::max(1e-9, 1e-6 * std::abs(row.maximum));
    for (const double value : {row.minimum - step, row.maximum + step}) {
      EXPECT_THAT(error(fmt::format("[slave.{}]\n{} = {}\n", row.table, row.key, number(row, value))),
                  HasSubstr(fmt::format("line.toml:4: [slave 1.{}] {}: is ", row.table, row.key)));
    }
  }
}

TEST(PlantKeys, ReferenceHasUnitDefaultAndRangeOfTheTable) {
  std::ifstream file(DRIVELINE_DOCS_DIR "/command_line.md");
  std::stringstream text;
  text << file.rdbuf();
  for (const PlantKey& row : plant_keys()) {
    const double standard = row.standard();
    const bool none = std::isinf(standard);
    const bool all = row.integer() && standard > row.maximum;
    const auto type = row.integer() ? "integer" : "number";
    const auto unit = row.unit.empty() ? "" : fmt::format(", {}", row.unit);
    const auto initial = none            ? "none"
                         : all           ? "all"
                         : row.integer() ? number(row, standard)
                                         : fmt::format("{:.4g}", standard);
    const auto range = row.integer() ? fmt::format("{} to {}", number(row, row.minimum), number(row, row.maximum))
                                     : fmt::format("{:g} to {:g}", row.minimum, row.maximum);
    EXPECT_THAT(text.str(), HasSubstr(fmt::format("| `{}` | {}{} | {} | {} |", row.key, type, unit, initial, range)));
  }
}

TEST(DriveReader, NumbersThatDoNotGoTogether) {
  EXPECT_EQ(error("[slave.plant]\nrated_torque_nm = 5\npeak_torque_nm = 4\n"),
            "line.toml:5: [slave 1.plant] peak_torque_nm: is 4, at least rated_torque_nm, 5, is expected");
  EXPECT_EQ(
      error("[slave.plant.load]\nstiffness_nm_rad = 100\n"),
      "line.toml:4: [slave 1.plant.load] stiffness_nm_rad: is for a coupling to a load: set inertia_kg_m2 of the load");
  EXPECT_EQ(error("[slave.plant.load]\nend_stop_min_rev = 2\nend_stop_max_rev = 1.5\n"),
            "line.toml:5: [slave 1.plant.load] end_stop_max_rev: is 1.5, more than end_stop_min_rev, 2, is expected");
  const auto config = must(parse("[slave.plant]\nrated_torque_nm = 20\n"));
  EXPECT_DOUBLE_EQ(drive_of(config->slaves[0]).motor.peak_torque_nm, 60.0) << "three times, like the standard motor";
}

/// If only the rating of a motor is given, it is wound for the voltage of the standard motor, whatever its size.
TEST(DriveReader, MotorIsCompletedFromItsRating) {
  constexpr double kRadSPerRpm = 3.14159265358979 / 30.0;
  for (const std::string rating :
       {"", "rated_torque_nm = 20\n", "rated_torque_nm = 0.1\nmax_speed_rpm = 20000\n",
        "rated_torque_nm = 60\nmax_speed_rpm = 3000\nrated_speed_rpm = 2000\npole_pairs = 8\n"}) {
    const auto config = must(parse("[slave.plant]\n" + rating));
    auto parameters = drive_of(config->slaves[0]).motor;
    parameters.peak_torque_nm = 1e6;
    const auto torque_at = [&](double share_of_max_speed) {
      parameters.coulomb_friction_nm = parameters.viscous_friction_nm_s = 0.0;
      slaves::ServoMotor motor(parameters, 62.5e-6, 0.0);
      const double speed = share_of_max_speed * parameters.max_speed_rad_s;
      for (int i = 0; i < 500'000 && motor.velocity_rad_s() < speed; ++i) motor.step(parameters.rated_torque_nm);
      EXPECT_GE(motor.velocity_rad_s(), speed) << "rated torque is there all the way";
      return motor.torque_range().highest_nm / parameters.rated_torque_nm;
    };
    EXPECT_NEAR(torque_at(0.5), 5.2, 0.2) << rating;
    EXPECT_NEAR(torque_at(0.995), 1.3, 0.1) << rating;
  }
  const auto slow = must(parse("[slave.plant]\nmax_speed_rpm = 3000\n"));
  EXPECT_NEAR(drive_of(slow->slaves[0]).motor.rated_speed_rad_s, 1500.0 * kRadSPerRpm, 1e-6) << "half of it";
  const auto said =
      must(parse("[slave.plant]\nrated_torque_nm = 20\nrated_current_a = 9\n[slave.plant.winding]\n"
                 "resistance_ohm = 0.7\ninductance_mh = 2\n"));
  EXPECT_DOUBLE_EQ(drive_of(said->slaves[0]).motor.rated_current_a, 9.0);
  EXPECT_DOUBLE_EQ(drive_of(said->slaves[0]).motor.winding.resistance_ohm, 0.7);
  EXPECT_DOUBLE_EQ(drive_of(said->slaves[0]).motor.winding.inductance_h, 2e-3);
  EXPECT_EQ(error("[slave.plant]\nmax_speed_rpm = 3000\nrated_speed_rpm = 4000\n"),
            "line.toml:5: [slave 1.plant] rated_speed_rpm: is 4000, at most max_speed_rpm, 3000, is expected");
}

TEST(DriveReader, BreakContacts) {
  const auto config =
      must(parse("[[slave.switch]]\ninput = \"ISD00\"\nto_rev = -1\nnormally_closed = true\n"
                 "[[slave.switch]]\ninput = \"ISD01\"\nfrom_rev = 1\n"));
  EXPECT_TRUE(drive_of(config->slaves[0]).switches[0].normally_closed);
  EXPECT_FALSE(drive_of(config->slaves[0]).switches[1].normally_closed);
}

TEST(DriveReader, WrongSwitches) {
  const auto wrong = [](const std::string& keys) { return error("[[slave.switch]]\n" + keys); };
  EXPECT_THAT(wrong("input = \"ISD07\"\nto_rev = 1\n"),
              HasSubstr("line.toml:4: [slave 1.switch 1] input: \"ISD07\" is no input of the drive; there are ENPO, "));
  EXPECT_THAT(wrong("input = \"DC_LINK\"\nto_rev = 1\n"),
              HasSubstr("input: is not a terminal, but a switch needs one"));
  EXPECT_THAT(wrong("input = \"ISD00\"\n"),
              HasSubstr("from_rev or to_rev is missing: the position of the switch is expected"));
  EXPECT_THAT(wrong("input = \"ISD00\"\nfrom_rev = 2\nto_rev = 1\n"),
              HasSubstr("to_rev: is 1, more than from_rev, 2, is expected"));
}

TEST(DriveReader, WrongScripts) {
  const auto wrong = [](const std::string& keys) { return error("[[slave.input]]\nentry = \"ISD01\"\n" + keys); };
  EXPECT_THAT(wrong("shape = \"ramp\"\nperiod_s = 1\n"),
              HasSubstr("line.toml:5: [slave 1.input 1] shape: is for numbers"));
  EXPECT_THAT(wrong("value = 2\n"), HasSubstr("entry: 2 does not fit ISD01, 0 or 1 is expected"));
  EXPECT_THAT(wrong("shape = \"steps\"\nvalues = [1]\n"), HasSubstr("at_ms: is missing, an array of numbers is"));
  EXPECT_THAT(wrong("shape = \"steps\"\nat_ms = [5]\nvalues = [1]\n"), HasSubstr("at_ms: must start with 0"));
  EXPECT_THAT(wrong("shape = \"steps\"\nat_ms = [0, 5]\nvalues = [1]\n"),
              HasSubstr("values: has 1 numbers, at_ms has 2"));
  EXPECT_THAT(wrong("shape = \"steps\"\nat_ms = [0, 5, 5]\nvalues = [1, 0, 1]\n"), HasSubstr("at_ms: 5 follows 5"));
  EXPECT_THAT(wrong("shape = \"steps\"\nat_ms = [0, \"5\"]\nvalues = [1, 0]\n"), HasSubstr("at_ms: contains a string"));
  EXPECT_THAT(wrong("value = 1\n[[slave.input]]\nentry = \"ISD01\"\nvalue = 0\n"), HasSubstr("already has a script"));
  EXPECT_THAT(wrong("value = 1\n[[slave.switch]]\ninput = \"ISD01\"\nto_rev = 1\n"),
              HasSubstr("entry: already has a [[slave.switch]]"));
  EXPECT_THAT(error("[[slave.input]]\nentry = \"DC_LINK\"\nvalue = 2000\n"),
              HasSubstr("entry: 2000 does not fit DC_LINK, 0 to 1000 V is expected"));
}

/// The simulated drive of a line description, on virtual time.
class ScriptedDrive {
 public:
  explicit ScriptedDrive(const std::string& rest) {
    const auto config = parse(rest);
    EXPECT_TRUE(config) << describe(config.error());
    line_ = make_simulated_line(*config, clock_);
    line_->advance(clock_.now());
  }
  void pass(std::chrono::nanoseconds time) {
    clock_.advance(time);
    line_->advance(clock_.now());
  }
  [[nodiscard]] DriveCore& drive() { return dynamic_cast<MsdDrive&>(line_->slave(0).device()).core(); }
  [[nodiscard]] bool level(std::string_view name) {
    const auto place = drive().signals().find_signal(slaves::SignalId::Direction::kInput, name);
    return place && drive().signals().signal(*place) > 0.5;
  }

 private:
  rt::VirtualClock clock_;
  std::unique_ptr<slaves::SimulatedLine> line_;
};

/// 1018h:04 and the EEPROM of the simulated slaves have the values that the line description expects.
TEST(SimulatedLine, HasTheSerialNumbersThatAreExpected) {
  const auto config =
      must(parse("[[slave]]\nname = \"b\"\nserial = 4711\n[[slave]]\nname = \"c\"\nserial = \">= 2\"\n"
                 "[[slave]]\nname = \"d\"\nserial = \">= 100\"\n[[slave]]\nname = \"e\"\nserial = \"= 7\"\nesi = "
                 "\"" DRIVELINE_EXAMPLES_DIR "/terminals.xml\"\ndevice = \"MX4\"\n"));
  rt::VirtualClock clock;
  const auto line = make_simulated_line(*config, clock);
  const std::array<std::uint32_t, 5> expected = {1, 4711, 3, 100, 7};
  for (std::size_t i = 0; i < expected.size(); ++i) {
    const auto sii = must(esi::decode_sii(line->slave(i).device().profile().sii_image));
    EXPECT_EQ(esi::description_from_sii(*sii).serial_number, expected[i]) << i;
  }
  const auto& dictionary = dynamic_cast<MsdDrive&>(line->slave(1).device()).core().dictionary();
  EXPECT_EQ(dictionary.raw(*dictionary.table().find(0x1018, 4)), 4711U);
}

TEST(DriveScript, StepsAndTogglesComeAtTheirTimes) {
  ScriptedDrive rig(
      "[[slave.input]]\nentry = \"ENPO\"\nshape = \"steps\"\nat_ms = [0, 10, 25]\nvalues = [0, 1, 0]\n"
      "[[slave.input]]\nentry = \"ISD03\"\nshape = \"toggle\"\nperiod_s = 0.01\n"
      "[[slave.input]]\nentry = \"ISD04\"\nvalue = 1\n");
  for (int ms = 0; ms < 40; ++ms) {
    rig.pass(500us);
    EXPECT_EQ(rig.level("ENPO"), ms >= 10 && ms < 25) << ms;
    EXPECT_EQ(rig.level("ISD03"), ms % 10 >= 5) << ms;
    EXPECT_TRUE(rig.level("ISD04"));
    EXPECT_FALSE(rig.level("ISD05"));
    rig.pass(500us);
  }
}

TEST(DriveScript, StoRelayFollowsAScriptOfIsdsh) {
  ScriptedDrive rig("[[slave.input]]\nentry = \"ISDSH\"\nshape = \"steps\"\nat_ms = [0, 5]\nvalues = [1, 0]\n");
  rig.pass(4ms);
  EXPECT_FALSE(rig.drive().output(Output::kStoRelay));
  rig.pass(2ms);
  EXPECT_TRUE(rig.drive().output(Output::kStoRelay));
}

TEST(DriveScript, DcLinkFollowsItsScript) {
  ScriptedDrive rig("[slave.plant]\ndc_link_v = 300\n");
  rig.pass(1ms);
  const auto volts = must(rig.drive().signals().find_signal(slaves::SignalId::Direction::kInput, "DC_LINK"));
  EXPECT_EQ(rig.drive().signals().signal(*volts), 300.0);
  ScriptedDrive failing(
      "[[slave.input]]\nentry = \"DC_LINK\"\nshape = \"steps\"\nat_ms = [0, 2]\nvalues = [560, 20]\n");
  failing.pass(1ms);
  EXPECT_EQ(failing.drive().signals().signal(*volts), 560.0);
  failing.pass(2ms);
  EXPECT_EQ(failing.drive().signals().signal(*volts), 20.0);
}

TEST(DriveScript, WhatIsSetByHandStaysSet) {
  ScriptedDrive rig(
      "[[slave.input]]\nentry = \"ENPO\"\nshape = \"toggle\"\nperiod_s = 0.002\n"
      "[[slave.switch]]\ninput = \"ISD02\"\nfrom_rev = -1\nto_rev = 1\n");
  rig.pass(1ms);
  EXPECT_TRUE(rig.level("ISD02")) << "the shaft is on the cam";
  for (const auto* name : {"ENPO", "ISD02"}) {
    const auto place = rig.drive().signals().find_signal(slaves::SignalId::Direction::kInput, name);
    rig.drive().signals().set_signal(place->number, 0.0);
    for (int i = 0; i < 10; ++i) {
      rig.pass(700us);
      EXPECT_FALSE(rig.level(name));
    }
  }
}

TEST(VerticalExample, HasItsMachine) {
  const auto config = must(load_line_config(DRIVELINE_EXAMPLES_DIR "/vertical.toml"));
  const auto& drive = drive_of(config->slaves[0]);
  EXPECT_TRUE(drive.motor.winding.simulated);
  EXPECT_DOUBLE_EQ(drive.motor.load.gravity_nm, 0.9);
  EXPECT_DOUBLE_EQ(drive.motor.load.end_stop_max_rad, 9.0 * kRevolution);
  ASSERT_EQ(drive.switches.size(), 2U);
  EXPECT_EQ(drive.switches[0].input, Input::kIsd00);
  EXPECT_DOUBLE_EQ(drive.switches[0].to_rad, -0.7 * kRevolution);
  EXPECT_TRUE(std::isinf(drive.switches[0].from_rad));
}

}  // namespace
}  // namespace driveline::runtime
