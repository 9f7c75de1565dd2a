#include "master/placement.hpp"

#include <gmock/gmock.h>

namespace driveline::ecat_master {
namespace {

using testing::ElementsAre;
using testing::IsEmpty;

constexpr std::size_t kNobody = 9999;

/// "parent:port" of every slave, in the order of the line; an empty text is the first slave.
Topology tree(std::initializer_list<const char*> parents) {
  Topology made;
  for (const std::string text : parents) {
    TopologyNode node;
    if (!text.empty()) {
      const auto parent = static_cast<std::uint16_t>(std::stoi(text));
      const auto port = static_cast<std::uint8_t>(std::stoi(text.substr(text.find(':') + 1)));
      node.parent = PortRef{parent, port};
      made.slaves[parent].children[port] = static_cast<std::uint16_t>(made.slaves.size());
    }
    made.slaves.push_back(node);
  }
  return made;
}

/// "position=slave", or "position=slave|slave?" when it is not certain.
std::vector<std::string> place(const Topology& start, const Topology& now, std::vector<std::size_t> known,
                               std::vector<std::size_t> hot = {}, std::size_t slaves = 0) {
  std::vector<bool> roaming(std::max(start.slaves.size(), slaves));
  for (const auto slave : hot) roaming[slave] = true;
  std::vector<std::optional<std::size_t>> who;
  for (const auto slave : known) who.push_back(slave == kNobody ? std::nullopt : std::optional(slave));
  std::vector<std::string> text;
  for (const auto& claim : place_newcomers({start, roaming, now, who})) {
    auto one = std::to_string(claim.position);
    for (std::size_t i = 0; i < claim.slaves.size(); ++i) {
      one += i == 0 ? '=' : '|';
      one += std::to_string(claim.slaves[i]);
    }
    if (!claim.certain) one += '?';
    text.push_back(one);
  }
  return text;
}

/// A hub with one slave at each of its ports, in the order of a frame: 3, 1, 2.
const Topology kStar = tree({"", "0:3", "0:1", "0:2"});
const Topology kLine = tree({"", "0:1", "1:1", "2:1"});

TEST(Placement, OnAStarThePortTellsWhoIsBack) {
  // Slaves 1 and 2 were off; one of them has returned.
  EXPECT_THAT(place(kStar, tree({"", "0:1", "0:2"}), {0, kNobody, 3}), ElementsAre("1=2"));
  EXPECT_THAT(place(kStar, tree({"", "0:3", "0:2"}), {0, kNobody, 3}), ElementsAre("1=1"));
  EXPECT_THAT(place(kStar, kStar, {0, kNobody, 2, 3}), ElementsAre("1=1"));
  EXPECT_THAT(place(kStar, kStar, {0, kNobody, kNobody, 3}), ElementsAre("1=1", "2=2"));
  EXPECT_THAT(place(kStar, kStar, {kNobody, kNobody, kNobody, kNobody}), ElementsAre("0=0", "1=1", "2=2", "3=3"));
}

TEST(Placement, OnALineThoseBehindAreFoundOneAfterTheOther) {
  EXPECT_THAT(place(kLine, tree({"", "0:1"}), {0, kNobody}), ElementsAre("1=1"));
  EXPECT_THAT(place(kLine, kLine, {0, kNobody, kNobody, 3}), ElementsAre("1=1", "2=2"));
}

TEST(Placement, BehindABranchThePathToItTells) {
  const auto start = tree({"", "0:1", "1:3", "2:1", "1:1", "4:1"});
  // The branch 2, 3 and the end of the trunk 4, 5 were off; only the trunk has returned.
  EXPECT_THAT(place(start, tree({"", "0:1", "1:1", "2:1"}), {0, 1, kNobody, kNobody}), ElementsAre("2=4", "3=5"));
  EXPECT_THAT(place(start, tree({"", "0:1", "1:3"}), {0, 1, kNobody}), ElementsAre("2=2"));
}

TEST(Placement, WhereNobodyHungNobodyIsFound) {
  // Slave 1 is off, and another one is plugged in behind slave 3.
  EXPECT_THAT(place(kStar, tree({"", "0:1", "0:2", "2:1"}), {0, 2, 3, kNobody}), IsEmpty());
  // No slave is missing.
  EXPECT_THAT(place(kStar, tree({"", "0:3", "0:1", "0:2", "3:1"}), {0, 1, 2, 3, kNobody}), IsEmpty());
}

TEST(Placement, WhoHasBeenMovedLeavesNoPlace) {
  // Slave 1 has been plugged in at the position of slave 2, which is off.
  EXPECT_THAT(place(kStar, tree({"", "0:1", "0:2"}), {0, 1, 3}), IsEmpty());
}

TEST(Placement, RoamingSlavesDoNotShiftTheOthers) {
  // Slave 1 may move; slave 2 was behind it, and is on the hub while slave 1 is missing.
  const auto start = tree({"", "0:1", "1:1", "0:2"});
  EXPECT_THAT(place(start, tree({"", "0:1", "0:2"}), {0, kNobody, 3}, {1}), ElementsAre("1=2"));
  EXPECT_THAT(place(start, start, {0, 1, kNobody, 3}, {1}), ElementsAre("2=2"));
  EXPECT_THAT(place(start, start, {0, kNobody, kNobody, 3}, {1}), ElementsAre("1=2"))
      << "the roaming one is not known by its place, and who hangs on it is found when it is";
  // It was missing at the start, and is plugged in between.
  EXPECT_THAT(place(tree({"", "0:1"}), tree({"", "0:1", "1:1"}), {0, 2, kNobody}, {2}, 3), ElementsAre("2=1"));
}

TEST(Placement, TwoBranchesOfARoamingSlaveMayBeEither) {
  const auto start = tree({"", "0:1", "1:3", "1:1"});
  EXPECT_THAT(place(start, tree({"", "0:1", "1:3"}), {0, 1, kNobody}, {1}), ElementsAre("2=2|3?"));
  EXPECT_THAT(place(start, start, {0, 1, kNobody, kNobody}, {1}), ElementsAre("2=2", "3=3"));
  EXPECT_THAT(place(start, start, {0, 1, 2, kNobody}, {1}), ElementsAre("3=3"));
}

TEST(Placement, WithoutWiringTheNeighboursMustTell) {
  const Topology unknown;
  EXPECT_THAT(place(unknown, unknown, {0, kNobody, 3}, {}, 4), ElementsAre("1=1|2?"));
  EXPECT_THAT(place(unknown, unknown, {0, kNobody, kNobody, 3}, {}, 4), ElementsAre("1=1", "2=2"));
  EXPECT_THAT(place(unknown, unknown, {0, kNobody, 2, 3}, {}, 4), ElementsAre("1=1"));
  EXPECT_THAT(place(unknown, unknown, {0, kNobody, kNobody, 2, 3}, {}, 4), ElementsAre("1=1?", "2=1?"));
  EXPECT_THAT(place(unknown, unknown, {kNobody}, {}, 4), ElementsAre("0=0|1|2|3?"));
  // The wiring is known for only one of the two.
  EXPECT_THAT(place(kStar, unknown, {0, kNobody, 3}), ElementsAre("1=1|2?"));
}

}  // namespace
}  // namespace driveline::ecat_master
