#include "driveline/runtime/config/line_config.hpp"

#include <gmock/gmock.h>

#include <numbers>

#include "driveline/runtime/devices/msd_device.hpp"
#include "support/temporary_directory.hpp"

namespace driveline::runtime {
namespace {

using motion::cia402::Mode;
using std::chrono::microseconds;

const slaves::msd::MsdParameters& msd_of(const SlaveConfig& slave) {
  return dynamic_cast<const MsdDevice&>(*slave.device).parameters();
}

LineConfig parsed(std::string_view text, const std::filesystem::path& name = "line.toml") {
  auto config = parse_line_config(text, name);
  if (!config) throw std::runtime_error(describe(config.error()));
  return *config;
}

TEST(LineConfig, OneNamedSlaveIsEnough) {
  const auto config = parsed("[[slave]]\nname = \"x\"\n");
  EXPECT_EQ(config.name, "line");
  EXPECT_EQ(config.period, microseconds{125});
  EXPECT_FALSE(config.interface);
  EXPECT_EQ(config.max_lost_cycles, 8U);
  EXPECT_FALSE(config.policy);
  EXPECT_EQ(config.realtime.priority, 80);
  EXPECT_FALSE(config.realtime.cpu);
  EXPECT_TRUE(config.realtime.lock_memory);
  EXPECT_EQ(config.wake_ahead, std::nullopt) << "as the machine needs it";
  EXPECT_EQ(config.receive, ecat_master::ReceiveStrategy::kSpin);
  EXPECT_FALSE(config.simulation_cpu);
  EXPECT_EQ(config.realtime.cpu_latency, microseconds{0});
  ASSERT_EQ(config.slaves.size(), 1U);
  EXPECT_EQ(msd_of(config.slaves[0]).variant, slaves::msd::Variant::kMsd);
  EXPECT_FALSE(msd_of(config.slaves[0]).firmware);
  EXPECT_FALSE(config.slaves[0].vendor_id);
  EXPECT_TRUE(config.axes.empty());
  EXPECT_FALSE(config.path);
  EXPECT_TRUE(config.telemetry.enabled);
  EXPECT_EQ(config.telemetry.domain, 0U);
  EXPECT_FALSE(config.telemetry.ros2);
  EXPECT_FALSE(config.telemetry.shared_memory);
  EXPECT_FALSE(config.telemetry.user);
  EXPECT_EQ(config.telemetry.decimation, 8U);
  EXPECT_THAT(config.telemetry.interfaces, testing::ElementsAre("127.0.0.1"));
  EXPECT_EQ(config.output.directory, "out");
  EXPECT_TRUE(config.output.plots);
  EXPECT_FALSE(config.output.capture);
  EXPECT_FALSE(config.interface2);
  EXPECT_EQ(config.port, port::PortChoice::kAuto);
  EXPECT_EQ(config.recovery.axes, motion::LossPolicy::kStop);
  EXPECT_EQ(config.recovery.give_up, std::chrono::seconds{60});
}

TEST(LineConfig, TelemetrySaysHowOftenAndToWhom) {
  const auto config = parsed(
      "[line]\ncycle_us = 500\n[[slave]]\nname = \"x\"\n"
      "[telemetry]\npartition = \"hall2/press\"\ninterfaces = [\"192.0.2.1\"]\npeers = [\"192.0.2.7\"]\n"
      "qos_profiles = \"qos.xml\"\nros2 = true\n"
      "[telemetry.rates]\naxis_telemetry = \"full\"\naxis_batch = \"change\"\nline_status = \"4 Hz\"\n"
      "event = \"off\"\nslave = \"change\"\njoint_states = \"300 Hz\"\ndiagnostics = \"0.5 Hz\"\n");
  const auto& telemetry = config.telemetry;
  EXPECT_EQ(telemetry.partition, "hall2/press");
  EXPECT_THAT(telemetry.peers, testing::ElementsAre("192.0.2.7"));
  EXPECT_EQ(telemetry.qos_profiles->filename(), "qos.xml");
  EXPECT_FALSE(telemetry.discovery_server);
  using Kind = TopicRate::Kind;
  using snapshot::FeedTopic;
  const auto rate = [&](FeedTopic topic) { return telemetry.rates[static_cast<std::size_t>(topic)]; };
  EXPECT_EQ(rate(FeedTopic::kAxisTelemetry).kind, Kind::kCycles);
  EXPECT_EQ(rate(FeedTopic::kAxisTelemetry).cycles, 1U);
  EXPECT_EQ(rate(FeedTopic::kAxisBatch).kind, Kind::kOnChange);
  EXPECT_EQ(rate(FeedTopic::kLineStatus).kind, Kind::kPeriod);
  EXPECT_EQ(rate(FeedTopic::kLineStatus).period, std::chrono::milliseconds{250});
  EXPECT_EQ(rate(FeedTopic::kEvent).kind, Kind::kOff);
  EXPECT_EQ(rate(FeedTopic::kSlave).kind, Kind::kOnChange);
  EXPECT_EQ(rate(FeedTopic::kTopology).kind, Kind::kDefault);
  EXPECT_EQ(rate(FeedTopic::kJointStates).cycles, 7U) << "2000 Hz by 300 Hz, to the nearest";
  EXPECT_EQ(rate(FeedTopic::kDiagnostics).period, std::chrono::seconds{2});
  const auto faster = parsed("[[slave]]\nname = \"x\"\n[telemetry.rates]\naxis_telemetry = \"10000 Hz\"\n");
  EXPECT_EQ(faster.telemetry.rates[0].cycles, 1U) << "no faster than the cycle";
}

TEST(LineConfig, TelemetryMayHaveADiscoveryServer) {
  const auto config =
      parsed("[[slave]]\nname = \"x\"\n[telemetry]\ninterfaces = []\ndiscovery_server = \"192.0.2.1:11811\"\n");
  ASSERT_TRUE(config.telemetry.discovery_server);
  EXPECT_EQ(config.telemetry.discovery_server->address, "192.0.2.1");
  EXPECT_EQ(config.telemetry.discovery_server->port, 11811);
}

TEST(LineConfig, TheBridgeMayBelongToAUserWhoHasSharedMemory) {
  const auto telemetry_of = [](const std::string& user) {
    return parsed("[[slave]]\nname = \"x\"\n[telemetry]\nshared_memory = true\nuser = \"" + user + "\"\n").telemetry;
  };
  const auto by_name = telemetry_of("daemon");
  EXPECT_TRUE(by_name.shared_memory);
  ASSERT_TRUE(by_name.user);
  EXPECT_EQ(by_name.user->user, 1U);
  EXPECT_EQ(by_name.user->group, 1U);
  const auto by_number = telemetry_of("1");
  ASSERT_TRUE(by_number.user);
  EXPECT_EQ(by_number.user->user, 1U);
  EXPECT_EQ(by_number.user->group, 1U);
  // A number without a name matches only the same number.
  const auto nameless = telemetry_of("4000000001");
  ASSERT_TRUE(nameless.user);
  EXPECT_EQ(nameless.user->user, 4'000'000'001U);
  EXPECT_EQ(nameless.user->group, 4'000'000'001U);
}

TEST(LineConfig, AnAxisHasItsRangeInItsUnit) {
  const auto config = parsed(
      "[[slave]]\nname = \"x\"\n[[slave]]\nname = \"y\"\n"
      "[[axis]]\nname = \"x\"\nunit = \"deg\"\nmin_position = -90\nmax_position = 180\n"
      "[[axis]]\nname = \"y\"\nunit = \"deg\"\nincrements_per_revolution = 1000000\nmodulo = 360\n");
  const auto& x = config.axes[0];
  ASSERT_TRUE(x.software_limits);
  EXPECT_NEAR(x.software_limits->min, -std::numbers::pi / 2, 1e-12);
  EXPECT_NEAR(x.software_limits->max, std::numbers::pi, 1e-12);
  EXPECT_EQ(x.range_max, 0) << "no modulo";
  EXPECT_FALSE(x.modulo);
  EXPECT_FALSE(config.axes[1].software_limits);
  EXPECT_EQ(config.axes[1].range_min, 0);
  EXPECT_EQ(config.axes[1].range_max, 999'999);
  EXPECT_NEAR(config.axes[1].modulo.value(), 2.0 * std::numbers::pi, 1e-12);
}

TEST(LineConfig, AnAxisCountsAsItsDriveOrAgainstIt) {
  for (const auto& [key, reversed] :
       {std::pair{"", false}, {"polarity = \"normal\"\n", false}, {"polarity = \"reversed\"\n", true}}) {
    const auto config = parsed(std::string("[[slave]]\nname = \"x\"\n[[axis]]\nname = \"x\"\n") + key);
    EXPECT_EQ(config.axes[0].reversed, reversed) << key;
    EXPECT_GT(config.axes[0].increments_per_unit, 0.0);
  }
}

TEST(LineConfig, LaunchTimesArriveInMicroseconds) {
  EXPECT_EQ(parsed("[bus]\nlaunch_ahead_us = 31.25\n[[slave]]\nname = \"x\"\n").launch_ahead,
            std::chrono::nanoseconds{31'250});
  EXPECT_EQ(parsed("[[slave]]\nname = \"x\"\n").launch_ahead, std::nullopt);
}

TEST(LineConfig, EveryKeyArrives) {
  const auto config = parsed(R"(
[line]
name = "press"
cycle_us = 250
[bus]
interface = "eth1"
interface2 = "eth2"
port = "xdp"
max_lost_cycles = 20
[recovery]
axes = "continue"
give_up_s = 0
[realtime]
policy = "degrade"
priority = 42
cpu = 3
simulation_cpu = 2
lock_memory = false
cpu_latency_us = 40
wake_ahead_us = 12.5
receive = "block"
[path]
file = "paths/a.csv"
interpolation = "natural"
repeat = true
late = "catch_up"
[telemetry]
enabled = false
domain = 17
decimation = 1
interfaces = []
ros2 = true
[output]
directory = "results"
plots = false
capture = "c.pcapng"
[[slave]]
name = "drive 1"
model = "msd"
vendor_id = 0x28
product_code = 0x4D534431
[slave.plant]
inertia_kg_m2 = 0.002
coulomb_friction_nm = 0.5
viscous_friction_nm_s = 0.01
initial_position_rev = -2.5
[[slave]]
name = "drive 2"
[[axis]]
name = "z"
slave = "drive 2"
mode = "cst"
feed_mm_per_revolution = 10
increments_per_revolution = 65536
rated_force_n = 300
max_velocity = 2
max_acceleration = 30.5
inertia = 12
position_gain_1_s = 33
velocity_gain = 4000
)",
                             "plant/line.toml");
  EXPECT_EQ(config.name, "press");
  EXPECT_EQ(config.period, microseconds{250});
  EXPECT_EQ(config.interface, "eth1");
  EXPECT_EQ(config.interface2, "eth2");
  EXPECT_EQ(config.port, port::PortChoice::kXdp);
  EXPECT_EQ(config.recovery.axes, motion::LossPolicy::kContinue);
  EXPECT_EQ(config.recovery.give_up, std::chrono::seconds{0});
  EXPECT_EQ(config.max_lost_cycles, 20U);
  EXPECT_EQ(config.policy, rt::RealtimePolicy::kDegrade);
  EXPECT_EQ(config.realtime.priority, 42);
  EXPECT_EQ(config.realtime.cpu, 3);
  EXPECT_EQ(config.simulation_cpu, 2);
  EXPECT_FALSE(config.realtime.lock_memory);
  EXPECT_EQ(config.realtime.cpu_latency, microseconds{40});
  EXPECT_EQ(config.wake_ahead, std::chrono::nanoseconds{12500});
  EXPECT_EQ(config.receive, ecat_master::ReceiveStrategy::kBlock);
  ASSERT_TRUE(config.path);
  EXPECT_EQ(config.path->file, "plant/paths/a.csv") << "relative to the line description";
  EXPECT_EQ(config.path->interpolation, trajectory::InterpolationMethod::kNaturalSpline);
  EXPECT_TRUE(config.path->repeat);
  EXPECT_EQ(config.path->late, motion::LatePolicy::kCatchUp);
  EXPECT_FALSE(config.telemetry.enabled);
  EXPECT_EQ(config.telemetry.domain, 17U);
  EXPECT_EQ(config.telemetry.decimation, 1U);
  EXPECT_TRUE(config.telemetry.interfaces.empty());
  EXPECT_TRUE(config.telemetry.ros2);
  EXPECT_EQ(config.output.directory, "results") << "relative to the working directory";
  EXPECT_FALSE(config.output.plots);
  EXPECT_EQ(config.output.capture, "c.pcapng");

  ASSERT_EQ(config.slaves.size(), 2U);
  EXPECT_EQ(config.slaves[0].vendor_id, 0x28U);
  EXPECT_EQ(config.slaves[0].product_code, 0x4D534431U);
  EXPECT_EQ(msd_of(config.slaves[0]).motor.inertia_kg_m2, 0.002);
  EXPECT_EQ(msd_of(config.slaves[0]).motor.coulomb_friction_nm, 0.5);
  EXPECT_EQ(msd_of(config.slaves[0]).motor.viscous_friction_nm_s, 0.01);
  EXPECT_DOUBLE_EQ(msd_of(config.slaves[0]).initial_position_rad, -5.0 * std::numbers::pi);

  ASSERT_EQ(config.axes.size(), 1U);
  const auto& axis = config.axes[0];
  EXPECT_EQ(axis.slave, 1U);
  EXPECT_EQ(axis.mode, Mode::kCyclicTorque);
  EXPECT_TRUE(axis.linear());
  EXPECT_DOUBLE_EQ(axis.increments_per_unit, 65536 / 0.010);
  EXPECT_EQ(axis.rated_torque, 300.0);
  EXPECT_EQ(axis.limits.max_velocity, 2.0);
  EXPECT_EQ(axis.limits.max_acceleration, 30.5);
  EXPECT_EQ(axis.inertia, 12.0);
  EXPECT_EQ(axis.position_gain_1_s, 33.0);
  EXPECT_EQ(axis.velocity_gain, 4000.0);
}

TEST(LineConfig, FrictionAndGravityAreForTheFeedForward) {
  const std::string begin = "[[slave]]\nname = \"x\"\n[[axis]]\nname = \"x\"\n";
  EXPECT_FALSE(parsed(begin + "inertia = 1\n").axes[0].feed_forward.any());
  const auto axis = parsed(begin +
                           "unit = \"deg\"\nmax_velocity = 18000\nviscous_friction = 1e-3\ncoulomb_friction = 0.5\n"
                           "gravity = -2\npendulum = 3\npendulum_zero = 90\n")
                        .axes[0];
  EXPECT_EQ(axis.feed_forward.viscous_friction, 1e-3);
  EXPECT_EQ(axis.feed_forward.coulomb_friction, 0.5);
  EXPECT_DOUBLE_EQ(axis.feed_forward.coulomb_velocity, std::numbers::pi / 10.0) << "a thousandth of the highest";
  EXPECT_EQ(axis.feed_forward.gravity, -2.0);
  EXPECT_EQ(axis.feed_forward.pendulum, 3.0);
  EXPECT_DOUBLE_EQ(axis.feed_forward.pendulum_zero, std::numbers::pi / 2.0);
  EXPECT_EQ(parsed(begin + "coulomb_velocity = 2.5\n").axes[0].feed_forward.coulomb_velocity, 2.5);
}

TEST(LineConfig, DeadTimesAreCompensatedOnRequest) {
  const std::string begin = "[[slave]]\nname = \"x\"\n";
  EXPECT_FALSE(compensates_dead_time(parsed(begin)));
  EXPECT_FALSE(compensates_dead_time(parsed(begin + "[path]\nfile = \"a.csv\"\n")));
  EXPECT_TRUE(compensates_dead_time(parsed(begin + "[path]\nfile = \"a.csv\"\ndead_time = \"compensated\"\n")));
}

TEST(LineConfig, LostCyclesMayBeWrittenAsTime) {
  const std::string slave = "[[slave]]\nname = \"x\"\n";
  EXPECT_EQ(max_lost_text(lost_limit(parsed(slave))), "the 8 cycles that [bus] max_lost_cycles allows");
  const auto whole = parsed("[bus]\nmax_lost_ms = 50\n" + slave);
  EXPECT_EQ(whole.max_lost_cycles, 400U);
  EXPECT_EQ(max_lost_text(lost_limit(whole)), "the 50 ms that [bus] max_lost_ms allows");
  EXPECT_EQ(parsed("[line]\ncycle_us = 250\n[bus]\nmax_lost_ms = 50\n" + slave).max_lost_cycles, 200U);
  EXPECT_EQ(parsed("[bus]\nmax_lost_ms = 0.374\n" + slave).max_lost_cycles, 2U) << "no longer than what is written";
  EXPECT_EQ(parsed("[bus]\nmax_lost_ms = 0.125\n" + slave).max_lost_cycles, 1U);
  EXPECT_EQ(parsed("[bus]\nmax_lost_ms = 1.125\n" + slave).max_lost_cycles, 9U);
}

TEST(LineConfig, AbsolutePathStaysAsItIs) {
  EXPECT_EQ(parsed("[[slave]]\nname=\"x\"\n[path]\nfile=\"/data/a.csv\"\n", "plant/line.toml").path->file,
            "/data/a.csv");
}

TEST(LineConfig, RotaryAxisCountsInRadians) {
  const auto config = parsed(
      "[[slave]]\nname = \"x\"\n[[axis]]\nname = \"x\"\nincrements_per_revolution = 4096\nrated_torque_nm = 7.5\n"
      "mode = \"csv\"\n[path]\nfile = \"a.csv\"\n");
  EXPECT_FALSE(config.axes[0].linear());
  EXPECT_DOUBLE_EQ(config.axes[0].increments_per_unit, 4096 / (2 * std::numbers::pi));
  EXPECT_EQ(config.axes[0].rated_torque, 7.5);
  EXPECT_EQ(config.axes[0].mode, Mode::kCyclicVelocity);
}

TEST(LineConfig, ATorqueLimitIsThereWhereItIsAskedFor) {
  const std::string line = "[[slave]]\nname = \"x\"\n[[axis]]\nname = \"x\"\n";
  EXPECT_FALSE(parsed(line).axes[0].max_torque);
  EXPECT_EQ(parsed(line + "max_torque = 1.5\n").axes[0].max_torque, 1.5);
}

TEST(LineConfig, FollowingErrorIsWatchedWhereThatIsAskedFor) {
  const std::string line = "[[slave]]\nname = \"x\"\n[[axis]]\nname = \"x\"\nunit = \"deg\"\n";
  EXPECT_FALSE(parsed(line).axes[0].following_error_window);
  const auto watched = parsed(line + "following_error_window = 18\n").axes[0];
  EXPECT_DOUBLE_EQ(watched.following_error_window.value(), 0.1 * std::numbers::pi);
  EXPECT_EQ(watched.following_error_timeout, std::chrono::milliseconds{10});
  const auto later = parsed(line + "following_error_window = 18\nfollowing_error_timeout_ms = 250\n").axes[0];
  EXPECT_EQ(later.following_error_timeout, std::chrono::milliseconds{250});
}

TEST(LineConfig, LimitsAreInTheUnitOfTheAxis) {
  const std::string line =
      "[[slave]]\nname = \"x\"\n[[axis]]\nname = \"x\"\nmax_velocity = 720\nmax_acceleration = 3600\n"
      "position_tolerance = 18\n";
  const auto si = parsed(line).axes[0];
  EXPECT_EQ(si.limits.max_velocity, 720.0);
  EXPECT_EQ(motion::position_unit(si).name, "rad");
  const auto degrees = parsed(line + "unit = \"deg\"\n").axes[0];
  EXPECT_DOUBLE_EQ(degrees.limits.max_velocity, 4.0 * std::numbers::pi);
  EXPECT_DOUBLE_EQ(degrees.limits.max_acceleration, 20.0 * std::numbers::pi);
  EXPECT_DOUBLE_EQ(degrees.position_tolerance.value(), 0.1 * std::numbers::pi);
  EXPECT_EQ(motion::position_unit(degrees).name, "deg");
  const auto mm = parsed(line + "unit = \"mm\"\nfeed_mm_per_revolution = 10\n").axes[0];
  EXPECT_DOUBLE_EQ(mm.limits.max_velocity, 0.72);
  EXPECT_DOUBLE_EQ(mm.increments_per_unit, 1048576 / 0.01) << "of a metre, whatever people read";
  const auto left_out = parsed("[[slave]]\nname = \"x\"\n[[axis]]\nname = \"x\"\nunit = \"rev\"\n").axes[0];
  EXPECT_EQ(left_out.limits.max_velocity, 200.0) << "what is left out is as without a unit";
}

TEST(LineConfig, ExampleIsEightMsdAxes) {
  const auto config = load_line_config(DRIVELINE_EXAMPLES_DIR "/line8.toml");
  ASSERT_TRUE(config) << describe(config.error());
  EXPECT_EQ(config->period, microseconds{125});
  EXPECT_EQ(config->slaves.size(), 8U);
  EXPECT_EQ(config->axes.size(), 8U);
}

TEST(LineConfig, ExampleForTwoProcessesIsTheSameLine) {
  const auto one = load_line_config(DRIVELINE_EXAMPLES_DIR "/line8.toml");
  const auto two = load_line_config(DRIVELINE_EXAMPLES_DIR "/line8-nic.toml");
  ASSERT_TRUE(one) << describe(one.error());
  ASSERT_TRUE(two) << describe(two.error());
  EXPECT_EQ(one->name, two->name);
  EXPECT_EQ(one->period, two->period);
  EXPECT_TRUE(std::filesystem::equivalent(one->path->file, two->path->file));
  EXPECT_EQ(one->path->interpolation, two->path->interpolation);
  ASSERT_EQ(one->slaves.size(), two->slaves.size());
  for (std::size_t i = 0; i < one->slaves.size(); ++i) {
    EXPECT_EQ(one->slaves[i].name, two->slaves[i].name);
    EXPECT_EQ(msd_of(one->slaves[i]).variant, msd_of(two->slaves[i]).variant);
  }
  ASSERT_EQ(one->axes.size(), two->axes.size());
  for (std::size_t i = 0; i < one->axes.size(); ++i) {
    const auto& a = one->axes[i];
    const auto& b = two->axes[i];
    EXPECT_EQ(a.name, b.name);
    EXPECT_EQ(a.slave, b.slave);
    EXPECT_EQ(a.mode, b.mode);
    EXPECT_EQ(a.inertia, b.inertia);
    EXPECT_EQ(a.increments_per_unit, b.increments_per_unit);
    EXPECT_EQ(a.limits.max_velocity, b.limits.max_velocity);
    EXPECT_EQ(a.limits.max_acceleration, b.limits.max_acceleration);
  }
  // The two processes do not share a core.
  EXPECT_TRUE(two->realtime.cpu);
  EXPECT_TRUE(two->simulation_cpu);
  EXPECT_NE(two->realtime.cpu, two->simulation_cpu);
}

TEST(LineConfig, TorqueModeTakesItsVelocityGainFromTheInertia) {
  const auto gain = [](const std::string& line, const std::string& axis) {
    const auto config = parse_line_config(
        line + "[[slave]]\nname = \"x\"\n[[axis]]\nname = \"x\"\nmode = \"cst\"\n" + axis, "line.toml");
    EXPECT_TRUE(config) << describe(config.error());
    return config->axes.at(0).velocity_gain;
  };
  EXPECT_DOUBLE_EQ(gain("", "inertia = 3e-4\n"), 0.03);
  EXPECT_DOUBLE_EQ(gain("[line]\ncycle_us = 10000\n", "inertia = 3e-4\n"), 3e-4 * 20)
      << "for a loop with long dead time";
  EXPECT_DOUBLE_EQ(
      gain("[line]\ncycle_us = 1000\n[[group]]\nname = \"g\"\nslaves = [\"x\"]\ndivider = 10\n", "inertia = 3e-4\n"),
      3e-4 * 20)
      << "the exchange counts";
  EXPECT_DOUBLE_EQ(gain("", "inertia = 3e-4\nvelocity_gain = 0.2\n"), 0.2);
}

}  // namespace
}  // namespace driveline::runtime
