// The MSD drives on a network interface: from the first frame to OP, every axis turns forth and back, then shutdown.
//   06_interface eth1            the axes are enabled and hold their positions
//   06_interface eth1 0.5        half a turn of the motors forth and back, in four seconds
// As root or with CAP_NET_RAW, CAP_SYS_NICE and CAP_IPC_LOCK. Ctrl-C stops the axes with a ramp. Without hardware:
//   scripts/veth.sh up && driveline simulate --config line8-nic.toml --iface dl-line &  06_interface dl-master 0.5

#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <memory>
#include <numbers>

#include "driveline/ecat_master/master.hpp"
#include "driveline/motion/cia402/error_code.hpp"
#include "driveline/motion/path/motion.hpp"
#include "driveline/port/interface_lock.hpp"
#include "driveline/port/raw_socket_port.hpp"
#include "driveline/runtime/devices/device_registry.hpp"

using namespace driveline;
using namespace std::chrono_literals;

namespace {

constexpr std::chrono::nanoseconds kPeriod = 1ms;
constexpr double kRevolution = 2.0 * std::numbers::pi;
constexpr std::uint32_t kMoog = 0x28;  // vendor of the MSD: 1018h:01

volatile std::sig_atomic_t interrupted = 0;

int fail(const std::string& sentence) {
  std::fprintf(stderr, "06_interface: %s\n", sentence.c_str());
  return 1;
}

/// Relative to the present positions: `revolutions` forth in two seconds, and back.
tl::expected<trajectory::Interpolator, std::string> make_path(std::size_t axes, double revolutions) {
  trajectory::PathBuilder builder;
  for (std::size_t i = 0; i < axes; ++i) {
    if (auto added = builder.add_axis({"axis" + std::to_string(i)}); !added)
      return tl::unexpected(added.error().reason);
  }
  const double there = revolutions * kRevolution;
  for (const auto& [time_s, position] : {std::pair{0.0, 0.0}, {2.0, there}, {4.0, 0.0}}) {
    const auto added = builder.add_point(time_s, std::vector<double>(axes, position));
    if (!added) return tl::unexpected(added.error().reason);
  }
  return trajectory::Interpolator::clamped_spline(*builder.build());
}

/// Whether the motion continues. Without revolutions the axes hold their positions until Ctrl-C. An axis that fails
/// stops all of them.
bool goes_on(motion::MotionPhase phase, double revolutions) {
  using Phase = motion::MotionPhase;
  if (phase == Phase::kHolding) return revolutions == 0.0;
  return phase == Phase::kEnabling || phase == Phase::kApproach || phase == Phase::kFollowing;
}

std::string describe(const motion::MotionFailure& failure) {
  using Cause = motion::MotionFailure::Cause;
  if (failure.cause == Cause::kAxisFault) return "fault " + motion::cia402::error_text(failure.error_code);
  if (failure.cause == Cause::kCommunication) return "no valid process data for too long";
  if (failure.cause == Cause::kMasterAway) return "the master was away for too long";
  return failure.cause == Cause::kEnableTimeout ? "was not enabled in time"
                                                : "is outside its position window or out of operation";
}

}  // namespace

int main(int argc, char** argv) {
  if (argc < 2 || argc > 3) {
    std::fputs("usage: 06_interface INTERFACE [REVOLUTIONS]\n", stderr);
    return 2;
  }
  const double revolutions = argc > 2 ? std::atof(argv[2]) : 0.0;
  for (const int number : {SIGINT, SIGTERM}) std::signal(number, [](int) { interrupted = 1; });

  rt::MonotonicClock clock;
  const auto lock = port::InterfaceLock::take(argv[1]);  // an interface has a single master
  if (!lock) return fail(std::string(argv[1]) + " has a master already");
  const auto port = port::RawSocketPort::open({argv[1]}, clock);
  if (!port) return fail(port::describe(port.error()));
  ecat_master::Master master(**port, clock);
  if (const auto found = master.scan(); !found) return fail(ecat_master::describe(found.error()));

  const runtime::DeviceRegistry devices;
  // One axis per drive. The limits are those of the machine, not of the motor.
  std::vector<motion::AxisConfig> configs;
  std::vector<ecat_master::SlavePlan> plans;
  for (const auto& slave : master.slaves()) {
    const auto& found = slave.info.description;
    if (found.vendor_id != kMoog) return fail("only MSD drives are expected here: write a line description");
    auto& axis = configs.emplace_back();
    axis.slave = plans.size();
    axis.name = "axis" + std::to_string(axis.slave);
    axis.limits = {.max_velocity = 2.0 * kRevolution, .max_acceleration = 10.0 * kRevolution};
    auto& plan = plans.emplace_back();
    plan.name = axis.name;
    plan.startup_sdos = devices.rules_for({found.vendor_id, found.product_code}).startup_sdos(axis, kPeriod);
    plan.pdos = motion::axis_pdo_configuration();
  }
  auto path = make_path(configs.size(), revolutions);
  if (!path) return fail(path.error());
  std::vector<trajectory::AxisLimits> limits;
  for (const auto& axis : configs) limits.push_back(axis.limits);
  if (const auto checked = trajectory::check_limits(*path, limits, 1e-3); !checked)
    return fail(trajectory::describe(checked.error()));
  if (const auto done = master.configure(plans); !done) return fail(ecat_master::describe(done.error()));

  std::vector<motion::Axis> axes;
  for (const auto& axis : configs)
    axes.emplace_back(axis, master.image().places()[axis.slave].image_place(), plans[axis.slave].pdos);
  motion::Motion::Settings settings{.period = kPeriod, .relative = true};
  settings.bad_cycle_limit = 20;  // 20 ms; the watchdogs of the drives are the second line of defence
  motion::Motion motion(std::move(axes), std::move(*path), settings);
  ecat_master::CyclicCore::Settings cycle;
  cycle.period = kPeriod;
  cycle.receive_window = kPeriod * 8 / 10;
  rt::RealtimeConfig realtime;
  realtime.policy = rt::RealtimePolicy::kDegrade;  // kEnforce refuses to start if a setting is not in effect
  const auto started = master.start_cycle(&motion, {}, cycle, [&](ecat_master::CyclicCore& core) {
    return std::make_unique<motion::RealtimeRunner>(core, clock, realtime, 0us);
  });
  if (!started) return fail(rt::describe(started.error()));
  for (const auto& line : rt::to_lines(static_cast<motion::RealtimeRunner*>(master.runner())->report()))
    std::puts(line.c_str());
  if (const auto up = master.go_operational(); !up) return fail(ecat_master::describe(up.error()));

  motion.request_start();
  using Phase = motion::MotionPhase;
  for (int i = 0; i < 100 && motion.phase() == Phase::kIdle; ++i) master.pass(10ms);  // takes effect in the next cycle
  while (interrupted == 0 && goes_on(motion.phase(), revolutions)) master.pass(50ms);
  motion.request_stop();
  for (int i = 0; i < 100 && motion.phase() != Phase::kIdle; ++i) master.pass(50ms);
  const auto& statistics = master.core()->statistics();
  std::printf("%zu axes, %llu cycles, %llu periods missed, %llu frames lost\n", configs.size(),
              static_cast<unsigned long long>(statistics.cycles),
              static_cast<unsigned long long>(statistics.missed_periods),
              static_cast<unsigned long long>(statistics.lost_frames));
  const auto down = master.shut_down();
  if (const auto failure = motion.failure(); failure.cause != motion::MotionFailure::Cause::kNone) {
    return fail("all axes stopped: " + configs[failure.axis].name + ": " + describe(failure));
  }
  return down ? 0 : fail(ecat_master::describe(down.error()));
}
