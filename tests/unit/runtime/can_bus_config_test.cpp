// Line descriptions with [bus] type = "can": what they say, and every refusal with the whole sentence for its author.
#include <gmock/gmock.h>

#include <string>

#include "driveline/runtime/can/master_plan.hpp"
#include "driveline/runtime/config/line_config.hpp"
#include "support/must.hpp"

namespace driveline::runtime {
namespace {

using std::chrono::milliseconds;
using std::chrono::nanoseconds;

LineConfig parsed_line(std::string_view text) {
  return *must(parse_line_config(text, "plant/line.toml"));
}

constexpr std::string_view kPress = R"([line]
name = "press"
[bus]
type = "can"
bit_rate = 500000
sync_ms = 4
interface = "slcan:tcp:127.0.0.1:29550"
length_m = 12.5
terminators = "first"
seed = 7
max_lost_ms = 40
[master]
node = 100
heartbeat_ms = 50
[[slave]]
name = "x"
node = 3
dip = 5
vendor_id = 0x12
product_code = 0x34
revision = 0x10002
serial = 4711
heartbeat_ms = 80
optional = true
timeouts = { sdo_ms = 250, boot_up_ms = 4000, start_ms = 700 }
[[slave.sdo]]
index = 0x6083
type = "uint32"
value = 1000
[[slave.pdo]]
index = 0x1601
entries = ["0x6040:0:16", "0x60C1:1:32"]
[[slave.pdo]]
index = 0x1A04
identifier = 0x2A0
transmission = 254
entries = ["0x6041:0:16", "0x6064:0:32"]
inhibit_us = 1500
event_ms = 90
[[slave]]
name = "y"
guard_ms = 60
model = "servoone"
[[axis]]
name = "y"
)";

TEST(CanBusConfig, Bus) {
  const auto config = parsed_line(kPress);
  ASSERT_TRUE(config.can);
  EXPECT_EQ(config.name, "press");
  EXPECT_EQ(config.can->bit_rate, 500'000U);
  EXPECT_EQ(config.period, milliseconds{4});
  EXPECT_EQ(config.interface, "slcan:tcp:127.0.0.1:29550");
  EXPECT_EQ(config.can->wiring.length_m, 12.5);
  EXPECT_TRUE(config.can->wiring.first_terminated);
  EXPECT_FALSE(config.can->wiring.last_terminated);
  EXPECT_EQ(config.can->seed, 7U);
  EXPECT_EQ(config.max_lost_cycles, 10U);
  EXPECT_EQ(config.can->master_node, 100);
  EXPECT_EQ(config.can->master_heartbeat, milliseconds{50});
}

TEST(CanBusConfig, Slave) {
  const auto config = parsed_line(kPress);
  const auto& x = config.slaves.at(0);
  EXPECT_EQ(x.can.node, 3);
  EXPECT_EQ(x.can.dip, 5);
  EXPECT_EQ(x.can.revision, 0x10002U);
  EXPECT_EQ(x.can.serial_number, 4711U);
  EXPECT_TRUE(x.can.optional);
  EXPECT_EQ(x.can.timeouts.sdo, milliseconds{250});
  EXPECT_EQ(x.can.timeouts.boot_up, milliseconds{4000});
  EXPECT_EQ(x.can.timeouts.start, milliseconds{700});
  ASSERT_TRUE(x.can.pdos);
  const auto& rpdo = x.can.pdos->rpdos.at(0);
  EXPECT_EQ(rpdo.number, 2);
  EXPECT_EQ(rpdo.exchange, canopen::PdoExchange::kWithSync);
  EXPECT_THAT(rpdo.objects,
              testing::ElementsAre(motion::MappedObject{0x6040, 0, 16}, motion::MappedObject{0x60C1, 1, 32}));
  const auto& tpdo = x.can.pdos->tpdos.at(0);
  EXPECT_EQ(tpdo.number, 5);
  EXPECT_EQ(tpdo.identifier, 0x2A0);
  EXPECT_EQ(tpdo.exchange, canopen::PdoExchange::kOnChange);
  EXPECT_EQ(tpdo.inhibit_100us, 15);
  EXPECT_EQ(tpdo.event_ms, 90);
}

/// The second slave has the node-ID of its place, and only one kind of error control.
TEST(CanBusConfig, WhatIsLeftOutHasItsDefault) {
  const auto config = parsed_line(kPress);
  const auto& y = config.slaves.at(1);
  EXPECT_EQ(y.can.node, 2);
  EXPECT_EQ(y.can.guard_time, milliseconds{60});
  EXPECT_EQ(y.can.heartbeat, milliseconds{0});
  const auto plain = parsed_line("[bus]\ntype = \"can\"\n[[slave]]\nname = \"x\"\n");
  EXPECT_EQ(plain.period, milliseconds{2});
  EXPECT_EQ(plain.can->bit_rate, 1'000'000U);
  EXPECT_EQ(plain.can->master_node, 127);
  EXPECT_FALSE(plain.interface);
  EXPECT_EQ(plain.slaves.at(0).can.node, 1);
  EXPECT_EQ(plain.slaves.at(0).can.heartbeat, milliseconds{100});
}

/// Lines that were described for `simulate` alone may have any node-ID.
TEST(CanBusConfig, TheMasterHasTheHighestNodeIdThatIsFree) {
  const std::string last = "[bus]\ntype = \"can\"\n[[slave]]\nname = \"x\"\nnode = 127\n";
  EXPECT_EQ(parsed_line(last).can->master_node, 126);
  EXPECT_EQ(parsed_line(last + "[[slave]]\nname = \"y\"\nnode = 126\n").can->master_node, 125);
}

/// An axis whose drive plans its motions has targets instead of setpoints; its PDOs do not go with SYNC.
TEST(CanBusConfig, AnAxisInAProfileModeHasThePdosOfItsTargets) {
  const auto config = parsed_line(
      "[bus]\ntype = \"can\"\n[[slave]]\nname = \"x\"\n[[slave]]\nname = \"y\"\n[[axis]]\nname = \"x\"\nmode = "
      "\"pp\"\n[[axis]]\nname = \"y\"\nmode = \"pv\"\n");
  EXPECT_EQ(config.axes.at(0).mode, motion::cia402::Mode::kProfilePosition);
  EXPECT_EQ(config.axes.at(1).mode, motion::cia402::Mode::kProfileVelocity);
  const auto plan = make_master_plan(config);
  const auto& x = plan.nodes.at(0).rpdos;
  ASSERT_EQ(x.size(), 3U);
  EXPECT_THAT(x[1].objects,
              testing::ElementsAre(motion::MappedObject{0x607A, 0, 32}, motion::MappedObject{0x6081, 0, 32}));
  EXPECT_THAT(x[2].objects, testing::ElementsAre(motion::MappedObject{0x60FF, 0, 32}));
  for (const auto& rpdo : x) EXPECT_EQ(rpdo.exchange, canopen::PdoExchange::kOnChange) << rpdo.number;
  EXPECT_EQ(plan.nodes[0].tpdos.at(0).exchange, canopen::PdoExchange::kWithSync);
  const auto& y = plan.nodes.at(1).rpdos;
  ASSERT_EQ(y.size(), 2U);
  EXPECT_THAT(y[1].objects, testing::ElementsAre(motion::MappedObject{0x60FF, 0, 32}));
}

TEST(CanBusConfig, AxesFollowInInterpolatedPosition) {
  EXPECT_EQ(parsed_line(kPress).axes.at(0).mode, motion::cia402::Mode::kInterpolatedPosition);
}

/// [line] cycle_us is the period of SYNC where sync_ms is left out, and may repeat it.
TEST(CanBusConfig, TheCycleIsThePeriodOfSync) {
  EXPECT_EQ(parsed_line("[line]\ncycle_us = 4000\n[bus]\ntype = \"can\"\n[[slave]]\nname = \"x\"\n").period,
            milliseconds{4});
  EXPECT_EQ(
      parsed_line("[line]\ncycle_us = 5000\n[bus]\ntype = \"can\"\nsync_ms = 5\n[[slave]]\nname = \"x\"\n").period,
      milliseconds{5});
}

TEST(CanBusConfig, BecomesThePlanOfTheMaster) {
  const auto plan = make_master_plan(parsed_line(kPress));
  EXPECT_EQ(plan.bit_rate, 500'000U);
  EXPECT_EQ(plan.period, milliseconds{4});
  EXPECT_EQ(plan.master_id, 100);
  EXPECT_EQ(plan.master_heartbeat, milliseconds{50});
  ASSERT_EQ(plan.nodes.size(), 2U);
  const auto& x = plan.nodes[0];
  EXPECT_EQ(x.name, "x");
  EXPECT_EQ(x.id, 3);
  EXPECT_EQ(x.vendor_id, 0x12U);
  EXPECT_EQ(x.product_code, 0x34U);
  EXPECT_EQ(x.serial_number, 4711U);
  EXPECT_TRUE(x.optional);
  EXPECT_EQ(x.error_control.heartbeat, milliseconds{80});
  EXPECT_EQ(x.error_control.master_tolerance, milliseconds{150});
  EXPECT_EQ(x.rpdos.size(), 1U);
  EXPECT_EQ(x.startup_sdos.back().index, 0x6083);
  // The ServoOne has no consumer of heartbeats: it watches SYNC.
  const auto& y = plan.nodes[1];
  EXPECT_EQ(y.error_control.master_tolerance, milliseconds{0});
  EXPECT_EQ(y.error_control.guard_time, milliseconds{60});
  const auto watch = [](const motion::StartupSdo& sdo) { return sdo.index == 0x280E; };
  EXPECT_TRUE(std::any_of(y.startup_sdos.begin(), y.startup_sdos.end(), watch));
  const auto period = [](const motion::StartupSdo& sdo) { return sdo.index == 0x60C2; };
  EXPECT_TRUE(std::any_of(y.startup_sdos.begin(), y.startup_sdos.end(), period));
  ASSERT_EQ(y.rpdos.size(), 2U);
  EXPECT_EQ(y.tpdos.size(), 2U);
}

/// A slave without axis and [[slave.pdo]] exchanges nothing.
TEST(CanBusConfig, ADeviceWithoutAxisKeepsItsPdos) {
  const auto plan = make_master_plan(parsed_line("[bus]\ntype = \"can\"\n[[slave]]\nname = \"x\"\n"));
  EXPECT_TRUE(plan.nodes.at(0).rpdos.empty());
  EXPECT_TRUE(plan.nodes.at(0).tpdos.empty());
}

struct WrongCanLine {
  std::string text;
  std::string sentence;
};

void PrintTo(const WrongCanLine& wrong, std::ostream* stream) {
  *stream << wrong.sentence;
}

class CanBusConfigError : public testing::TestWithParam<WrongCanLine> {};

TEST_P(CanBusConfigError, IsOneSentenceWithFileAndLine) {
  EXPECT_EQ(failure_text(parse_line_config(GetParam().text, "plant/line.toml")),
            "plant/line.toml" + GetParam().sentence);
}

/// `rest` starts at line 3, inside [bus].
std::string can_bus(const std::string& rest) {
  return "[bus]\ntype = \"can\"\n" + rest + "[[slave]]\nname = \"x\"\n";
}
/// `rest` starts at line 5, inside the slave.
std::string can_slave(const std::string& rest) {
  return "[bus]\ntype = \"can\"\n[[slave]]\nname = \"x\"\n" + rest;
}
/// `rest` starts at line 7, inside the axis.
std::string can_axis(const std::string& rest) {
  return can_slave("[[axis]]\nname = \"x\"\n" + rest);
}

INSTANTIATE_TEST_SUITE_P(
    Bus, CanBusConfigError,
    testing::Values(
        WrongCanLine{can_bus("bit_rate = 300000\n"),
                     ":3: [bus] bit_rate: is 300000, a rate whose bits are whole nanoseconds is expected"},
        WrongCanLine{can_bus("bit_rate = 2000000\n"), ":3: [bus] bit_rate: is 2000000, 10000 to 1000000 is expected"},
        WrongCanLine{can_bus("sync_ms = 0.1\n"), ":3: [bus] sync_ms: is 0.1, 0.25 to 100 is expected"},
        WrongCanLine{can_bus("sync_ms = 1.0005\n"),
                     ":3: [bus] sync_ms: must be a whole number of microseconds, as 1006h has them"},
        WrongCanLine{"[line]\ncycle_us = 125\n[bus]\ntype = \"can\"\n[[slave]]\nname = \"x\"\n",
                     ":2: [line] cycle_us: is 125, 250 to 100000 is expected"},
        WrongCanLine{
            "[line]\ncycle_us = 1000\n[bus]\ntype = \"can\"\nsync_ms = 2\n[[slave]]\nname = \"x\"\n",
            ":5: [bus] sync_ms: is 2 ms, but [line] cycle_us is 1000: the cycle of a CAN line is its SYNC, and "
            "one period is expected"},
        WrongCanLine{can_bus("interface = \"a_name_of_sixteen\"\n"),
                     ":3: [bus] interface: must have 1 to 15 characters, or name a protocol, as slcan:tcp:HOST:PORT"},
        WrongCanLine{can_bus("interface2 = \"can1\"\n"),
                     ":3: [bus] interface2: is for lines of EtherCAT: a CAN bus is no ring"},
        WrongCanLine{can_bus("esi = [\"x.xml\"]\n"),
                     ":3: [bus] esi: is for lines of EtherCAT: nodes have an EDS: model = \"eds\" in a [[slave]] is "
                     "expected"},
        WrongCanLine{can_bus("port = \"xdp\"\n"),
                     ":3: [bus] port: is for lines of EtherCAT: interface names the protocol of a CAN port, as "
                     "slcan:tcp:HOST:PORT"},
        WrongCanLine{can_bus("launch_ahead_us = 50\n"),
                     ":3: [bus] launch_ahead_us: is for lines of EtherCAT: no CAN port sends at a time that is given"},
        WrongCanLine{can_bus("acyclic_bytes = 500\n"),
                     ":3: [bus] acyclic_bytes: is for lines of EtherCAT: what SYNC and PDOs leave free of the bus is "
                     "for SDO"},
        WrongCanLine{can_bus("[dc]\nmode = \"master_follows\"\n"),
                     ":3: dc: is for lines of EtherCAT: a CAN bus has no distributed clocks; SYNC is the clock of its "
                     "nodes"},
        WrongCanLine{can_bus("[wiring]\n"),
                     ":3: wiring: is for lines of EtherCAT: a CAN bus is one cable: [bus] length_m and terminators are "
                     "expected"},
        WrongCanLine{can_bus("[eoe]\n"), ":3: eoe: is for lines of EtherCAT: CANopen has no Ethernet over the bus"},
        WrongCanLine{can_bus("[gateway]\n"), ":3: gateway: is for lines of EtherCAT: CANopen has no mailboxes"},
        WrongCanLine{can_bus("[[group]]\nname = \"slow\"\n"),
                     ":3: group: is for lines of EtherCAT: PDOs of all nodes follow SYNC; [[slave.pdo]] exchange and "
                     "transmission are expected"},
        WrongCanLine{
            can_bus("[process_data]\nlayout = \"lrd_lwr\"\n"),
            ":3: process_data: is for lines of EtherCAT: PDOs on a CAN bus have identifiers and no layout in a "
            "frame"},
        WrongCanLine{can_bus("[master]\nnode = 200\n"), ":4: [master] node: is 200, 1 to 127 is expected"},
        WrongCanLine{can_bus("[master]\nname = \"m\"\n"),
                     ":4: [master] name: unknown key, expected one of: heartbeat_ms, node"}));

INSTANTIATE_TEST_SUITE_P(
    Slave, CanBusConfigError,
    testing::Values(
        WrongCanLine{can_slave("node = 0\n"), ":5: [slave 1] node: is 0, 1 to 127 is expected"},
        WrongCanLine{can_slave("node = 3\n[[slave]]\nname = \"y\"\nnode = 3\n"),
                     ":8: [slave 2] node: is 3, as that of \"x\": each node-ID is for one slave"},
        WrongCanLine{can_slave("node = 2\n[[slave]]\nname = \"y\"\n"),
                     ":6: [slave 2] node: is 2, as that of \"x\": each node-ID is for one slave"},
        WrongCanLine{can_slave("node = 99\n[master]\nnode = 99\n"),
                     ":5: [slave 1] node: is 99, the node-ID of the master: another one is expected here or in "
                     "[master] node"},
        WrongCanLine{can_slave("heartbeat_ms = 100\nguard_ms = 100\n"),
                     ":6: [slave 1] guard_ms: is set together with heartbeat_ms: a node has one of both (CiA 301 "
                     "7.2.8.3)"},
        WrongCanLine{can_slave("model = \"generic\"\nesi = \"io.xml\"\n"),
                     ":6: [slave 1] esi: is for lines of EtherCAT: a node has an EDS: model = \"eds\" is expected"},
        WrongCanLine{can_slave("alias = 7\n"),
                     ":5: [slave 1] alias: is for lines of EtherCAT: a node is found by its node-ID: node is expected"},
        WrongCanLine{can_slave("hot_connect = true\n"),
                     ":5: [slave 1] hot_connect: is for lines of EtherCAT: a node that may be missing has optional = "
                     "true"},
        WrongCanLine{can_slave("ip = \"10.0.0.2\"\n"),
                     ":5: [slave 1] ip: is for lines of EtherCAT: CANopen has no Ethernet over the bus"},
        WrongCanLine{can_slave("watchdog = {}\n"),
                     ":5: [slave 1] watchdog: is for lines of EtherCAT: nodes notice the loss of the master by its "
                     "heartbeat or guarding"},
        WrongCanLine{can_slave("persona = \"no-dc\"\n"),
                     ":5: [slave 1] persona: is for lines of EtherCAT: it is the quirk of a slave controller"}));

INSTANTIATE_TEST_SUITE_P(
    Pdos, CanBusConfigError,
    testing::Values(
        WrongCanLine{can_slave("[[slave.pdo]]\nindex = 0x1800\n"),
                     ":6: [slave 1.pdo 1] index: is no mapping object: 0x1600 to 0x17FF (RPDO) or 0x1A00 to 0x1BFF "
                     "(TPDO) is expected"},
        WrongCanLine{can_slave("[[slave.pdo]]\nindex = 0x1604\n"),
                     ":6: [slave 1.pdo 1] index: is that of PDO 5: identifier is expected, the predefined connection "
                     "set ends at PDO 4"},
        WrongCanLine{can_slave("[[slave.pdo]]\nindex = 0x1600\nsync_manager = 2\n"),
                     ":7: [slave 1.pdo 1] sync_manager: is for lines of EtherCAT: the index tells the direction of a "
                     "PDO"},
        WrongCanLine{can_slave("[[slave.pdo]]\nindex = 0x1600\nevent_ms = 5\n"),
                     ":7: [slave 1.pdo 1] event_ms: is for TPDOs, which the node sends; resend_ms is expected"},
        WrongCanLine{can_slave("[[slave.pdo]]\nindex = 0x1A00\nresend_ms = 5\n"),
                     ":7: [slave 1.pdo 1] resend_ms: is for RPDOs, which the master sends; event_ms is expected"},
        WrongCanLine{
            can_slave("[[slave.pdo]]\nindex = 0x1600\nentries = [\"0x607A:0:32\", \"0x60FF:0:32\", \"0x6040:0:16\"]\n"),
            ":7: [slave 1.pdo 1] entries: are 80 bits, a PDO has at most 64"},
        WrongCanLine{can_slave("[[slave.pdo]]\nindex = 0x1600\n[[slave.pdo]]\nindex = 0x1600\n"),
                     ":8: [slave 1.pdo 2] index: 0x1600 is there twice"},
        WrongCanLine{can_slave("[[slave.sdo]]\nindex = 0x6083\ntype = \"uint32\"\nvalue = 1\ncomplete = true\n"),
                     ":9: [slave 1.sdo 1] complete: is for lines of EtherCAT: SDOs are written one by one in "
                     "Pre-operational"}));

INSTANTIATE_TEST_SUITE_P(
    Axis, CanBusConfigError,
    testing::Values(
        WrongCanLine{can_axis("mode = \"csp\"\n"),
                     ":7: [axis 1] mode: mode 8 is EtherCAT only (MSD manual 2077-2079); use interpolated position"},
        WrongCanLine{can_axis("mode = \"csv\"\n"),
                     ":7: [axis 1] mode: mode 9 is EtherCAT only (MSD manual 2077-2079); use interpolated position"},
        WrongCanLine{can_axis("mode = \"cst\"\n"),
                     ":7: [axis 1] mode: mode 10 is EtherCAT only (MSD manual 2077-2079); use interpolated position"},
        WrongCanLine{
            can_axis("mode = \"vl\"\n"),
            ":7: [axis 1] mode: is \"vl\", \"ip\" (interpolated position), \"pp\" (profile position) or \"pv\" "
            "(profile velocity) is expected"},
        WrongCanLine{can_axis("mode = \"pp\"\ngravity = 1\n"),
                     ":5: [axis 1]: feed-forward of friction or gravity has no effect: a profile mode has no torque "
                     "offset"},
        WrongCanLine{
            can_axis("mode = \"pp\"\n[path]\nfile = \"p.csv\"\n"),
            ":8: path: needs axes that follow setpoints, but the drive of \"x\" plans its motions itself (mode "
            "\"pp\"): it can be moved by requests to it alone"},
        WrongCanLine{
            can_axis("mode = \"pv\"\n[stream]\nsocket = \"s\"\n"),
            ":8: stream: needs axes that follow setpoints, but the drive of \"x\" plans its motions itself (mode "
            "\"pv\"): it can be moved by requests to it alone"},
        WrongCanLine{can_axis("mode = \"pp\"\n[[virtual_axis]]\nname = \"v\"\nmax_velocity = 2\nmax_acceleration = "
                              "20\n[[coupling]]\nslave = \"v\"\nmaster = \"x\"\nratio = [2, 3]\n"),
                     ":12: coupling: needs axes that follow setpoints, but the drive of \"x\" plans its motions itself "
                     "(mode \"pp\"): it can be moved by requests to it alone"},
        WrongCanLine{can_axis("gravity = 1\n"),
                     ":5: [axis 1]: feed-forward of friction or gravity has no effect: interpolated position has no "
                     "torque offset"},
        WrongCanLine{can_bus("sync_ms = 0.333\n") + "[[axis]]\nname = \"x\"\n",
                     ":3: [bus] sync_ms: \"x\" would be exchanged every 333 us: object 60C2h of a drive holds 1 to 255 "
                     "times a power of ten"}));

/// `--mode` replaces the mode of every axis.
TEST(CanBusConfig, AModeOfAllAxesIsRefused) {
  const auto config =
      parse_line_config(can_axis(""), "cell.toml", DeviceRegistry(), motion::cia402::Mode::kCyclicTorque);
  EXPECT_THAT(failure_text(config), testing::HasSubstr("mode 10 is EtherCAT only"));
}

}  // namespace
}  // namespace driveline::runtime
