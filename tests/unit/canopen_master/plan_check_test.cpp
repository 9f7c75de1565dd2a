#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <functional>

#include "driveline/canopen_master/plan_check.hpp"

namespace driveline::canopen {
namespace {

using namespace std::chrono_literals;

/// A change to a good plan, and the sentence.
struct PlanCase {
  const char* name;
  std::function<void(MasterPlan&)> change;
  const char* sentence;
};

class PlanCheckTest : public ::testing::TestWithParam<PlanCase> {
 protected:
  static MasterPlan plan() {
    MasterPlan plan;
    plan.master_heartbeat = 20ms;
    for (const auto id : {std::uint8_t{10}, std::uint8_t{11}}) {
      NodePlan node{.name = "n", .id = id};
      node.rpdos.push_back({.objects = {{0x60C1, 1, 32}}});
      node.tpdos.push_back({.objects = {{0x6041, 0, 16}}});
      node.error_control.heartbeat = 100ms;
      node.error_control.master_tolerance = 70ms;
      plan.nodes.push_back(node);
    }
    return plan;
  }
};

TEST_P(PlanCheckTest, IsASentence) {
  auto bad = plan();
  ASSERT_TRUE(check(bad).empty());
  GetParam().change(bad);
  const auto errors = check(bad);
  ASSERT_EQ(errors.size(), 1U);
  EXPECT_EQ(errors[0].kind, NodeErrorKind::kBadPlan);
  EXPECT_EQ(errors[0].node, 1U);
  const auto id = std::to_string(bad.nodes[1].id);
  EXPECT_EQ(describe(errors[0], "n"), "node " + id + " (n): " + GetParam().sentence);
}

INSTANTIATE_TEST_SUITE_P(
    Faults, PlanCheckTest,
    ::testing::Values(
        PlanCase{"NodeId", [](MasterPlan& bad) { bad.nodes[1] = {.name = "n", .id = 128}; },
                 "128 is no node-ID: 1 to 127"},
        PlanCase{"NodeIdTwice", [](MasterPlan& bad) { bad.nodes[1] = {.name = "n", .id = 10}; },
                 "node-ID 10 is there twice"},
        PlanCase{"NodeIdOfTheMaster", [](MasterPlan& bad) { bad.nodes[1].id = bad.master_id; },
                 "node-ID 127 is there twice"},
        PlanCase{"BothControls", [](MasterPlan& bad) { bad.nodes[1].error_control.guard_time = 50ms; },
                 "heartbeat and node guarding exclude one another"},
        PlanCase{"LongTime", [](MasterPlan& bad) { bad.nodes[1].error_control.heartbeat = 70s; },
                 "a time of 70000 ms for error control: the objects hold up to 65535 ms"},
        PlanCase{"Impatient", [](MasterPlan& bad) { bad.nodes[1].error_control.tolerance = 90ms; },
                 "a tolerance of 90 ms is not longer than the heartbeat of 100 ms"},
        PlanCase{"SlowMaster", [](MasterPlan& bad) { bad.nodes[1].error_control.master_tolerance = 15ms; },
                 "the node expects a heartbeat of the master within 15 ms, and it sends one every 20 ms"},
        PlanCase{"PdoNumber",
                 [](MasterPlan& bad) {
                   bad.nodes[1].rpdos[0].number = 513;
                   bad.nodes[1].rpdos[0].identifier = 0x3F1;
                 },
                 "RPDO 513: the number is not 1 to 512, or there twice"},
        PlanCase{"PdoTwice", [](MasterPlan& bad) { bad.nodes[1].tpdos.push_back({.number = 1, .identifier = 0x3F1}); },
                 "TPDO 1: the number is not 1 to 512, or there twice"},
        PlanCase{"NoIdentifier", [](MasterPlan& bad) { bad.nodes[1].tpdos[0].number = 5; },
                 "TPDO 5 has no identifier: only PDO 1 to 4 have one of their own"},
        PlanCase{"IdentifierOfAnother", [](MasterPlan& bad) { bad.nodes[1].tpdos[0].identifier = 0x18A; },
                 "TPDO 1: identifier 0x18A is used by another message, or reserved"},
        PlanCase{"IdentifierOfSdo", [](MasterPlan& bad) { bad.nodes[1].tpdos[0].identifier = 0x58A; },
                 "TPDO 1: identifier 0x58A is used by another message, or reserved"},
        PlanCase{"IdentifierOfSync", [](MasterPlan& bad) { bad.nodes[1].rpdos[0].identifier = 0x80; },
                 "RPDO 1: identifier 0x80 is used by another message, or reserved"},
        PlanCase{"IdentifierOfEmcy", [](MasterPlan& bad) { bad.nodes[1].rpdos[0].identifier = 0x8A; },
                 "RPDO 1: identifier 0x8A is used by another message, or reserved"},
        PlanCase{"TooLong",
                 [](MasterPlan& bad) {
                   bad.nodes[1].tpdos[0].objects.assign(3, {0x6064, 0, 32});
                 },
                 "TPDO 1 has 96 bits: 64 fit"},
        PlanCase{"Transmission", [](MasterPlan& bad) { bad.nodes[1].rpdos[0].transmission = 250; },
                 "RPDO 1: transmission type 250 is reserved: 0 to 240, 254, 255"},
        PlanCase{"CompleteAccess",
                 [](MasterPlan& bad) {
                   bad.nodes[1].startup_sdos.push_back({0x2000, 0, {}, true});
                 },
                 "start-up SDO 0x2000:00: all sub-indices at once are possible on EtherCAT only"}),
    [](const auto& one) { return std::string(one.param.name); });

TEST(PlanCheck, AMasterWithoutHeartbeatIsNotExpectedToHaveOne) {
  MasterPlan plan;
  plan.nodes.push_back({.name = "n", .id = 3});
  plan.nodes[0].error_control.master_tolerance = 100ms;
  const auto errors = check(plan);
  ASSERT_EQ(errors.size(), 1U);
  EXPECT_EQ(describe(errors[0], "n"),
            "node 3 (n): the node expects a heartbeat of the master within 100 ms, and it sends none");
}

}  // namespace
}  // namespace driveline::canopen
