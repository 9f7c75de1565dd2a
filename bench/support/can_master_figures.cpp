#include "support/can_master_figures.hpp"

#include <optional>
#include <utility>
#include <vector>

#include "support/can_rig.hpp"
#include "support/realtime.hpp"
#include "support/samples.hpp"
#include "support/stopwatch.hpp"

namespace driveline::bench {
namespace {

using std::chrono::nanoseconds;

constexpr std::size_t kMasterAxes = 8;
constexpr nanoseconds kSyncPeriod = std::chrono::milliseconds{2};
constexpr int kCyclesPerTurn = 100;
constexpr double kMasterPartAim = 1.25;  ///< medians, over the part on EtherCAT
constexpr double kLineAim = 1.0;         ///< medians, over the line on EtherCAT

/// \name How a cycle is measured without the time inside its port
/// @{
double part_of(canopen::CanCycle& cycle, StagedCanPort& port, const rt::CycleStart& start) {
  port.stage();
  const double begin = now_ns();
  cycle.cycle(start);
  const double cost = now_ns() - begin - reading_cost_ns();
  const double part = cost - port.repeat_calls_ns();
  port.release();
  return part;
}

/// EtherCAT sends and receives within the cycle, in a few calls.
double part_of(ecat_master::CyclicCore& core, TimedPort& port, const rt::CycleStart& start) {
  port.reset(true);
  const double begin = now_ns();
  core.cycle(start);
  const double cost = now_ns() - begin - reading_cost_ns();
  const double part = cost - port.overhead_ns() - port.inside_ns();
  port.reset(false);
  return part;
}
/// @}

/// Runs cycles back to back on virtual time and, when it is asked to, measures the part of the master in each.
template <typename Cycle, typename Port, typename Rig>
class PartMeter final : public motion::CycleRunner {
 public:
  PartMeter(Cycle& cycle, Port& port, rt::Clock& clock, Rig& rig)
      : cycle_(cycle), port_(port), rig_(rig), clock_(clock), timer_(clock, kSyncPeriod) {}

  [[nodiscard]] tl::expected<void, rt::RealtimeError> start() override { return {}; }
  void pass(nanoseconds duration) override {
    const auto end = clock_.now() + duration;
    do {
      step(timer_.wait_next());
      rig_.drain();
    } while (clock_.now() < end);
  }
  void stop() override {}

  bool measures = false;
  std::vector<double> parts_ns;

 private:
  void step(const rt::CycleStart& start) {
    if (measures) {
      parts_ns.push_back(part_of(cycle_, port_, start));
    } else {
      cycle_.cycle(start);
    }
  }

  Cycle& cycle_;
  Port& port_;
  Rig& rig_;
  rt::Clock& clock_;
  rt::CycleTimer timer_;
};

/// A line in operation with its meter.
template <typename Rig, typename Cycle, typename Port>
struct MeasuredLine {
  using Meter = PartMeter<Cycle, Port, Rig>;

  /// Runs a turn; the time of each cycle with the whole line, in ns.
  double turn() {
    const double begin = now_ns();
    rig.master().pass(kCyclesPerTurn * kSyncPeriod - nanoseconds{1});
    return (now_ns() - begin) / kCyclesPerTurn;
  }
  /// Runs a turn in which the parts of the master are measured.
  std::vector<double> parts() {
    meter->measures = true;
    turn();
    meter->measures = false;
    return std::exchange(meter->parts_ns, {});
  }

  explicit MeasuredLine(nanoseconds duration);

  rt::VirtualClock clock;
  Rig rig;
  Meter* meter = nullptr;
};

using CanMeasured = MeasuredLine<CanRig, canopen::CanCycle, StagedCanPort>;
using EtherCatMeasured = MeasuredLine<LineRig, ecat_master::CyclicCore, TimedPort>;

template <>
CanMeasured::MeasuredLine(nanoseconds duration) : rig(clock, kMasterAxes, kSyncPeriod, duration) {
  rig.bring_up([this](canopen::CanCycle& cycle) {
    auto made = std::make_unique<Meter>(cycle, rig.port(), clock, rig);
    meter = made.get();
    return made;
  });
}

template <>
EtherCatMeasured::MeasuredLine(nanoseconds duration) : rig(clock, kMasterAxes, duration, kSyncPeriod) {
  rig.bring_up([this](ecat_master::CyclicCore& core) {
    auto made = std::make_unique<Meter>(core, rig.port(), clock, rig);
    meter = made.get();
    return made;
  });
}

}  // namespace

void measure_can_master(Report& report, int cycles) {
  const int turns = std::max(2, cycles / kCyclesPerTurn);
  const auto duration = (2 * turns + 4) * kCyclesPerTurn * kSyncPeriod + std::chrono::seconds{10};
  CanMeasured can(duration);
  EtherCatMeasured ethercat(duration);
  TurnSamples can_parts;
  TurnSamples ethercat_parts;
  TurnSamples can_lines;
  TurnSamples ethercat_lines;
  Rests rests;
  for (int turn = 0; turn < turns; ++turn) {
    rests.take_when_due(now_ns());
    can_parts.add_turn(can.parts());
    ethercat_parts.add_turn(ethercat.parts());
    can_lines.add_turn({can.turn()});
    ethercat_lines.add_turn({ethercat.turn()});
  }
  can.rig.check();
  ethercat.rig.check();
  const Baseline part{"master_part_on_ethercat", summarize(ethercat_parts.all()),
                      ratios_by_turn(can_parts.medians(), ethercat_parts.medians())};
  report.add(
      {"master_of_8_axes", "master_part", "ns", summarize(can_parts.all()), kMasterPartAim * part.figures.p50, part});
  const Baseline line{"line_on_ethercat", summarize(ethercat_lines.all()),
                      ratios_by_turn(can_lines.medians(), ethercat_lines.medians())};
  report.add({"line_of_8_axes_virtual", "processor_time_per_cycle", "ns", summarize(can_lines.all()),
              kLineAim * line.figures.p50, line});
}

}  // namespace driveline::bench
