// Every possible error in a line description, with the whole sentence for its author.
#include <gmock/gmock.h>

#include "driveline/runtime/config/line_config.hpp"
#include "support/must.hpp"
#include "support/temporary_directory.hpp"

namespace driveline::runtime {
namespace {

struct WrongFile {
  std::string text;
  std::string sentence;
};

void PrintTo(const WrongFile& wrong, std::ostream* stream) {
  *stream << wrong.sentence;
}

class LineConfigError : public testing::TestWithParam<WrongFile> {};

TEST_P(LineConfigError, IsOneSentenceWithFileAndLine) {
  EXPECT_EQ(failure_text(parse_line_config(GetParam().text, "plant/line.toml")),
            "plant/line.toml" + GetParam().sentence);
}

/// A line with one slave, and an error from line 4 on.
std::string one_slave(const std::string& rest) {
  return "[[slave]]\nname = \"x\"\n\n" + rest;
}
/// The same with an axis; `rest` starts at line 6, inside the axis.
std::string one_axis(const std::string& rest) {
  return one_slave("[[axis]]\nname = \"x\"\n" + rest);
}

INSTANTIATE_TEST_SUITE_P(
    PdosOfAnAxis, LineConfigError,
    testing::Values(
        WrongFile{
            one_slave("[[slave.pdo]]\nindex = 0x1600\nentries = [\"0x6040:0:16\", \"0x6060:0:8\"]\n"
                      "[[slave.pdo]]\nindex = 0x1A00\nentries = [\"0x6041:0:16\", \"0x6064:0:32\"]\n"
                      "[[axis]]\nname = \"x\"\n"),
            ":10: [axis 1] slave: the [[slave.pdo]] of \"x\" are not enough: csp needs 607Ah (Target position, 32 "
            "bits) in an RxPDO; the RxPDOs map 6040h, 6060h"},
        WrongFile{
            one_slave("[[slave.pdo]]\nindex = 0x1600\nentries = [\"0x6040:0:16\", \"0x60FF:0:32\"]\n"
                      "[[axis]]\nname = \"x\"\nmode = \"csv\"\n"),
            ":7: [axis 1] slave: the [[slave.pdo]] of \"x\" are not enough: csv needs 6041h (Statusword, 16 bits) "
            "in a TxPDO, 6064h (Position actual value, 32 bits) in a TxPDO; the TxPDOs map nothing"}));

INSTANTIATE_TEST_SUITE_P(
    FeedForward, LineConfigError,
    testing::Values(
        WrongFile{one_axis("viscous_friction = -1\n"),
                  ":6: [axis 1] viscous_friction: is -1, 0 to 1000000 is expected"},
        WrongFile{one_axis("coulomb_friction = nan\n"),
                  ":6: [axis 1] coulomb_friction: is nan, 0 to 1000000 is expected"},
        WrongFile{one_axis("gravity = inf\n"), ":6: [axis 1] gravity: is inf, -1000000 to 1000000 is expected"},
        WrongFile{one_axis("coulomb_velocity = 0\n"),
                  ":6: [axis 1] coulomb_velocity: is 0, 1e-09 to 1000000 is expected"},
        WrongFile{one_axis("feed_mm_per_revolution = 5\npendulum = 1\n"),
                  ":7: [axis 1] pendulum: is for rotary axes, but feed_mm_per_revolution makes this axis linear"},
        WrongFile{"[[slave]]\nname = \"x\"\nmodel = \"servoone\"\n[[axis]]\nname = \"x\"\ngravity = 1\n",
                  ":4: [axis 1]: feed-forward of friction or gravity has no effect: \"x\" accepts torque offsets only "
                  "with an interpolation that driveline does not use (P 370 = 2)"},
        WrongFile{one_slave("[[slave.pdo]]\nindex = 0x1600\nentries = [\"0x6040:0:16\", \"0x607A:0:32\"]\n"
                            "[[slave.pdo]]\nindex = 0x1A00\nentries = [\"0x6041:0:16\", \"0x6064:0:32\"]\n"
                            "[[axis]]\nname = \"x\"\ngravity = 1\n"),
                  ":10: [axis 1] slave: the [[slave.pdo]] of \"x\" are not enough: csp with a feed-forward of friction "
                  "or gravity needs 60B2h (Torque offset, 16 bits) in an RxPDO; the RxPDOs map 6040h, 607Ah"}));

INSTANTIATE_TEST_SUITE_P(
    RangeOfAnAxis, LineConfigError,
    testing::Values(
        WrongFile{one_axis("min_position = -1\n"),
                  ":6: [axis 1] min_position: is set without max_position: both are expected"},
        WrongFile{one_axis("max_position = 1\n"),
                  ":6: [axis 1] max_position: is set without min_position: both are expected"},
        WrongFile{one_axis("unit = \"deg\"\nmin_position = 90\nmax_position = -90\n"),
                  ":8: [axis 1] max_position: is -90 deg, more than the 90 deg of min_position is expected"},
        WrongFile{one_axis("min_position = 0\nmax_position = 0\n"),
                  ":7: [axis 1] max_position: is 0 rad, more than the 0 rad of min_position is expected"},
        WrongFile{one_axis("min_position = nan\nmax_position = 1\n"),
                  ":6: [axis 1] min_position: is nan, -1000000 to 1000000 is expected"},
        WrongFile{one_axis("modulo = 0\n"),
                  ":6: [axis 1] modulo: needs increments_per_revolution: the modulo is written to the drive before its "
                  "increments are read"},
        WrongFile{one_axis("increments_per_revolution = 1048576\nmodulo = 0\n"),
                  ":7: [axis 1] modulo: is 0, 1e-06 to 1000000 is expected"},
        WrongFile{one_axis("increments_per_revolution = 1048576\nmodulo = 6.28\n"),
                  ":7: [axis 1] modulo: is 1048044.417 increments of the drive, a whole number is expected: positions "
                  "would drift with every turn"},
        WrongFile{one_axis("unit = \"rev\"\nincrements_per_revolution = 1048576\nmodulo = 4096\n"),
                  ":8: [axis 1] modulo: is 4.29497e+09 increments of the drive, 2 to 2147483647 are expected"},
        WrongFile{one_axis("unit = \"rev\"\nincrements_per_revolution = 1048576\nmin_position = 0\nmax_position = 1\n"
                           "modulo = 1\n"),
                  ":10: [axis 1] modulo: is for axes without end positions, but min_position and max_position are set"},
        WrongFile{
            one_axis("unit = \"deg\"\nincrements_per_revolution = 1048576\nmodulo = 11.25\nmax_velocity = 24000\n"),
            ":4: axis: \"x\" moves 3 deg between two exchanges at its max_velocity, and less than a "
            "quarter of its modulo of 11.25 deg is expected"}));

INSTANTIATE_TEST_SUITE_P(
    Polarity, LineConfigError,
    testing::Values(
        WrongFile{one_axis("polarity = \"revrsed\"\n"),
                  ":6: [axis 1] polarity: is \"revrsed\", one of \"normal\", \"reversed\" is expected; did you mean "
                  "\"reversed\"?"},
        WrongFile{one_axis("polarity = -1\n"), ":6: [axis 1] polarity: is an integer, a string is expected"}));

INSTANTIATE_TEST_SUITE_P(
    AxesThatWouldNeverMove, LineConfigError,
    testing::Values(WrongFile{one_axis("mode = \"cst\"\n"),
                              ":4: [axis 1] velocity_gain: mode \"cst\" needs it, or inertia to calculate it: without "
                              "either the axis would never move"},
                    WrongFile{one_axis("mode = \"cst\"\ninertia = 3e-4\nvelocity_gain = 0\n"),
                              ":8: [axis 1] velocity_gain: is 0: with mode \"cst\" the axis would never move"}));

INSTANTIATE_TEST_SUITE_P(
    UnknownKey, LineConfigError,
    testing::Values(
        WrongFile{one_slave("[line]\ncycle_ms = 1\n"),
                  ":5: [line] cycle_ms: unknown key, expected one of: cycle_us, name"},
        WrongFile{
            one_slave("[lines]\n"),
            ":4: lines: unknown key, expected one of: axis, axis_group, bus, cam, commands, copy, coupling, dc, "
            "encoder, eoe, fault, gantry, gateway, group, line, output, path, process_data, realtime, recovery, slave, "
            "stream, telemetry, virtual_axis, wiring"},
        WrongFile{one_slave("[bus]\niface = \"eth1\"\n"),
                  ":5: [bus] iface: unknown key, expected one of: acyclic_bytes, esi, interface, interface2, "
                  "launch_ahead_us, max_lost_cycles, max_lost_ms, port, type"},
        WrongFile{one_slave("[bus]\nport = \"dpdk\"\n"),
                  ":5: [bus] port: is \"dpdk\", one of \"auto\", \"raw\", \"xdp\" is expected"},
        WrongFile{
            one_slave("[realtime]\n\nprio = 80\n"),
            ":6: [realtime] prio: unknown key, expected one of: cpu, cpu_latency_us, lock_memory, policy, priority, "
            "receive, simulation_cpu, wake_ahead_us"},
        WrongFile{one_slave("[realtime]\nreceive = \"poll\"\n"),
                  ":5: [realtime] receive: is \"poll\", one of \"spin\", \"sleep\", \"block\" is expected"},
        WrongFile{
            "[[slave]]\nname = \"x\"\naddress = 5\n",
            ":3: [slave 1] address: unknown key, expected one of: alias, dc, device_id, eeprom_to_application, esi, "
            "factory_start_up_ms, file_password, firmware, forwarding_ns, hot_connect, idn, input, ip, lrw, model, "
            "name, "
            "names, parameter_file, pdo, persona, plant, processing_ns, product_code, revision, sdo, serial, sii, "
            "sii_file, start_up_ms, startup, state_timeout_ms, switch, timeouts, vendor_id, watchdog"},
        WrongFile{"[[slave]]\nname = \"x\"\n[slave.plant]\nmass = 5\n",
                  ":4: [slave 1.plant] mass: unknown key, expected one of: brake_torque_nm, coulomb_friction_nm, "
                  "dc_link, dc_link_v, encoder, inertia_kg_m2, initial_position_rev, load, max_speed_rpm, "
                  "peak_torque_nm, pole_pairs, rated_current_a, rated_speed_rpm, rated_torque_nm, thermal, "
                  "torque_lag_us, viscous_friction_nm_s, winding"},
        WrongFile{one_axis("limit = 5\n"),
                  ":6: [axis 1] limit: unknown key, expected one of: adds_offsets, backlash, "
                  "backlash_acceleration, backlash_velocity, compensate, compensation, coulomb_friction, "
                  "coulomb_velocity, drive, feed_mm_per_revolution, follow_bit, following_error_timeout_ms, "
                  "following_error_window, gravity, "
                  "increments_per_revolution, inertia, max_acceleration, max_jerk, max_position, max_torque, "
                  "max_velocity, min_position, "
                  "mode, modulo, name, pendulum, "
                  "pendulum_zero, polarity, position_gain_1_s, position_tolerance, "
                  "rated_torque_nm, setpoint_delay_cycles, slave, unit, velocity_gain, viscous_friction"},
        WrongFile{
            one_slave("[path]\nfile = \"a.csv\"\nspeed = 2\n"),
            ":6: [path] speed: unknown key, expected one of: dead_time, file, interpolation, late, relative, repeat"},
        WrongFile{one_slave("[telemetry]\nrate = 2\n"),
                  ":5: [telemetry] rate: unknown key, expected one of: bridge, decimation, discovery_server, domain, "
                  "enabled, "
                  "interfaces, partition, peers, qos_profiles, rates, ros2, security, shared_memory, user"},
        WrongFile{one_slave("[output]\nplot = false\n"),
                  ":5: [output] plot: unknown key, expected one of: capture, directory, plots"}));

INSTANTIATE_TEST_SUITE_P(
    WrongType, LineConfigError,
    testing::Values(WrongFile{one_slave("[line]\nname = 8\n"), ":5: [line] name: is an integer, a string is expected"},
                    WrongFile{one_slave("[line]\ncycle_us = \"125\"\n"),
                              ":5: [line] cycle_us: is a string, a number is expected"},
                    WrongFile{one_slave("[realtime]\npriority = 80.5\n"),
                              ":5: [realtime] priority: is a number, an integer is expected"},
                    WrongFile{one_slave("[realtime]\nlock_memory = 1\n"),
                              ":5: [realtime] lock_memory: is an integer, true or false is expected"},
                    WrongFile{one_slave("[output]\nplots = 1979-05-27\n"),
                              ":5: [output] plots: is a date or time, true or false is expected"},
                    WrongFile{one_slave("[telemetry]\ninterfaces = \"127.0.0.1\"\n"),
                              ":5: [telemetry] interfaces: is a string, an array of strings is expected"},
                    WrongFile{one_slave("[telemetry]\ninterfaces = [\"127.0.0.1\", 5]\n"),
                              ":5: [telemetry] interfaces: contains an integer, an array of strings is expected"},
                    WrongFile{"line = true\n", ":1: line: is a boolean, a table is expected"},
                    WrongFile{"[slave]\nname = \"x\"\n", ":1: slave: is a table, [[slave]] tables are expected"},
                    WrongFile{"slave = [5]\n", ":1: slave: contains an integer, [[slave]] tables are expected"},
                    WrongFile{"[[slave]]\nname = [\"x\"]\n", ":2: [slave 1] name: is an array, a string is expected"}));

INSTANTIATE_TEST_SUITE_P(
    OutOfRange, LineConfigError,
    testing::Values(
        WrongFile{one_slave("[bus]\ninterface2 = \"b\"\n"),
                  ":5: [bus] interface2: needs interface, the other end of the ring"},
        WrongFile{one_slave("[bus]\ninterface = \"a\"\ninterface2 = \"a\"\n"),
                  ":6: [bus] interface2: is \"a\", the same as interface: a ring needs two interfaces"},
        WrongFile{one_slave("[recovery]\naxes = \"go\"\n"),
                  ":5: [recovery] axes: is \"go\", one of \"stop\", \"hold\", \"continue\" is expected"},
        WrongFile{one_slave("[recovery]\ngive_up_s = -1\n"), ":5: [recovery] give_up_s: is -1, 0 to 86400 is expected"},
        WrongFile{one_slave("[bus]\nmax_lost_cycles = 0\n"), ":5: [bus] max_lost_cycles: is 0, 1 to 10000 is expected"},
        WrongFile{one_slave("[bus]\nmax_lost_ms = 0.1\n"), ":5: [bus] max_lost_ms: is 0.1, 0.125 to 1250 is expected"},
        WrongFile{one_slave("[bus]\nmax_lost_ms = 11000\n[line]\ncycle_us = 1000\n"),
                  ":5: [bus] max_lost_ms: is 11000, 1 to 10000 is expected"},
        WrongFile{one_slave("[bus]\nmax_lost_cycles = 8\nmax_lost_ms = 1\n"),
                  ":6: [bus] max_lost_ms: is set together with max_lost_cycles: both are the same limit, only one is "
                  "expected"},
        WrongFile{one_slave("[line]\nname = \"\"\n"), ":5: [line] name: must have 1 to 31 characters"},
        WrongFile{one_slave("[line]\nname = \"12345678901234567890123456789012\"\n"),
                  ":5: [line] name: must have 1 to 31 characters"},
        WrongFile{one_axis("unit = \"mm\"\n"),
                  ":6: [axis 1] unit: is \"mm\", \"rad\", \"deg\" or \"rev\" of an axis without "
                  "feed_mm_per_revolution is expected"},
        WrongFile{one_axis("feed_mm_per_revolution = 5\nunit = \"turns\"\n"),
                  ":7: [axis 1] unit: is \"turns\", \"m\", \"mm\" or \"um\" of an axis with "
                  "feed_mm_per_revolution is expected"},
        WrongFile{one_axis("feed_mm_per_revolution = 5\nunit = \"mm\"\nmax_velocity = 2e9\n"),
                  ":8: [axis 1] max_velocity: is 2000000000, 0.001 to 1000000000 is expected"},
        WrongFile{one_slave("[line]\ncycle_us = 100\n"), ":5: [line] cycle_us: is 100, 125 to 100000 is expected"},
        WrongFile{one_slave("[line]\ncycle_us = nan\n"), ":5: [line] cycle_us: is nan, 125 to 100000 is expected"},
        WrongFile{one_slave("[line]\ncycle_us = 200\n"),
                  ":5: [line] cycle_us: must be a multiple of 125, the drives' process data cycle"},
        WrongFile{one_slave("[realtime]\npriority = 0\n"), ":5: [realtime] priority: is 0, 1 to 99 is expected"},
        WrongFile{one_slave("[realtime]\npriority = 100\n"), ":5: [realtime] priority: is 100, 1 to 99 is expected"},
        WrongFile{one_slave("[realtime]\ncpu = -1\n"), ":5: [realtime] cpu: is -1, 0 to 1023 is expected"},
        WrongFile{one_slave("[realtime]\nsimulation_cpu = 1024\n"),
                  ":5: [realtime] simulation_cpu: is 1024, 0 to 1023 is expected"},
        WrongFile{one_slave("[realtime]\ncpu_latency_us = -2\n"),
                  ":5: [realtime] cpu_latency_us: is -2, -1 to 1000000 is expected"},
        WrongFile{one_slave("[bus]\nlaunch_ahead_us = 0\n"), ":5: [bus] launch_ahead_us: is 0, 1 to 31.25 is expected"},
        WrongFile{one_slave("[bus]\nlaunch_ahead_us = 32\n"),
                  ":5: [bus] launch_ahead_us: is 32, 1 to 31.25 is expected"},
        WrongFile{one_slave("[bus]\nport = \"xdp\"\nlaunch_ahead_us = 20\n"),
                  ":6: [bus] launch_ahead_us: needs a packet socket: set port = \"raw\" or \"auto\""},
        WrongFile{
            one_slave("[bus]\ninterface = \"a\"\ninterface2 = \"b\"\nlaunch_ahead_us = 20\n"),
            ":7: [bus] launch_ahead_us: cannot be used with interface2: both ends of a ring send at the same time"},
        WrongFile{one_slave("[realtime]\nwake_ahead_us = 126\n"),
                  ":5: [realtime] wake_ahead_us: is 126, 0 to 31.25 is expected"},
        WrongFile{one_slave("[realtime]\nwake_ahead_us = \"aut\"\n"),
                  ":5: [realtime] wake_ahead_us: is \"aut\", \"auto\" or 0 to 31.25 is expected"},
        WrongFile{one_slave("[realtime]\npolicy = \"strict\"\n"),
                  ":5: [realtime] policy: is \"strict\", one of \"enforce\", \"degrade\" is expected"},
        WrongFile{"[[slave]]\nname = \"x\"\nvendor_id = 0\n",
                  ":3: [slave 1] vendor_id: is 0, 1 to 4294967295 is expected"},
        WrongFile{"[[slave]]\nname = \"x\"\nproduct_code = 0x100000000\n",
                  ":3: [slave 1] product_code: is 4294967296, 1 to 4294967295 is expected"},
        WrongFile{
            "[[slave]]\nname = \"x\"\nmodel = \"servotwo\"\n",
            ":3: [slave 1] model: is \"servotwo\", known are \"msd\", \"servoone\", \"servoone_junior\", \"generic\", "
            "\"eds\""},
        WrongFile{"[[slave]]\nname = \"x\"\nmodel = \"servoone\"\nfirmware = \"4.15.02\"\n",
                  ":4: [slave 1] firmware: must be a version as \"4.30-00\", from 3.25-00 on"},
        WrongFile{"[[slave]]\nname = \"x\"\nmodel = \"servoone\"\nfirmware = \"3.24-99\"\n",
                  ":4: [slave 1] firmware: must be a version as \"4.30-00\", from 3.25-00 on"},
        WrongFile{"[[slave]]\nname = \"x\"\nfirmware = \"4.30-00\"\n",
                  ":3: [slave 1] firmware: must be a version as \"124.30-00\", from 124.25-00 on"},
        WrongFile{"[[slave]]\nname = \"x\"\n[slave.plant]\ninertia_kg_m2 = 0\n",
                  ":4: [slave 1.plant] inertia_kg_m2: is 0, 1e-06 to 10 is expected"},
        WrongFile{"[[slave]]\nname = \"x\"\n[slave.plant]\ncoulomb_friction_nm = -0.5\n",
                  ":4: [slave 1.plant] coulomb_friction_nm: is -0.5, 0 to 1000 is expected"},
        WrongFile{"[[slave]]\nname = \"x\"\n[slave.plant]\ninitial_position_rev = 1e4\n",
                  ":4: [slave 1.plant] initial_position_rev: is 10000, -1000 to 1000 is expected"},
        WrongFile{one_axis("mode = \"pp\"\n"),
                  ":6: [axis 1] mode: is \"pp\", one of \"csp\", \"csv\", \"cst\" is expected"},
        WrongFile{one_axis("max_torque = 0\n"), ":6: [axis 1] max_torque: is 0, 1e-09 to 1000000 is expected"},
        WrongFile{one_axis("following_error_window = 0\n"),
                  ":6: [axis 1] following_error_window: is 0, 1e-09 to 1000000 is expected"},
        WrongFile{one_axis("following_error_timeout_ms = 5\n"),
                  ":6: [axis 1] following_error_timeout_ms: has no effect without following_error_window"},
        WrongFile{one_axis("max_velocity = 0\n"), ":6: [axis 1] max_velocity: is 0, 1e-06 to 1000000 is expected"},
        WrongFile{one_axis("max_acceleration = inf\n"),
                  ":6: [axis 1] max_acceleration: is inf, 1e-06 to 1000000000 is expected"},
        WrongFile{one_axis("increments_per_revolution = 0.5\n"),
                  ":6: [axis 1] increments_per_revolution: is 0.5, 1 to 4294967295 is expected"},
        WrongFile{one_slave("[path]\nfile = \"a.csv\"\ninterpolation = \"cubic\"\n"),
                  ":6: [path] interpolation: is \"cubic\", one of \"hold\", \"linear\", \"hermite\", \"natural\", "
                  "\"clamped\", \"quintic\", \"cosine\", \"bspline\" is expected"},
        WrongFile{one_slave("[path]\nfile = \"a.csv\"\ninterpolation = \"b-spline\"\n"),
                  ":6: [path] interpolation: is \"b-spline\", one of \"hold\", \"linear\", \"hermite\", \"natural\", "
                  "\"clamped\", \"quintic\", \"cosine\", \"bspline\" is expected; did you mean \"bspline\"?"},
        WrongFile{one_slave("[telemetry]\ndomain = 233\n"), ":5: [telemetry] domain: is 233, 0 to 232 is expected"},
        WrongFile{one_slave("[telemetry]\ndecimation = 0\n"),
                  ":5: [telemetry] decimation: is 0, 1 to 1000000 is expected"}));

INSTANTIATE_TEST_SUITE_P(
    Telemetry, LineConfigError,
    testing::Values(
        WrongFile{
            one_slave("[telemetry]\npartition = \"\"\n"),
            ":5: [telemetry] partition: 1 to 63 letters, digits and signs but * ? [ ] \\ and blanks are expected"},
        WrongFile{
            one_slave("[telemetry]\npartition = \"press*\"\n"),
            ":5: [telemetry] partition: 1 to 63 letters, digits and signs but * ? [ ] \\ and blanks are expected"},
        WrongFile{one_slave("[telemetry]\ninterfaces = []\npeers = [\"plc.local\"]\n"),
                  ":6: [telemetry] peers: \"plc.local\" is not an IPv4 address such as 192.168.1.10"},
        WrongFile{one_slave("[telemetry]\npeers = [\"192.0.2.1\"]\n"),
                  ":5: [telemetry] peers: 192.0.2.1 cannot be reached from 127.0.0.1, which keeps telemetry on this "
                  "machine: name the interface that leads to it in interfaces"},
        WrongFile{one_slave("[telemetry]\ndiscovery_server = \"192.0.2.1:11811\"\n"),
                  ":5: [telemetry] discovery_server: 192.0.2.1 cannot be reached from 127.0.0.1, which keeps telemetry "
                  "on this machine: name the interface that leads to it in interfaces"},
        WrongFile{one_slave("[telemetry]\ndiscovery_server = \"127.0.0.1\"\n"),
                  ":5: [telemetry] discovery_server: is \"127.0.0.1\", an IPv4 address and a port such as "
                  "192.168.1.10:11811 are expected"},
        WrongFile{one_slave("[telemetry]\ndiscovery_server = \"127.0.0.1:65536\"\n"),
                  ":5: [telemetry] discovery_server: is \"127.0.0.1:65536\", an IPv4 address and a port such as "
                  "192.168.1.10:11811 are expected"},
        WrongFile{one_slave("[telemetry]\npeers = [\"127.0.0.1\"]\ndiscovery_server = \"127.0.0.1:11811\"\n"),
                  ":5: [telemetry] peers: are not used with a discovery_server: remove one of the two keys"},
        WrongFile{one_slave("[telemetry]\nuser = \"nobody-has-this-name\"\n"),
                  ":5: [telemetry] user: there is no user \"nobody-has-this-name\" on this machine"},
        WrongFile{one_slave("[telemetry]\nuser = \"\"\n"),
                  ":5: [telemetry] user: there is no user \"\" on this machine"},
        WrongFile{one_slave("[telemetry]\nuser = \"4294967295\"\n"),
                  ":5: [telemetry] user: there is no user \"4294967295\" on this machine"},
        WrongFile{one_slave("[telemetry]\nuser = \"root\"\n"),
                  ":5: [telemetry] user: is \"root\", but a process that reads from a network must not run as root: "
                  "another user is expected"},
        WrongFile{one_slave("[telemetry]\nuser = \"0\"\n"),
                  ":5: [telemetry] user: is \"0\", but a process that reads from a network must not run as root: "
                  "another user is expected"},
        WrongFile{one_slave("[telemetry]\nbridge = \"service\"\nuser = \"1000\"\n"),
                  ":6: [telemetry] user: is for the bridge that run starts; with bridge = \"service\" the service sets "
                  "its own user"},
        WrongFile{one_slave("[telemetry]\nshared_memory = true\nsecurity = \"keys/line1\"\n"),
                  ":5: [telemetry] shared_memory: is not tested with DDS Security: remove it or security"}));

INSTANTIATE_TEST_SUITE_P(
    TelemetryRates, LineConfigError,
    testing::Values(
        WrongFile{one_slave("[telemetry.rates]\naxis = 2\n"),
                  ":5: [telemetry.rates] axis: unknown key, expected one of: axis_batch, axis_state, axis_telemetry, "
                  "cycle_statistics, diagnostics, event, joint_states, line_status, slave, topology"},
        WrongFile{one_slave("[telemetry.rates]\naxis_batch = \"fast\"\n"),
                  ":5: [telemetry.rates] axis_batch: is \"fast\", \"full\", \"change\", \"off\", a rate such as \"100 "
                  "Hz\", or 8 for every 8th cycle is expected"},
        WrongFile{one_slave("[telemetry.rates]\naxis_batch = 0\n"),
                  ":5: [telemetry.rates] axis_batch: is 0, 1 to 1000000 is expected"},
        WrongFile{one_slave("[telemetry.rates]\nline_status = \"off\"\n"),
                  ":5: [telemetry.rates] line_status: is \"off\", a rate from \"0.1 Hz\" to \"100 Hz\" is expected"},
        WrongFile{one_slave("[telemetry.rates]\nline_status = \"101 Hz\"\n"),
                  ":5: [telemetry.rates] line_status: is \"101 Hz\", a rate from \"0.1 Hz\" to \"100 Hz\" is expected"},
        WrongFile{one_slave("[telemetry.rates]\nevent = 3\n"),
                  ":5: [telemetry.rates] event: \"change\" or \"off\" is expected"},
        WrongFile{one_slave("[telemetry.rates]\njoint_states = \"full\"\n"),
                  ":5: [telemetry.rates] joint_states: is a topic of ROS 2, which needs ros2 = true in [telemetry]"},
        WrongFile{one_slave("[telemetry]\ndecimation = 2\n[telemetry.rates]\naxis_telemetry = 4\n"),
                  ":5: [telemetry] decimation: sets the rate of axis_telemetry, as does [telemetry.rates]: remove one "
                  "of them"}));

INSTANTIATE_TEST_SUITE_P(
    Missing, LineConfigError,
    testing::Values(
        WrongFile{"", ":1: there is no [[slave]]"},
        WrongFile{"[[slave]]\nmodel = \"msd\"\n", ":1: [slave 1] name: is missing, a string is expected"},
        WrongFile{one_slave("[path]\n"), ":4: [path] file: is missing, a string is expected"},
        WrongFile{one_slave("[[axis]]\nslave = \"x\"\n"), ":4: [axis 1] name: is missing, a string is expected"},
        WrongFile{one_slave("[[axis]]\nname = \"y\"\n"), ":4: [axis 1] slave: there is no [[slave]] named \"y\""},
        WrongFile{one_slave("[[axis]]\nname = \"y\"\nslave = \"z\"\n"),
                  ":6: [axis 1] slave: there is no [[slave]] named \"z\""}));

INSTANTIATE_TEST_SUITE_P(
    Twice, LineConfigError,
    testing::Values(
        WrongFile{one_slave("[[slave]]\nname = \"y\"\n[[slave]]\nname = \"x\"\n"),
                  ":7: [slave 3] name: \"x\" is there twice"},
        WrongFile{one_slave("[[slave]]\nname = \"y\"\n[[axis]]\nname = \"x\"\n[[axis]]\nname = \"x\"\nslave = \"y\"\n"),
                  ":9: [axis 2] name: axis name 'x' appears twice"},
        WrongFile{one_axis("[[axis]]\nname = \"y\"\nslave = \"x\"\n"),
                  ":8: [axis 2] slave: \"x\" already belongs to another axis"},
        WrongFile{one_axis("[[axis]]\nname = \"y\"\n"), ":6: [axis 2] slave: there is no [[slave]] named \"y\""}));

TEST(LineConfigErrors, SyntaxErrorTellsFileAndLine) {
  const auto config = parse_line_config("[line]\nname = \"x\n", "line.toml");
  ASSERT_FALSE(config);
  EXPECT_THAT(describe(config.error()), testing::StartsWith("line.toml:2: "));
  EXPECT_EQ(describe(config.error()).find('\n'), std::string::npos) << describe(config.error());
}

TEST(LineConfigErrors, TooManySlaves) {
  std::string text;
  for (int i = 0; i < 257; ++i) text += "[[slave]]\nname = \"s" + std::to_string(i) + "\"\n";
  EXPECT_EQ(failure_text(parse_line_config(text, "line.toml")), "line.toml:1: slave: there are 257, the limit is 256");
}

/// Reading each of them first would take seconds; the error of the last one shows that none is read.
TEST(LineConfigLimits, TooManyTablesAreRefusedBeforeTheyAreRead) {
  std::string slaves;
  for (int i = 0; i < 70'000; ++i) slaves += "[[slave]]\nname = \"s" + std::to_string(i) + "\"\n";
  EXPECT_EQ(failure_text(parse_line_config(slaves + "wrong = 1\n", "line.toml")),
            "line.toml:1: slave: there are 70000, the limit is 256");
  std::string axes = "[[slave]]\nname = \"x\"\n";
  for (int i = 0; i < 10'001; ++i) axes += "[[axis]]\nwrong = 1\n";
  EXPECT_EQ(failure_text(parse_line_config(axes, "line.toml")),
            "line.toml:3: axis: there are 10001, the limit is 10000");
}

TEST(LineConfigLimits, ATextThatIsTooLongIsNotParsed) {
  EXPECT_EQ(failure_text(parse_line_config("wrong" + std::string(std::size_t{8} << 20, ' '), "line.toml")),
            "line.toml: is larger than 8 MiB, the limit of a line description");
}

/// `text` repeated `count` times.
std::string times(std::size_t count, std::string_view text) {
  std::string result;
  for (std::size_t i = 0; i < count; ++i) result += text;
  return result;
}

TEST(LineConfigErrors, FileThatGoesTooDeepIsRefusedBeforeItTakesTheStack) {
  constexpr std::size_t kDeep = 60'000;
  const std::string refused = "line.toml:4: keys or values are more than 32 levels deep; a line description needs four";
  for (const auto& deep :
       {times(kDeep, "a.") + "b = 1\n", "[" + times(kDeep, "a.") + "b]\n", "[[" + times(kDeep, " 'a' . ") + "b]]\n",
        "a = " + times(kDeep, "[") + times(kDeep, "]"), "a = " + times(kDeep, "{b = ") + "1" + times(kDeep, "}")}) {
    const auto config = parse_line_config(one_slave(deep), "line.toml");
    ASSERT_FALSE(config) << deep.substr(0, 10);
    EXPECT_EQ(describe(config.error()), refused) << deep.substr(0, 10);
  }
}

TEST(LineConfigErrors, DotsAndBracketsInTextsAndCommentsAreNoLevels) {
  const auto dots = times(100, ".") + times(100, "[{");
  for (const auto& name : {'"' + dots + '"', "'" + dots + "'", "\"\\\"" + dots + '"', "'''" + dots + "'''",
                           "\"\"\"\n'\n" + dots + "\"\"\"\"\""}) {
    const auto config = parse_line_config("# " + dots + "\n[line]\nname = " + name + "\n", "line.toml");
    ASSERT_FALSE(config);
    EXPECT_THAT(describe(config.error()), testing::HasSubstr("[line] name: "))
        << name << ": " << describe(config.error());
  }
  std::string numbers = "[1.5";
  for (int i = 0; i < 100; ++i) numbers += ", 1.5";
  EXPECT_THAT(failure_text(parse_line_config(one_slave("numbers = " + numbers + "]\n"), "line.toml")),
              testing::HasSubstr("numbers: unknown key"));
}

class LineConfigFile : public test::TemporaryDirectory {};

TEST_F(LineConfigFile, OneThatNeverEndsIsRefused) {
  EXPECT_EQ(describe(load_line_config("/dev/zero").error()), "/dev/zero: is larger than 128 MiB");
}

TEST_F(LineConfigFile, MissingOneSaysSo) {
  const auto file = directory / "none.toml";
  EXPECT_EQ(describe(load_line_config(file).error()), file.string() + ": cannot be read: No such file or directory");
}

TEST_F(LineConfigFile, FolderIsNoFile) {
  EXPECT_EQ(describe(load_line_config(directory).error()), directory.string() + ": cannot be read: Is a directory");
}

TEST_F(LineConfigFile, BinaryRubbishIsAnErrorNotACrash) {
  const auto file = directory / "line.toml";
  std::string rubbish;
  for (int i = 0; i < 4096; ++i) rubbish += static_cast<char>(i * 37);
  write(file, rubbish);
  EXPECT_THAT(failure_text(load_line_config(file)), testing::StartsWith(file.string() + ":1: "));
}

}  // namespace
}  // namespace driveline::runtime
