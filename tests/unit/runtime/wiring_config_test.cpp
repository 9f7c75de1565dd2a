// [wiring] of a line description: presets, cables, and errors.
#include <gmock/gmock.h>

#include "driveline/runtime/config/line_config.hpp"
#include "driveline/slaves/line/frame_path.hpp"
#include "support/must.hpp"

namespace driveline::runtime {
namespace {

using namespace std::chrono_literals;
using slaves::MasterPort;
using slaves::PortId;
using slaves::Wiring;

/// `count` slaves a, b, c ... and the rest of the file, which starts at line 2 * count + 1.
std::string line_of(std::size_t count, const std::string& rest) {
  std::string text;
  for (std::size_t i = 0; i < count; ++i)
    text += std::string("[[slave]]\nname = \"") + static_cast<char>('a' + i) + "\"\n";
  return text + rest;
}

LineConfig parsed(const std::string& text) {
  auto config = parse_line_config(text, "line.toml");
  if (!config) throw std::runtime_error(describe(config.error()));
  return *config;
}

std::optional<PortId> other_end(const Wiring& wiring, PortId port) {
  const auto& end = wiring.at(port);
  if (end.kind != Wiring::End::Kind::kSlave) return std::nullopt;
  return end.slave;
}

TEST(WiringConfig, APlainLineWithoutAWord) {
  const auto config = parsed(line_of(3, ""));
  ASSERT_TRUE(config.wiring);
  EXPECT_EQ(config.wiring->master(MasterPort::kPrimary), (PortId{0, 0}));
  EXPECT_FALSE(config.wiring->master(MasterPort::kSecondary));
  EXPECT_EQ(other_end(*config.wiring, {0, 1}), (PortId{1, 0}));
  EXPECT_EQ(other_end(*config.wiring, {1, 1}), (PortId{2, 0}));
  EXPECT_EQ(config.wiring->at({0, 1}).delay, 5ns) << "one metre";
}

TEST(WiringConfig, ARingLeadsBack) {
  const auto config = parsed(line_of(2, "[wiring]\npreset = \"ring\"\ncable_m = 20\n"));
  EXPECT_EQ(config.wiring->master(MasterPort::kSecondary), (PortId{1, 1}));
  EXPECT_EQ(config.wiring->at({0, 1}).delay, 100ns);
}

TEST(WiringConfig, AStarHasArmsInTheOrderOfTheFrame) {
  const auto config = parsed(line_of(8, "[wiring]\npreset = \"star\"\n"));
  const auto& wiring = *config.wiring;
  EXPECT_EQ(other_end(wiring, {0, 3}), (PortId{1, 0}));
  EXPECT_EQ(other_end(wiring, {1, 1}), (PortId{2, 0}));
  EXPECT_EQ(other_end(wiring, {2, 1}), (PortId{3, 0})) << "seven slaves: arms of 3, 2 and 2";
  EXPECT_EQ(other_end(wiring, {0, 1}), (PortId{4, 0}));
  EXPECT_EQ(other_end(wiring, {0, 2}), (PortId{6, 0}));
  EXPECT_EQ(other_end(wiring, {6, 1}), (PortId{7, 0}));
  const auto two = parsed(line_of(3, "[wiring]\npreset = \"star\"\narms = 2\n"));
  EXPECT_EQ(other_end(*two.wiring, {0, 3}), (PortId{1, 0}));
  EXPECT_EQ(other_end(*two.wiring, {0, 1}), (PortId{2, 0}));
  EXPECT_NO_THROW(parsed(line_of(1, "[wiring]\npreset = \"star\"\n"))) << "a junction with nothing at it";
}

TEST(WiringConfig, ABranchHangsAtPort3OfItsJunction) {
  const auto config = parsed(line_of(6, "[wiring]\npreset = \"branch\"\njunction = \"b\"\nbranch_slaves = 2\n"));
  const auto& wiring = *config.wiring;
  EXPECT_EQ(other_end(wiring, {0, 1}), (PortId{1, 0}));
  EXPECT_EQ(other_end(wiring, {1, 3}), (PortId{2, 0}));
  EXPECT_EQ(other_end(wiring, {2, 1}), (PortId{3, 0}));
  EXPECT_EQ(other_end(wiring, {3, 1}), std::nullopt) << "the branch ends";
  EXPECT_EQ(other_end(wiring, {1, 1}), (PortId{4, 0}));
  EXPECT_EQ(other_end(wiring, {4, 1}), (PortId{5, 0}));
}

TEST(WiringConfig, CablesOfAPresetHaveTheirOwnLength) {
  const auto config = parsed(line_of(3, R"([wiring]
preset = "ring"
[[wiring.cable]]
from = "a:1"
to = "b:0"
length_m = 40
[[wiring.cable]]
from = "master"
to = "a:0"
length_m = 3
[[wiring.cable]]
from = "c:1"
to = "master2"
length_m = 7
)"));
  EXPECT_EQ(config.wiring->at({0, 1}).delay, 200ns);
  EXPECT_EQ(config.wiring->at({1, 0}).delay, 200ns) << "both ends";
  EXPECT_EQ(config.wiring->at({1, 1}).delay, 5ns);
  EXPECT_EQ(config.wiring->at({0, 0}).delay, 15ns);
  EXPECT_EQ(config.wiring->at({2, 1}).delay, 35ns);
}

TEST(WiringConfig, CustomCablesAreAllThereAre) {
  const auto config = parsed(line_of(4, R"([wiring]
preset = "custom"
[[wiring.cable]]
from = "master"
to = "a:0"
[[wiring.cable]]
from = "a:3"
to = "b:0"
length_m = 10
[[wiring.cable]]
from = "a:1"
to = "c:0"
[[wiring.cable]]
from = "a:2"
to = "d:0"
)"));
  EXPECT_EQ(other_end(*config.wiring, {0, 3}), (PortId{1, 0}));
  EXPECT_EQ(config.wiring->at({0, 3}).delay, 50ns);
  EXPECT_EQ(other_end(*config.wiring, {0, 2}), (PortId{3, 0}));
}

TEST(WiringConfig, DelaysOfASlave) {
  const auto config = parsed(line_of(2, "processing_ns = 820\nforwarding_ns = 310\n"));
  EXPECT_EQ(config.slaves[0].delays.processing, 500ns);
  EXPECT_EQ(config.slaves[1].delays.processing, 820ns);
  EXPECT_EQ(config.slaves[1].delays.forwarding, 310ns);
}

TEST(WiringConfig, TheRingOfTheExamples) {
  const auto config = load_line_config(DRIVELINE_EXAMPLES_DIR "/ring4.toml");
  ASSERT_TRUE(config) << describe(config.error());
  EXPECT_EQ(config->wiring->master(MasterPort::kSecondary), (PortId{3, 1}));
  EXPECT_EQ(config->wiring->at({1, 1}).delay, 175ns);
  ASSERT_EQ(config->faults.size(), 3U);
  EXPECT_EQ(config->faults[1].fault.kind, slaves::FaultKind::kCableBreak);
  EXPECT_EQ(config->faults[1].fault.port, 1);
}

struct Wrong {
  std::string rest;
  std::string sentence;
};

void PrintTo(const Wrong& wrong, std::ostream* stream) {
  *stream << wrong.sentence;
}

class WiringConfigError : public testing::TestWithParam<Wrong> {};

TEST_P(WiringConfigError, IsOneSentenceWithFileAndLine) {
  EXPECT_EQ(failure_text(parse_line_config(line_of(3, GetParam().rest), "line.toml")),
            "line.toml" + GetParam().sentence);
}

const std::string kCustom = "[wiring]\npreset = \"custom\"\n";
std::string cable(const std::string& from, const std::string& to) {
  return "[[wiring.cable]]\nfrom = \"" + from + "\"\nto = \"" + to + "\"\n";
}

INSTANTIATE_TEST_SUITE_P(
    Sentences, WiringConfigError,
    testing::Values(
        Wrong{"[wiring]\npreset = \"tree\"\n",
              ":8: [wiring] preset: is \"tree\", one of \"line\", \"ring\", \"star\", \"branch\", \"custom\" is "
              "expected"},
        Wrong{"[wiring]\narms = 2\n", ":8: [wiring] arms: unknown key, expected one of: cable, cable_m, preset"},
        Wrong{"[wiring]\ncable_m = -1\n", ":8: [wiring] cable_m: is -1, 0 to 100000 is expected"},
        Wrong{"[wiring]\npreset = \"star\"\narms = 4\n", ":9: [wiring] arms: is 4, 1 to 3 is expected"},
        Wrong{"[wiring]\npreset = \"branch\"\n", ":7: [wiring] junction: is missing, a string is expected"},
        Wrong{"[wiring]\npreset = \"branch\"\njunction = \"z\"\n",
              ":9: [wiring] junction: there is no [[slave]] named \"z\""},
        Wrong{"[wiring]\npreset = \"branch\"\njunction = \"a\"\nbranch_slaves = 3\n",
              ":10: [wiring] branch_slaves: is 3, 1 to 2 is expected"},
        Wrong{"[wiring]\npreset = \"branch\"\njunction = \"c\"\nbranch_slaves = 1\n",
              ":9: [wiring] junction: \"c\" is the last [[slave]], nothing can branch off"},
        Wrong{"[wiring]\n" + cable("a:2", "b:0"),
              ":9: [wiring.cable 1] from: the preset has no such cable; preset = \"custom\" takes all cables from the "
              "file"},
        Wrong{"[wiring]\n" + cable("a:4", "b:0"),
              ":9: [wiring.cable 1] from: is \"a:4\", the name of a [[slave]] and its port (\"a:1\"), \"master\" or "
              "\"master2\" is expected"},
        Wrong{"[wiring]\n" + cable("a:1", "b"),
              ":10: [wiring.cable 1] to: is \"b\", the name of a [[slave]] and its port (\"a:1\"), \"master\" or "
              "\"master2\" is expected"},
        Wrong{kCustom, ":7: [wiring]: no cable leads to \"master\": connect port 0 of the first slave to it"},
        Wrong{kCustom + cable("master", "a:0") + cable("a:1", "b:0") + cable("a:1", "c:0"),
              ":16: [wiring.cable 3] from: cannot be connected: one of the two ends is taken already, or both are the "
              "same"},
        Wrong{kCustom + cable("master", "a:0") + cable("a:1", "b:0") + cable("a:3", "c:0"),
              ":7: [wiring]: the frame meets \"c\" where the file has \"b\": list the [[slave]] tables in the order of "
              "the frame, which leaves a slave at port 3 first, then 1, then 2"},
        Wrong{kCustom + cable("master", "a:0") + cable("a:1", "b:0"),
              ":7: [wiring]: the frame never reaches \"c\": connect its port 0 to a slave upstream of it"},
        Wrong{"processing_ns = -5\n", ":7: [slave 3] processing_ns: is -5, 0 to 1000000 is expected"}));

}  // namespace
}  // namespace driveline::runtime
