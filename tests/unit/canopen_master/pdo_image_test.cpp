#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "cycle_rig.hpp"
#include "driveline/motion/cia301/pdo_entry.hpp"
#include "driveline/motion/drive/axis_objects.hpp"

namespace driveline::canopen {
namespace {

using cycle_test::axes_plan;

TEST(PdoImageTest, PutsThePdosOfAllNodesOneBehindTheOther) {
  const auto image = *must(PdoImage::build(axes_plan(2)));
  EXPECT_EQ(image.outputs().size(), 2U * (3 + 4));
  EXPECT_EQ(image.inputs().size(), 2U * (6 + 3));
  ASSERT_EQ(image.rpdos().size(), 4U);
  const auto& setpoint = image.rpdos()[3];
  EXPECT_EQ(setpoint.identifier, 0x304);
  EXPECT_EQ(setpoint.length, 4);
  EXPECT_EQ(setpoint.offset, 10U);
  EXPECT_EQ(setpoint.node, 1U);
  EXPECT_EQ(image.tpdos()[1].identifier, 0x283);
  EXPECT_EQ(image.tpdos()[1].exchange, PdoExchange::kOnChange);
  EXPECT_EQ(image.place(1).output_offset, 7U);
  EXPECT_EQ(image.place(1).input_offset, 9U);
  EXPECT_EQ(image.configuration(1).outputs[1].index, 0x1601);
  EXPECT_EQ(image.configuration(1).inputs[0].index, 0x1A00);
}

// Terminals with 3 and 12 bits, a gap, and a dummy of 8 bits (CiA 301 7.4.7.1): the next PDO starts with a byte.
TEST(PdoImageTest, EntriesMayHaveAnyLengthAndTheNextPdoStartsWithAByte) {
  auto plan = axes_plan(1);
  plan.nodes[0].tpdos = {{.number = 1, .objects = {{0x2001, 1, 3}, {0, 0, 2}, {0x2002, 0, 12}}},
                         {.number = 3, .objects = {{0x0005, 0, 8}, {0x6064, 0, 32}}}};
  auto image = *must(PdoImage::build(plan));
  EXPECT_EQ(image.tpdos()[0].length, 3);
  EXPECT_EQ(image.tpdos()[1].offset, 3U);
  EXPECT_EQ(image.tpdos()[1].identifier, 0x383);
  const auto& inputs = image.configuration(0).inputs;
  EXPECT_EQ(inputs[0].bits(), 24U);
  const auto position = motion::object_offset(inputs, 0x6064, 32);
  ASSERT_TRUE(position);
  EXPECT_EQ(*position, 4U);
}

struct RefusedPlan {
  const char* what;
  void (*change)(MasterPlan&);
  const char* sentence;
};

class PdoImageRefusal : public testing::TestWithParam<RefusedPlan> {};

TEST_P(PdoImageRefusal, IsASentence) {
  auto plan = axes_plan(2);
  GetParam().change(plan);
  const auto image = PdoImage::build(plan);
  ASSERT_FALSE(image);
  EXPECT_EQ(describe(image.error(), plan), GetParam().sentence);
}

INSTANTIATE_TEST_SUITE_P(
    Plans, PdoImageRefusal,
    testing::Values(
        RefusedPlan{"TooLong",
                    [](MasterPlan& plan) {
                      plan.nodes[0].rpdos[1].objects = {{0x60C1, 1, 32}, {0x60FF, 0, 32}, {0x6060, 0, 8}};
                    },
                    "RPDO 2 of \"axis0\" maps 72 bits; a CAN frame has 64"},
        RefusedPlan{"NoMapping", [](MasterPlan& plan) { plan.nodes[1].tpdos[0].objects.clear(); },
                    "TPDO 1 of \"axis1\" maps no object"},
        RefusedPlan{"SameIdentifier", [](MasterPlan& plan) { plan.nodes[1].tpdos[1].identifier = 0x303; },
                    "RPDO 2 of \"axis0\" and TPDO 2 of \"axis1\" have the same identifier 303h"},
        RefusedPlan{"SdoIdentifier", [](MasterPlan& plan) { plan.nodes[0].tpdos[0].identifier = 0x583; },
                    "TPDO 1 of \"axis0\" has the identifier 583h, which belongs to another service"},
        RefusedPlan{"SyncIdentifier",
                    [](MasterPlan& plan) {
                      plan.sync_identifier = 0x200;
                      plan.nodes[0].rpdos[0].identifier = 0x200;
                    },
                    "RPDO 1 of \"axis0\" has the identifier 200h, which belongs to another service"},
        RefusedPlan{"EmergencyOfAnotherNode", [](MasterPlan& plan) { plan.nodes[0].tpdos[0].identifier = 0x84; },
                    "TPDO 1 of \"axis0\" has the identifier 084h, which belongs to another service"},
        RefusedPlan{"NoIdentifier", [](MasterPlan& plan) { plan.nodes[0].rpdos[1].number = 5; },
                    "RPDO 5 of \"axis0\" needs an identifier: the predefined connection set has those of PDO 1 to 4 "
                    "only"},
        RefusedPlan{"NodeTwice", [](MasterPlan& plan) { plan.nodes[1].id = 3; },
                    "\"axis0\" and \"axis1\" both have the node-ID 3"},
        RefusedPlan{"NodeOfTheMaster", [](MasterPlan& plan) { plan.master_id = 4; },
                    "\"axis1\" has the node-ID 4, which is that of the master"},
        RefusedPlan{"NodeId", [](MasterPlan& plan) { plan.nodes[1].id = 128; },
                    "\"axis1\" has the node-ID 128; there are 1 to 127"}),
    [](const auto& row) { return row.param.what; });

}  // namespace
}  // namespace driveline::canopen
