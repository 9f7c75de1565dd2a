// How many axes can a line have? Measures time and memory of the master's part of a cycle for 1 to 256 axes at cycle
// times of 62.5 us to 4 ms, and what the cycle costs that stops all of them, and computes the limit of the wire.
#include <fmt/format.h>
#include <algorithm>
#include <array>
#include <cmath>
#include <ctime>
#include <memory>
#include <stdexcept>
#include <vector>

#include "driveline/rt/clock.hpp"
#include "driveline/rt/cycle_timer.hpp"
#include "driveline/rt/time_conversion.hpp"
#include "driveline/slaves/line/frame_path.hpp"
#include "support/environment.hpp"
#include "support/line_rig.hpp"
#include "support/realtime.hpp"
#include "support/report.hpp"
#include "support/stop_cost.hpp"
#include "support/stopwatch.hpp"

namespace {

using namespace driveline;
using namespace driveline::bench;
using ecat_master::ProcessImage;
using std::chrono::nanoseconds;

constexpr std::array<std::size_t, 9> kAxes = {1, 2, 4, 8, 16, 32, 64, 128, 256};
constexpr std::array<double, 7> kCyclesUs = {62.5, 125, 250, 500, 1000, 2000, 4000};
/// For each number of axes and cycle time.
constexpr int kCycles = 1000;
constexpr int kWarmUp = 10;
constexpr std::array<std::size_t, 3> kStoppedAxes = {8, 32, 256};
/// Stops of all axes, for each number of axes and each load.
constexpr int kStops = 100;
/// Largest number of axes for which the wire time is computed.
constexpr std::size_t kMaxOnTheWire = 1024;
constexpr double kNsPerUs = 1000.0;

/// Runs cycles at instants of real time, asleep in between, while the line runs on virtual time: a cycle finds the same
/// caches as on a real line, however long the simulated drives took for the previous one.
class WallPace final : public motion::CycleRunner {
 public:
  WallPace(ecat_master::CyclicCore& core, rt::Clock& clock, LineRig& rig)
      : core_(core), clock_(clock), rig_(rig), timer_(clock, LineRig::kPeriod) {}

  [[nodiscard]] tl::expected<void, rt::RealtimeError> start() override { return {}; }
  void pass(nanoseconds duration) override {
    const auto end = clock_.now() + duration;
    do {
      core_.cycle(timer_.wait_next());
      rig_.drain();
    } while (clock_.now() < end);
    rests_.take_when_due(now_ns());
  }
  void stop() override {}

  /// Costs of the master's part in `cycles` cycles, one every `cycle_ns`, in ns. If the drives take longer than that,
  /// the cycles follow without a pause.
  std::vector<double> measure(double cycle_ns, int cycles) {
    std::vector<double> costs_ns;
    double next_ns = now_ns() + cycle_ns;
    for (int i = -kWarmUp; i < cycles; ++i) {
      sleep_until(next_ns);
      rig_.port().reset(true);
      const double begin = now_ns();
      core_.cycle(timer_.wait_next());
      const double whole = now_ns() - begin - reading_cost_ns();
      const double cost_ns = whole - rig_.port().overhead_ns() - rig_.port().inside_ns();
      if (i >= 0) costs_ns.push_back(cost_ns);
      rig_.drain();
      if (rests_.take_when_due(now_ns())) next_ns = now_ns();
      next_ns = std::max(next_ns + cycle_ns, now_ns());
    }
    rig_.port().reset(false);
    return costs_ns;
  }

 private:
  static void sleep_until(double time_ns) noexcept {
    const auto until = rt::to_timespec(nanoseconds{static_cast<std::int64_t>(time_ns)});
    while (clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &until, nullptr) == EINTR) {
    }
  }

  ecat_master::CyclicCore& core_;
  rt::Clock& clock_;
  LineRig& rig_;
  rt::CycleTimer timer_;
  Rests rests_;
};

/// The cost of a number of axes.
struct Line {
  std::size_t axes = 0;
  std::vector<Summary> master_ns{};  ///< by cycle time
  double heap_kib = 0.0;             ///< heap of the master
};

/// Process data sizes of a drive, in bytes.
struct DriveBytes {
  std::size_t outputs = 0;
  std::size_t inputs = 0;
};

Line measure_line(std::size_t axes, int cycles, DriveBytes& bytes) {
  fmt::print(stderr, "scale: {} axes ...\n", axes);
  const auto all = static_cast<int>(kCyclesUs.size()) * (cycles + kWarmUp);
  rt::VirtualClock clock;
  LineRig rig(clock, axes, all * LineRig::kPeriod + std::chrono::seconds{1});
  WallPace* pace = nullptr;
  rig.bring_up([&](ecat_master::CyclicCore& core) -> std::unique_ptr<motion::CycleRunner> {
    auto runner = std::make_unique<WallPace>(core, clock, rig);
    pace = runner.get();
    return runner;
  });
  const auto& place = rig.master().image().places().front();
  bytes = {place.output_bytes, place.input_bytes};
  Line line{axes};
  line.heap_kib = static_cast<double>(rig.heap_of_master()) / 1024.0;
  for (const double cycle_us : kCyclesUs) {
    line.master_ns.push_back(summarize(pace->measure(cycle_us * kNsPerUs, cycles)));
  }
  rig.check();
  return line;
}

/// The time of a cycle on a line of 100 Mbit/s, in us.
struct OnTheWire {
  double frames_us = 0.0;  ///< with preamble, FCS and gap
  double way_us = 0.0;     ///< delay of the last frame through all slaves and cables, as on simulated lines

  [[nodiscard]] double total_us() const noexcept { return frames_us + way_us; }
};

OnTheWire on_the_wire(std::size_t axes, DriveBytes bytes) {
  ecat_master::ProcessDataDemand demand;
  demand.channels = {{true, 2, 0x1100, bytes.outputs}, {false, 3, 0x1400, bytes.inputs}};
  demand.al_status = true;
  const auto image = ProcessImage::lay_out(std::vector(axes, demand));
  if (!image) throw std::runtime_error(ecat_master::describe(image.error()));
  // Close the ports without a cable.
  const auto wiring = slaves::Wiring::line(axes, slaves::LineOptions{}.cable_delay);
  std::vector<slaves::SlavePorts> ports(axes);
  for (std::size_t slave = 0; slave < axes; ++slave) {
    for (unsigned port = 0; port < slaves::kPortCount; ++port) {
      ports[slave].closed[port] = wiring.at({slave, port}).kind == slaves::Wiring::End::Kind::kNothing;
    }
  }
  slaves::FramePath path;
  path.trace(wiring, ports, slaves::MasterPort::kPrimary);
  return {static_cast<double>(ecat_master::wire_time_ns(*image, true)) / kNsPerUs,
          static_cast<double>(path.delay().count()) / kNsPerUs};
}

/// The largest number of axes from 1 to `most` that fits, for a monotonic `fits`; 0: not even one fits.
template <typename Fits>
std::size_t most_that_fit(std::size_t most, const Fits& fits) {
  std::size_t low = 0;
  std::size_t high = most;
  while (low < high) {
    const auto middle = (low + high + 1) / 2;
    if (fits(middle)) {
      low = middle;
    } else {
      high = middle - 1;
    }
  }
  return low;
}

/// Cost of the master's part in 99 of 100 cycles, in us, linearly interpolated between the measured numbers of axes.
double master_us(const std::vector<Line>& lines, std::size_t cycle, std::size_t axes) {
  const auto cost = [cycle](const Line& line) { return line.master_ns[cycle].p99 / kNsPerUs; };
  const auto above = std::find_if(lines.begin(), lines.end(), [axes](const Line& line) { return line.axes >= axes; });
  if (above == lines.begin() || above->axes == axes) return cost(*above);
  const auto below = std::prev(above);
  const double share = static_cast<double>(axes - below->axes) / static_cast<double>(above->axes - below->axes);
  // A disturbance must not make more axes cheaper.
  return cost(*below) + share * std::max(0.0, cost(*above) - cost(*below));
}

Summary just(double value) {
  return {1, value, value, value, value};
}

void report_lines(Report& report, const std::vector<Line>& lines, DriveBytes bytes) {
  for (const auto& line : lines) {
    const auto name = fmt::format("{}_axes", line.axes);
    const auto wire = on_the_wire(line.axes, bytes);
    report.add({name, "frames_on_the_wire", "us", just(wire.frames_us)});
    report.add({name, "way_through_the_line", "us", just(wire.way_us)});
    report.add({name, "memory_of_the_master", "KiB", just(line.heap_kib)});
    for (std::size_t i = 0; i < kCyclesUs.size(); ++i) {
      report.add({fmt::format("{}_every_{:g}_us", name, kCyclesUs[i]), "master_part", "us",
                  divided(line.master_ns[i], kNsPerUs)});
    }
  }
}

void report_limits(Report& report, const std::vector<Line>& lines, DriveBytes bytes) {
  for (std::size_t i = 0; i < kCyclesUs.size(); ++i) {
    const auto name = fmt::format("every_{:g}_us", kCyclesUs[i]);
    const auto limit = [&](const char* metric, std::size_t most, const auto& fits) {
      report.add({name, metric, "axes", just(static_cast<double>(most_that_fit(most, fits)))});
    };
    const auto fits_wire = [&](std::size_t axes) { return on_the_wire(axes, bytes).total_us() <= kCyclesUs[i]; };
    const auto fits_master = [&](std::size_t axes) { return master_us(lines, i, axes) <= kCyclesUs[i]; };
    limit("limit_of_the_wire", kMaxOnTheWire, fits_wire);
    limit("limit_of_this_machine", lines.back().axes, fits_master);
    limit("limit_of_both", lines.back().axes, [&](std::size_t axes) {
      return on_the_wire(axes, bytes).total_us() + master_us(lines, i, axes) <= kCyclesUs[i];
    });
  }
}

void report_stops(Report& report, std::size_t axes, StopLoad load, int stops) {
  const auto name = fmt::format("{}_axes{}", axes, load == StopLoad::kNothing ? "" : "_and_requests_that_wait");
  fmt::print(stderr, "scale: stops of {} ...\n", name);
  const auto costs = measure_stops(axes, load, stops);
  const auto moving = summarize(costs.moving.all());
  report.add({name, "cycle_of_moving_axes", "ns", moving});
  report.add(
      {name, "cycle_that_stops_all_axes", "ns", summarize(costs.stopping.all()), std::nullopt,
       Baseline{"cycle_of_moving_axes", moving, ratios_by_turn(costs.stopping.medians(), costs.moving.medians())}});
}

void measure_all(const Options& options) {
  Report report("scale");
  claim_cpu(last_cpu());
  std::vector<Line> lines;
  DriveBytes bytes;
  for (const auto axes : kAxes) lines.push_back(measure_line(axes, options.count(kCycles), bytes));
  report_lines(report, lines, bytes);
  report_limits(report, lines, bytes);
  for (const auto axes : kStoppedAxes) {
    for (const auto load : {StopLoad::kNothing, StopLoad::kRequests})
      report_stops(report, axes, load, options.count(kStops));
  }
  report.note(fmt::format(
      "MSD drives, {} bytes of outputs and {} of inputs each. master_part: a cycle without the time inside the port.\n"
      "limit_of_the_wire: frames one after the other, the last one through the line, at most {}.\n"
      "limit_of_this_machine: the master's part in 99 of 100 cycles fits the cycle; limit_of_both: one after the "
      "other.\n"
      "Both of at most {} axes, on the straight lines between what was measured.\n"
      "cycle_that_stops_all_axes: the master's part of the cycle that takes a stop of each axis, by turns with cycles\n"
      "of the same line without requests; and_requests_that_wait: the queue is full after 10,000 requests, and a move\n"
      "waits in each axis.",
      bytes.outputs, bytes.inputs, kMaxOnTheWire, lines.back().axes));
  report.print(options);
}

}  // namespace

int main(int argc, char** argv) {
  return run(
      argc, argv,
      "How many axes can a line have, by cycle time, machine and wire, and what does a stop of all of them cost?",
      measure_all);
}
