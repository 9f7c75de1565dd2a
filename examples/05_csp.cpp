// One simulated drive on virtual time: from the first frame to OP, ten revolutions, and back to INIT.
// With a RawSocketPort, a MonotonicClock and a RealtimeRunner the same calls drive a real line.

#include <cstdio>
#include <memory>
#include <numbers>

#include "driveline/ecat_master/master.hpp"
#include "driveline/motion/path/motion.hpp"
#include "driveline/runtime/devices/device_registry.hpp"
#include "driveline/slaves/line/simulated_line.hpp"
#include "driveline/slaves/msd/msd_drive.hpp"

using namespace driveline;
using namespace std::chrono_literals;

int main() {
  rt::VirtualClock clock;
  std::vector<std::unique_ptr<slaves::Slave>> slaves;
  slaves.push_back(std::make_unique<slaves::Slave>(std::make_unique<slaves::msd::MsdDrive>()));
  const auto& drive = static_cast<slaves::msd::MsdDrive&>(slaves.front()->device()).core();
  slaves::SimulatedLine line(clock, std::move(slaves));

  // Identity of the slave, its start-up SDOs, and the objects to exchange.
  motion::AxisConfig config;
  config.name = "x";
  const runtime::DeviceRegistry devices;
  const auto& rules = devices.rules_for({slaves::msd::kVendorId, slaves::msd::kProductCode});
  ecat_master::SlavePlan plan;
  plan.startup_sdos = rules.startup_sdos(config, 125us);
  plan.pdos = motion::axis_pdo_configuration();

  ecat_master::Master master(line, clock);
  auto done = master.scan();
  if (done) done = master.configure({plan});

  // Ten revolutions in one second, with a pause at both ends.
  const auto path = trajectory::parse_path_csv("time[s],x[rev]\n0,0\n0.1,0\n1.1,10\n1.2,10\n", "path");
  std::vector<motion::Axis> axes;
  if (done) axes.emplace_back(config, master.image().places()[0].image_place(), plan.pdos);
  if (!done || !path) {
    std::puts(done ? trajectory::describe(path.error()).c_str() : ecat_master::describe(done.error()).c_str());
    return 1;
  }
  motion::Motion motion(std::move(axes), trajectory::Interpolator::clamped_spline(*path), {});
  const auto started = master.start_cycle(&motion, {}, {}, [&clock](ecat_master::CyclicCore& core) {
    return std::make_unique<motion::InlineRunner>(core, clock);
  });
  if (!started || !master.go_operational()) return 1;

  motion.request_start();
  for (int i = 0; i < 300 && motion.phase() != motion::MotionPhase::kHolding; ++i) master.pass(10ms);
  const double revolutions = drive.position_rad() / (2.0 * std::numbers::pi);
  std::printf("%s after %.3f revolutions\n", std::string(to_text(motion.phase())).c_str(), revolutions);

  motion.request_stop();
  master.pass(200ms);
  if (!master.shut_down()) return 1;
  return revolutions > 9.99 && revolutions < 10.01 ? 0 : 1;
}
