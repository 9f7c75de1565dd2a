// Parsing of requests to groups of axes.
#include "groups/group_words.hpp"

#include <gmock/gmock.h>

#include <limits>
#include <nlohmann/json.hpp>
#include <numbers>

#include "axes/axis_words.hpp"
#include "groups/group_view.hpp"

namespace driveline::cli {
namespace {

using runtime::ClientGroupRequest;
using testing::HasSubstr;
using trajectory::PathMove;
using Verb = ClientGroupRequest::Verb;

constexpr double kDegree = std::numbers::pi / 180.0;

class GroupWords : public testing::Test {
 protected:
  GroupWords() {
    motion::AxisConfig slide;
    slide.name = "x";
    slide.kind = trajectory::AxisKind::kLinear;
    slide.unit = trajectory::find_position_unit("mm");
    motion::AxisConfig turn;
    turn.name = "c";
    turn.unit = trajectory::find_position_unit("deg");
    axes = {turn, slide};
    config.name = "head";
    config.axes = {1, 0};
    config.tolerance = 1e-4;
  }
  ClientGroupRequest read(std::string_view text) {
    const auto request = parse_group_request({config, axes}, split_words(text));
    EXPECT_TRUE(request) << request.error().text;
    return request.value_or(ClientGroupRequest{});
  }
  std::string refusal(std::string_view text) {
    const auto request = parse_group_request({config, axes}, split_words(text));
    EXPECT_FALSE(request) << text;
    if (request) return {};
    EXPECT_EQ(request.error().status, 2);
    return request.error().text;
  }

  std::vector<motion::AxisConfig> axes;
  runtime::AxisGroupConfig config;
};

TEST_F(GroupWords, PlacesAreInTheOrderOfTheGroupAndInTheUnitsOfItsAxes) {
  const auto move = read("move 90 0.25rev feed=6m/min");
  EXPECT_EQ(move.verb, Verb::kMove);
  EXPECT_EQ(move.move.path.kind, PathMove::Kind::kLine);
  EXPECT_FALSE(move.move.relative);
  EXPECT_DOUBLE_EQ(move.move.path.target[0], 0.09);
  EXPECT_DOUBLE_EQ(move.move.path.target[1], 90.0 * kDegree);
  EXPECT_DOUBLE_EQ(move.move.path.feed, 0.1);
  EXPECT_DOUBLE_EQ(move.move.path.tolerance, 1e-4) << "that of the group";
  const auto by = read("move-by -1 - tolerance=0.5mm");
  EXPECT_TRUE(by.move.relative);
  EXPECT_TRUE(by.stays[1]);
  EXPECT_FALSE(by.stays[0]);
  EXPECT_DOUBLE_EQ(by.move.path.target[0], -1e-3);
  EXPECT_DOUBLE_EQ(by.move.path.tolerance, 5e-4);
  EXPECT_EQ(by.move.path.feed, 0.0);
}

TEST_F(GroupWords, Arcs) {
  const auto via = read("arc 10 0 via 5 1deg");
  EXPECT_EQ(via.move.path.kind, PathMove::Kind::kArcVia);
  EXPECT_DOUBLE_EQ(via.move.path.via[0], 5e-3);
  EXPECT_DOUBLE_EQ(via.move.path.via[1], kDegree);
  const auto around = read("arc-by 10 0 center 5 0 clockwise feed=1");
  EXPECT_EQ(around.move.path.kind, PathMove::Kind::kArc);
  EXPECT_TRUE(around.move.path.clockwise);
  EXPECT_TRUE(around.move.relative);
  EXPECT_DOUBLE_EQ(around.move.path.feed, 1e-3);
}

TEST_F(GroupWords, RequestsWithoutAPlace) {
  EXPECT_EQ(read("enable").verb, Verb::kEnable);
  EXPECT_EQ(read("release-stop").verb, Verb::kReleaseStop);
  EXPECT_EQ(read("move 1 2 buffer=blending").move.buffer, motion::GroupBuffer::kBlending);
  EXPECT_EQ(read("hold").verb, Verb::kHold);
  EXPECT_DOUBLE_EQ(read("override 150%").share, 1.5);
  EXPECT_DOUBLE_EQ(read("override 0.5").share, 0.5);
  for (const auto verb : {Verb::kEnable, Verb::kDisable, Verb::kReset, Verb::kHold, Verb::kResume, Verb::kReverse,
                          Verb::kForward, Verb::kHalt, Verb::kStop, Verb::kReleaseStop}) {
    EXPECT_EQ(read(to_text(verb)).verb, verb);
  }
}

TEST_F(GroupWords, MistakesAreToldInASentence) {
  EXPECT_THAT(refusal(""), HasSubstr("group head: a request is missing; enable, disable, reset, move, "));
  EXPECT_EQ(refusal("mvoe 1 2"), "group head: unknown request \"mvoe\"; did you mean move?");
  EXPECT_EQ(refusal("move 1"), "group head: move: 2 positions are expected, of x, c; - leaves an axis where it is");
  EXPECT_EQ(refusal("move 1 2 3"), "group head: move: \"3\" was not expected");
  EXPECT_EQ(refusal("move 1 feed=2"),
            "group head: move: 2 positions are expected, of x, c; - leaves an axis where it is");
  EXPECT_THAT(refusal("move 1 2mm"), HasSubstr("position \"2mm\": axis c has no unit \"mm\" for it"));
  EXPECT_THAT(refusal("move nan 2"), HasSubstr("position \"nan\": a number is expected"));
  EXPECT_EQ(refusal("move 1 2 fede=3"), "group head: move: \"fede=\" does not belong there; did you mean feed?");
  EXPECT_EQ(refusal("move 1 2 feed=0"), "group head: move: a feed above 0 is expected");
  EXPECT_EQ(refusal("move 1 2 tolerance=-1"), "group head: move: a tolerance of 0 or more is expected");
  EXPECT_EQ(refusal("move 1 2 buffer=blend"),
            "buffer \"blend\": aborting, buffered, blending are possible; did you mean blending?");
  EXPECT_EQ(refusal("arc 1 2"),
            "group head: arc: via with a point of the arc, or center with the centre of its circle, is expected");
  EXPECT_EQ(refusal("arc 1 2 via 3"),
            "group head: arc: 2 positions are expected, of x, c; - leaves an axis where it is");
  EXPECT_EQ(refusal("arc 1 2 via 3 4 clockwise"), "group head: arc: \"clockwise\" was not expected");
  EXPECT_EQ(refusal("hold 1"), "group head: hold: \"1\" was not expected");
  EXPECT_EQ(refusal("hold feed=1"), "group head: hold: \"feed=\" does not belong there");
  EXPECT_THAT(refusal("override"), HasSubstr("a factor such as 50% is expected"));
  EXPECT_THAT(refusal("override fast"), HasSubstr("override \"fast\": a factor such as 50% or 0.5 is expected"));
}

TEST(GroupMoves, AreTheSameAtTheOtherEndOfTheSocket) {
  PathMove line;
  line.target = {0.1, -0.2};
  line.feed = 0.5;
  line.tolerance = 1e-4;
  line.dwell_s = 0.25;
  PathMove via = line;
  via.kind = PathMove::Kind::kArcVia;
  via.via = {0.05, 0.0};
  PathMove around = line;
  around.kind = PathMove::Kind::kArc;
  around.center = {0.03, 0.04};
  around.clockwise = true;
  around.first_axis = 1;
  around.second_axis = 0;
  around.feed = std::numeric_limits<double>::infinity();
  PathMove switches = line;
  switches.outputs = {{{0, 1.0}, 0.02}, {{3, -5.0}}};
  PathMove spline = line;
  spline.kind = PathMove::Kind::kSpline;
  spline.target = {};
  spline.points = {{0.01, 0.02}, {0.03, 0.01}};
  for (const auto& move : {line, via, around, switches, spline}) {
    const auto told = parse_move(nlohmann::json::parse(to_json(move, 2).dump()), 2);
    ASSERT_TRUE(told) << told.error().text;
    EXPECT_EQ(told->kind, move.kind);
    EXPECT_EQ(told->target, move.target);
    EXPECT_EQ(told->via, move.via);
    EXPECT_EQ(told->center, move.center);
    EXPECT_EQ(told->points, move.points);
    EXPECT_EQ(told->first_axis, move.first_axis);
    EXPECT_EQ(told->second_axis, move.second_axis);
    EXPECT_EQ(told->clockwise, move.clockwise);
    EXPECT_EQ(told->feed, move.feed);
    EXPECT_EQ(told->tolerance, move.tolerance);
    EXPECT_EQ(told->dwell_s, move.dwell_s);
    ASSERT_EQ(told->outputs.size(), move.outputs.size());
    for (std::size_t i = 0; i < move.outputs.size(); ++i) {
      EXPECT_EQ(told->outputs[i].change.output, move.outputs[i].change.output);
      EXPECT_EQ(told->outputs[i].change.value, move.outputs[i].change.value);
      EXPECT_EQ(told->outputs[i].at, move.outputs[i].at);
    }
  }
  for (const auto* wrong : {R"({"to": [0, 0], "outputs": 1})", R"({"to": [0, 0], "outputs": [{"value": 1}]})",
                            R"({"to": [0, 0], "outputs": [{"output": -1, "value": 1}]})",
                            R"({"to": [0, 0], "outputs": [{"output": 0, "value": "on"}]})"})
    EXPECT_FALSE(parse_move(nlohmann::json::parse(wrong), 2)) << wrong;
}

TEST_F(GroupWords, GroupsAreFoundByTheirNames) {
  const std::vector groups{config};
  EXPECT_EQ(find_group(groups, "head").value(), 0U);
  EXPECT_EQ(find_group(groups, "haed").error().text,
            "there is no group \"haed\"; the line has head; did you mean head?");
  EXPECT_THAT(find_group({}, "head").error().text, HasSubstr("the line has no groups of axes"));
}

}  // namespace
}  // namespace driveline::cli
