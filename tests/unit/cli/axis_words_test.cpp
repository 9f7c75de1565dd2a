// Parsing of requests to axes: words, units, scripts.
#include "axes/axis_words.hpp"

#include <gmock/gmock.h>

#include <numbers>

#include "axes/quantity.hpp"
#include "script/axis_script.hpp"

namespace driveline::cli {
namespace {

using motion::AxisCommand;
using motion::AxisConfig;
using motion::AxisRequest;
using motion::BufferMode;
using motion::MoveDirection;
using motion::ProbeTrigger;
using testing::ElementsAre;
using testing::HasSubstr;

constexpr double kDegree = std::numbers::pi / 180.0;

AxisConfig rotary() {
  AxisConfig axis;
  axis.name = "x";
  axis.unit = trajectory::find_position_unit("deg");
  return axis;
}

AxisConfig linear() {
  AxisConfig axis;
  axis.name = "z";
  axis.kind = trajectory::AxisKind::kLinear;
  axis.unit = trajectory::find_position_unit("mm");
  return axis;
}

AxisRequest read(const AxisConfig& axis, std::string_view text) {
  const auto request = parse_axis_request(axis, split_words(text));
  EXPECT_TRUE(request) << request.error().text;
  return request.value_or(AxisRequest{});
}

std::string refusal(const AxisConfig& axis, std::string_view text) {
  const auto request = parse_axis_request(axis, split_words(text));
  EXPECT_FALSE(request) << text;
  if (request) return {};
  EXPECT_EQ(request.error().status, 2);
  return request.error().text;
}

TEST(AxisWords, AreSeparatedBySpacesAndHeldTogetherByQuotes) {
  EXPECT_THAT(split_words("  x move\t\"90 deg\"\r"), ElementsAre("x", "move", "90 deg"));
  EXPECT_THAT(split_words(""), testing::IsEmpty());
  EXPECT_THAT(split_words("velocity=\"30 deg/s\""), ElementsAre("velocity=30 deg/s"));
  for (const std::string word : {"x", "90 deg", ""}) {
    EXPECT_THAT(split_words("a " + quoted_word(word)), ElementsAre("a", word));
  }
}

TEST(AxisWords, NumbersHaveTheUnitOfTheAxisOrTheirOwn) {
  EXPECT_DOUBLE_EQ(read(rotary(), "move 90").target_si, 90.0 * kDegree);
  EXPECT_DOUBLE_EQ(read(rotary(), "move +90deg").target_si, 90.0 * kDegree);
  EXPECT_DOUBLE_EQ(read(rotary(), "move -1.5rad").target_si, -1.5);
  EXPECT_DOUBLE_EQ(read(rotary(), "move \"2 rev\"").target_si, 4.0 * std::numbers::pi);
  EXPECT_DOUBLE_EQ(read(linear(), "move 10").target_si, 0.01);
  EXPECT_DOUBLE_EQ(read(linear(), "move 10um").target_si, 1e-5);
  EXPECT_DOUBLE_EQ(read(rotary(), "jog -20rpm").target_si, -20.0 * 2.0 * std::numbers::pi / 60.0);
  EXPECT_DOUBLE_EQ(read(linear(), "jog 6m/min").target_si, 0.1);
  EXPECT_DOUBLE_EQ(read(rotary(), "torque 0.5Nm").target_si, 0.5);
}

TEST(AxisWords, SettingsBelongToMotions) {
  const auto request =
      read(rotary(), "move by=10 velocity=30deg/s acceleration=100deg/s^2 deceleration=50 jerk=1000 buffer=buffered");
  EXPECT_EQ(request.command, AxisCommand::kMoveRelative);
  EXPECT_DOUBLE_EQ(request.target_si, 10.0 * kDegree);
  EXPECT_DOUBLE_EQ(request.velocity_si, 30.0 * kDegree);
  EXPECT_DOUBLE_EQ(request.acceleration_si, 100.0 * kDegree);
  EXPECT_DOUBLE_EQ(request.deceleration_si, 50.0 * kDegree);
  EXPECT_DOUBLE_EQ(request.jerk_si, 1000.0 * kDegree);
  EXPECT_EQ(request.buffer, BufferMode::kBuffered);
  EXPECT_EQ(read(rotary(), "move add=1").command, AxisCommand::kMoveAdditive);
  EXPECT_EQ(read(rotary(), "move superimpose=1").command, AxisCommand::kMoveSuperimposed);
  EXPECT_THAT(refusal(rotary(), "halt velocity=3"), HasSubstr("\"velocity=\" does not belong there"));
}

TEST(AxisWords, EveryRequestHasItsWord) {
  EXPECT_TRUE(read(rotary(), "enable").on);
  EXPECT_FALSE(read(rotary(), "disable").on);
  EXPECT_EQ(read(rotary(), "reset").command, AxisCommand::kReset);
  EXPECT_EQ(read(rotary(), "home").command, AxisCommand::kHome);
  EXPECT_EQ(read(rotary(), "stop").command, AxisCommand::kStop);
  EXPECT_EQ(read(rotary(), "release-stop").command, AxisCommand::kReleaseStop);
  EXPECT_EQ(read(rotary(), "halt").command, AxisCommand::kHalt);
  EXPECT_EQ(read(rotary(), "position 0").command, AxisCommand::kSetPosition);
  EXPECT_DOUBLE_EQ(read(rotary(), "override 50%").target_si, 0.5);
  EXPECT_DOUBLE_EQ(read(rotary(), "override 1.2").target_si, 1.2);
  EXPECT_EQ(read(rotary(), "mode csp").mode, 8);
  EXPECT_EQ(read(rotary(), "mode cst").mode, 10);
  EXPECT_EQ(read(rotary(), "mode ip").mode, 7);
  EXPECT_EQ(read(rotary(), "abort-probe").command, AxisCommand::kAbortTrigger);
}

TEST(AxisWords, ATouchProbeHasAnInputAndAnEdge) {
  const auto trigger = [](std::string_view words) {
    const auto request = read(rotary(), words);
    EXPECT_EQ(request.command, AxisCommand::kTouchProbe);
    return request.trigger;
  };
  EXPECT_EQ(trigger("probe"), ProbeTrigger::kFirstRising);
  EXPECT_EQ(trigger("probe 1 rising"), ProbeTrigger::kFirstRising);
  EXPECT_EQ(trigger("probe falling"), ProbeTrigger::kFirstFalling);
  EXPECT_EQ(trigger("probe 2"), ProbeTrigger::kSecondRising);
  EXPECT_EQ(trigger("probe falling 2"), ProbeTrigger::kSecondFalling);
  EXPECT_EQ(trigger("probe zero"), ProbeTrigger::kZeroPulse);
  const auto window = read(rotary(), "probe 2 from=10 to=-20deg");
  EXPECT_DOUBLE_EQ(window.window_first_si, 10.0 * kDegree);
  EXPECT_DOUBLE_EQ(window.window_last_si, -20.0 * kDegree);
  EXPECT_EQ(
      refusal(rotary(), "probe 3"),
      "axis x: probe: \"3\" was not expected; expected are 1, 2 or zero (touch probe) and rising or falling (edge)");
  EXPECT_THAT(refusal(rotary(), "probe 1 2"), HasSubstr("probe: \"2\" was not expected"));
  EXPECT_THAT(refusal(rotary(), "probe rising falling"), HasSubstr("probe: \"falling\" was not expected"));
  EXPECT_EQ(refusal(rotary(), "probe zero rising"),
            "axis x: probe: the zero pulse of an encoder has no edge to choose");
  EXPECT_EQ(refusal(rotary(), "probe from=1"), "axis x: probe: from= and to= must be given together");
  EXPECT_EQ(refusal(rotary(), "probe velocity=1"), "axis x: probe: \"velocity=\" does not belong there");
  EXPECT_THAT(refusal(rotary(), "probe from=far to=1"), HasSubstr("from \"far\": a number is expected"));
  EXPECT_EQ(refusal(rotary(), "abort-probe 1"), "axis x: abort-probe: \"1\" was not expected");
}

TEST(AxisWords, HomingByATouchProbeHasADistance) {
  const auto request = read(linear(), "home-probe -100 2 falling velocity=5mm/s at=7 acceleration=20");
  EXPECT_EQ(request.command, AxisCommand::kHomeByProbe);
  EXPECT_EQ(request.trigger, ProbeTrigger::kSecondFalling);
  EXPECT_DOUBLE_EQ(request.distance_si, -0.1);
  EXPECT_DOUBLE_EQ(request.velocity_si, 0.005);
  EXPECT_DOUBLE_EQ(request.acceleration_si, 0.02);
  EXPECT_DOUBLE_EQ(request.target_si, 0.007);
  EXPECT_DOUBLE_EQ(read(linear(), "home-probe 1").distance_si, 0.001) << "the first number is the distance";
  EXPECT_EQ(refusal(linear(), "home-probe"), "axis z: home-probe needs a distance, with the sign of its direction");
  EXPECT_EQ(refusal(linear(), "home-probe rising"), "distance \"rising\": a number is expected, as 10mm");
  EXPECT_EQ(refusal(linear(), "home-probe 1 buffer=buffered"), "axis z: home-probe: \"buffer=\" does not belong there");
}

TEST(AxisWords, PositionsOfAModuloHaveADirection) {
  EXPECT_EQ(read(rotary(), "move 90").direction, MoveDirection::kNone);
  EXPECT_EQ(read(rotary(), "move 90 direction=shortest").direction, MoveDirection::kShortest);
  EXPECT_EQ(read(rotary(), "move direction=positive 90").direction, MoveDirection::kPositive);
  EXPECT_EQ(read(rotary(), "move 90 direction=negative").direction, MoveDirection::kNegative);
  EXPECT_EQ(refusal(rotary(), "move 90 direction=short"),
            "direction \"short\": shortest, positive, negative are possible; did you mean shortest?");
  EXPECT_EQ(refusal(rotary(), "jog 90 direction=positive"), "axis x: jog: \"direction=\" does not belong there");
}

TEST(AxisWords, DrivesMoveByThemselves) {
  auto request = read(rotary(), "drive-move 90 velocity=30 acceleration=10 deceleration=20");
  EXPECT_EQ(request.command, AxisCommand::kDriveMoveAbsolute);
  EXPECT_DOUBLE_EQ(request.target_si, 90.0 * kDegree);
  EXPECT_DOUBLE_EQ(request.velocity_si, 30.0 * kDegree);
  EXPECT_DOUBLE_EQ(request.acceleration_si, 10.0 * kDegree);
  EXPECT_DOUBLE_EQ(request.deceleration_si, 20.0 * kDegree);
  EXPECT_EQ(read(rotary(), "drive-move by=-1rev").command, AxisCommand::kDriveMoveRelative);
  EXPECT_EQ(read(rotary(), "drive-move 90 buffer=buffered").buffer, BufferMode::kBuffered);
  EXPECT_EQ(refusal(rotary(), "drive-move 90 buffer=blending_low"),
            "buffer \"blending_low\": aborting, buffered are possible");
  EXPECT_EQ(refusal(rotary(), "drive-jog 9 buffer=buffered"), "axis x: drive-jog: \"buffer=\" does not belong there");
  request = read(rotary(), "drive-jog -60rpm deceleration=20");
  EXPECT_EQ(request.command, AxisCommand::kDriveMoveVelocity);
  EXPECT_DOUBLE_EQ(request.target_si, -2.0 * std::numbers::pi);
  request = read(rotary(), "drive-run 30rpm");
  EXPECT_EQ(request.command, AxisCommand::kDriveRun);
  EXPECT_DOUBLE_EQ(request.target_si, std::numbers::pi);
  EXPECT_EQ(refusal(rotary(), "drive-run"), "axis x: drive-run needs a velocity");
  EXPECT_EQ(refusal(rotary(), "drive-run 1 acceleration=3"),
            "axis x: drive-run: \"acceleration=\" does not belong there");
  EXPECT_EQ(refusal(rotary(), "drive-move"), "axis x: drive-move needs a position, or by=DISTANCE");
  EXPECT_EQ(refusal(rotary(), "drive-move 1 jerk=3"), "axis x: drive-move: \"jerk=\" does not belong there");
  EXPECT_EQ(refusal(rotary(), "drive-jog 1 velocity=3"), "axis x: drive-jog: \"velocity=\" does not belong there");
  EXPECT_EQ(refusal(rotary(), "drive-mvoe 1"), "axis x: unknown request \"drive-mvoe\"; did you mean drive-move?");
}

TEST(AxisWords, WrongOnesGetASentenceWithWhatWasMeant) {
  EXPECT_EQ(refusal(rotary(), "mvoe 90"), "axis x: unknown request \"mvoe\"; did you mean move?");
  EXPECT_THAT(refusal(rotary(), ""), HasSubstr("a request is missing; enable, disable"));
  EXPECT_EQ(refusal(rotary(), "move"), "axis x: move needs a position, or by=DISTANCE");
  EXPECT_EQ(refusal(rotary(), "move far"), "position \"far\": a number is expected, as 10deg");
  EXPECT_EQ(refusal(rotary(), "move 90mm"),
            "position \"90mm\": axis x has no unit \"mm\" for it; deg, rad, rev are possible");
  EXPECT_THAT(refusal(rotary(), "jog 90deg/sec"), HasSubstr("did you mean deg/s?"));
  EXPECT_THAT(refusal(rotary(), "move nan"), HasSubstr("a number is expected"));
  EXPECT_THAT(refusal(rotary(), "move 1e999"), HasSubstr("a number is expected"));
  EXPECT_EQ(refusal(rotary(), "move 1 2"), "axis x: move: \"2\" was not expected");
  EXPECT_EQ(refusal(rotary(), "enable 2"), "axis x: enable: \"2\" was not expected");
  EXPECT_EQ(refusal(rotary(), "move 1 velocty=3"),
            "axis x: move: \"velocty=\" does not belong there; did you mean velocity?");
  EXPECT_EQ(refusal(rotary(), "mode csx"), "mode \"csx\": csp, csv, cst or ip is expected; did you mean csp?");
  EXPECT_THAT(refusal(rotary(), "move 1 buffer=buferred"), HasSubstr("did you mean buffered?"));
}

TEST(AxisWords, WrongSpellingsOfNumbersGetTheRightOne) {
  EXPECT_EQ(refusal(rotary(), "move 90 deg"), "axis x: move: \"deg\" was not expected; did you mean 90deg?");
  EXPECT_EQ(refusal(rotary(), "jog -20 deg/s"), "axis x: jog: \"deg/s\" was not expected; did you mean -20deg/s?");
  EXPECT_EQ(refusal(linear(), "move 10 velocity=30 mm/s"),
            "axis z: move: \"mm/s\" was not expected; a unit follows its number without a space");
  EXPECT_EQ(refusal(rotary(), "move 90 grad"), "axis x: move: \"grad\" was not expected");
  EXPECT_EQ(refusal(rotary(), "move 1,5deg"), "position \"1,5deg\": a decimal point is expected; did you mean 1.5deg?");
  EXPECT_EQ(refusal(rotary(), "move 90 velocity=0,25rev/s"),
            "velocity \"0,25rev/s\": a decimal point is expected; did you mean 0.25rev/s?");
  EXPECT_THAT(refusal(rotary(), "move 1,2,3"), HasSubstr("axis x has no unit \",2,3\""));
  const auto time = parse_time("1,5s", "--for");
  ASSERT_FALSE(time);
  EXPECT_THAT(time.error().text, HasSubstr("; did you mean 1.5s?"));
}

TEST(AxisWords, TimesAndAxes) {
  using std::chrono::milliseconds;
  EXPECT_EQ(parse_time("2s", "--for").value(), milliseconds{2000});
  EXPECT_EQ(parse_time("500ms", "--for").value(), milliseconds{500});
  EXPECT_EQ(parse_time("0.5", "--for").value(), milliseconds{500});
  for (const auto* wrong : {"", "-1s", "2h", "soon", "nan", "inf", "1e9"}) {
    const auto time = parse_time(wrong, "--for");
    ASSERT_FALSE(time) << wrong;
    EXPECT_THAT(time.error().text, HasSubstr("a time such as 2s or 500ms is expected"));
  }
  const std::vector<AxisConfig> axes{rotary(), linear()};
  EXPECT_THAT(find_axes(axes, "all").value(), ElementsAre(0U, 1U));
  EXPECT_THAT(find_axes(axes, "z").value(), ElementsAre(1U));
  const auto none = find_axes(axes, "y");
  ASSERT_FALSE(none);
  EXPECT_THAT(none.error().text, HasSubstr("there is no axis \"y\"; the line has x, z"));
  EXPECT_FALSE(find_axes({}, "all"));
}

TEST(AxisScript, ErrorsHaveFileAndLine) {
  const std::vector<AxisConfig> axes{rotary(), linear()};
  const auto wrong = [&](std::string_view text) {
    const auto script = AxisScript::parse(text, "moves.txt", {axes});
    EXPECT_FALSE(script);
    return script ? std::string{} : script.error().text;
  };
  EXPECT_THAT(wrong("x move 90\n# far\n\ny move 90\n"), HasSubstr("moves.txt:4: there is no axis \"y\""));
  EXPECT_THAT(wrong("x move 90mm"), HasSubstr("moves.txt:1: position \"90mm\""));
  EXPECT_THAT(wrong("sleep long"), HasSubstr("moves.txt:1: sleep \"long\""));
  EXPECT_THAT(wrong("wait"), HasSubstr("moves.txt:1: "));
  EXPECT_EQ(wrong("# nothing\n"), "moves.txt: it contains no request");
  EXPECT_TRUE(AxisScript::parse("all enable\nwait all # here\nx move 90; \n", "m", {axes}).error().status == 2);
  EXPECT_TRUE(AxisScript::parse("all enable\r\nwait all # here\nsleep 20ms", "m", {axes}));
}

}  // namespace
}  // namespace driveline::cli
