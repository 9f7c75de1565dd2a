// Measures what a simulated drive with its plant costs in a cycle of 125 us, and how much memory it uses.
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "driveline/slaves/msd/msd_drive.hpp"
#include "driveline/slaves/plant/servo_controller.hpp"
#include "driveline/slaves/plant/servo_motor.hpp"
#include "support/drive_cycles.hpp"
#include "support/environment.hpp"
#include "support/realtime.hpp"
#include "support/report.hpp"
#include "support/samples.hpp"
#include "support/stopwatch.hpp"

namespace {

using namespace driveline;
using namespace driveline::bench;

constexpr int kCycles = 160'000;
constexpr int kBatch = 8;  ///< cycles per sample for a single drive
/// Samples of drive and floor that make a turn: its medians have a ratio.
constexpr std::size_t kSamplesPerTurn = 400;
constexpr double kAimOverFloor = 3.0;  ///< medians, a drive over controllers and motor alone
constexpr double kHundredDrivesAimUs = 60.0;
constexpr double kStateAimKib = 64.0;

/// Controllers and motors of as many drives, without anything around them: the floor. Each has its own memory, as the
/// drives have.
class PlantsAlone {
 public:
  explicit PlantsAlone(std::size_t count) : plants_(count) {}

  /// Executes so many cycles of 125 us; returns the ns per cycle and plant.
  double measure(std::size_t cycles) {
    const double begin = now_ns();
    for (std::size_t cycle = 0; cycle < cycles; ++cycle) {
      for (Plant& plant : plants_) {
        for (int step = 0; step < kStepsPerCycle; ++step) plant.step();
      }
    }
    return (now_ns() - begin - reading_cost_ns()) / static_cast<double>(cycles * plants_.size());
  }

 private:
  static constexpr int kStepsPerCycle = 2;
  struct Plant {
    void step() {
      position_rad += 1e-4;
      controller.measure(motor.position_rad());
      motor.step(controller.step({slaves::ControllerSetpoint::Loop::kPosition, position_rad, 1.6, 0.0}));
      keep(motor);
    }
    slaves::ServoMotor motor{{}, slaves::msd::kControlStepS, 0.0};
    slaves::ServoController controller{{}, slaves::msd::kControlStepS};
    double position_rad = 0.0;
  };
  std::vector<Plant> plants_;
};

/// Drives and the floor, in ns per drive and 125 us.
struct Turns {
  TurnSamples drive;
  TurnSamples floor;
  [[nodiscard]] Summary figures() const { return summarize(drive.all()); }
  [[nodiscard]] Baseline baseline() const {
    return {"controller_and_motor_alone", summarize(floor.all()), ratios_by_turn(drive.medians(), floor.medians())};
  }
};

/// Measures drives and floor within microseconds of each other: a virtual machine runs at another speed in the next
/// second, and the ratio would be that of two moments. `batch`: cycles per sample, since a single drive takes little
/// more than the resolution of the clock.
Turns by_turns(std::size_t drives, int cycles, std::size_t batch) {
  DriveCycles line(drives, cycles);
  PlantsAlone plants(drives);
  Turns turns;
  std::vector<double> of_drive;
  std::vector<double> of_floor;
  Rests rests;
  for (int done = 0; done < cycles; done += static_cast<int>(batch)) {
    rests.take_when_due(now_ns());
    line.prepare(batch);
    const double begin = now_ns();
    line.execute();
    of_drive.push_back((now_ns() - begin - reading_cost_ns()) / static_cast<double>(batch * drives));
    of_floor.push_back(plants.measure(batch));
    line.read_inputs();
    if (of_drive.size() < kSamplesPerTurn) continue;
    turns.drive.add_turn(std::exchange(of_drive, {}));
    turns.floor.add_turn(std::exchange(of_floor, {}));
  }
  line.check();
  return turns;
}

/// With the aim over the floor of the same moments.
Row over_the_floor(const char* name, const char* metric, const Turns& turns) {
  const auto floor = turns.baseline();
  return {name, metric, "ns", turns.figures(), kAimOverFloor * floor.figures.p50, floor};
}

/// Heap and size per object in KiB, averaged over many; `make` creates an object.
template <typename Make>
Summary state_kib(Make make) {
  constexpr std::size_t kMany = 100;
  const auto keep_shared_tables = make();
  std::vector<decltype(make())> many;
  many.reserve(kMany);
  const auto before = heap_bytes();
  for (std::size_t i = 0; i < kMany; ++i) many.push_back(make());
  const double each_kib = static_cast<double>(heap_bytes() - before) / static_cast<double>(kMany) / 1024.0;
  return {kMany, each_kib, each_kib, each_kib, each_kib};
}

void measure_all(const Options& options) {
  Report report("drive");
  const int cycles = options.count(kCycles);
  claim_cpu(last_cpu());
  report.add(over_the_floor("1_drive", "cost_per_cycle", by_turns(1, cycles, kBatch)));
  const auto hundred = by_turns(100, cycles / 4, 1);
  report.add({"100_drives", "cost_per_cycle", "us", divided(hundred.figures(), 10.0), kHundredDrivesAimUs});
  report.add(over_the_floor("100_drives", "cost_per_drive", hundred));
  const auto make_drive = [] { return std::make_unique<slaves::msd::MsdDrive>(); };
  report.add({"drive", "state", "KiB", state_kib(make_drive), kStateAimKib, std::nullopt});
  report.add({"drive_and_slave_controller", "state", "KiB",
              state_kib([&] { return std::make_unique<slaves::Slave>(make_drive()); }), std::nullopt, std::nullopt});
  report.print(options);
}

}  // namespace

int main(int argc, char** argv) {
  return run(argc, argv, "What does one simulated drive with its plant cost in a cycle of 125 us?", measure_all);
}
