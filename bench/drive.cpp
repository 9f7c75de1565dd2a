// Measures what a simulated drive with its plant costs in a cycle of 125 us, and how much memory it uses.
#include <fmt/format.h>
#include <numbers>

#include "driveline/rt/clock.hpp"
#include "driveline/slaves/msd/device_layout.hpp"
#include "driveline/slaves/msd/msd_drive.hpp"
#include "driveline/slaves/plant/servo_controller.hpp"
#include "driveline/slaves/plant/servo_motor.hpp"
#include "support/environment.hpp"
#include "support/line_rig.hpp"
#include "support/realtime.hpp"
#include "support/report.hpp"
#include "support/stopwatch.hpp"

namespace {

using namespace driveline;
using namespace driveline::bench;

constexpr int kCycles = 160'000;
constexpr int kBatch = 8;  ///< cycles per sample for a single drive
constexpr double kDriveAimNs = 400.0;
constexpr double kHundredDrivesAimUs = 60.0;
constexpr double kStateAimKib = 64.0;

/// The baseline: two steps of controllers and motor alone. ns per 125 us.
Baseline plant_alone(int cycles) {
  slaves::ServoMotor motor({}, slaves::msd::kControlStepS, 0.0);
  slaves::ServoController controller({}, slaves::msd::kControlStepS);
  std::vector<double> samples;
  double position_rad = 0.0;
  Rests rests;
  for (int done = 0; done < cycles; done += kBatch) {
    rests.take_when_due(now_ns());
    const double begin = now_ns();
    for (int step = 0; step < 2 * kBatch; ++step) {
      position_rad += 1e-4;
      controller.measure(motor.position_rad());
      motor.step(controller.step({slaves::ControllerSetpoint::Loop::kPosition, position_rad, 1.6, 0.0}));
      keep(motor);
    }
    samples.push_back((now_ns() - begin - reading_cost_ns()) / kBatch);
  }
  return {"controller_and_motor_alone", summarize(std::move(samples))};
}

/// The drives of a line that follow a path in CSP with a cubic spline, without slave controllers: takes outputs,
/// executes two control steps, returns inputs.
class Drives {
 public:
  explicit Drives(std::size_t count, int cycles)
      : rig_(clock_, count, cycles * LineRig::kPeriod + std::chrono::seconds{1}), valid_(new bool[count]) {
    rig_.bring_up([&](ecat_master::CyclicCore& core) -> std::unique_ptr<ecat_master::CycleRunner> {
      return std::make_unique<ecat_master::InlineRunner>(core, clock_);
    });
    // Continue with the cycle number and time of the runner.
    cycle_ = static_cast<std::int64_t>(rig_.master().core()->cycles());
    time_ = clock_.now();
    std::fill_n(valid_.get(), count, true);
  }

  /// ns per cycle for all drives, with `batch` cycles per sample: a single drive takes little more than the resolution
  /// of the clock. The master computes the setpoints in advance; in CSP they do not depend on the drives' inputs.
  Summary measure(int cycles, std::size_t batch) {
    std::vector<std::vector<std::byte>> outputs(batch);
    std::vector<double> samples;
    Rests rests;
    for (int done = 0; done < cycles; done += static_cast<int>(batch)) {
      rests.take_when_due(now_ns());
      for (auto& image : outputs) {
        rig_.motion().update(cycle_++, rig_.master().core()->image().outputs());
        image.assign(rig_.master().core()->image().outputs().begin(), rig_.master().core()->image().outputs().end());
      }
      const double begin = now_ns();
      for (const auto& image : outputs) step(image);
      samples.push_back((now_ns() - begin - reading_cost_ns()) / static_cast<double>(batch));
      const std::span<const bool> valid(valid_.get(), rig_.line().size());
      rig_.motion().read_inputs(rig_.master().core()->image().inputs(), valid, valid);
    }
    rig_.check();
    return summarize(std::move(samples));
  }

 private:
  void step(std::span<const std::byte> outputs) {
    time_ += LineRig::kPeriod;
    auto& image = rig_.master().core()->image();
    for (std::size_t i = 0; i < rig_.line().size(); ++i) {
      auto& drive = rig_.line().slave(i).device();
      const auto& place = image.places()[i];
      drive.write_outputs(slaves::msd::kOutputsSyncManager, outputs.subspan(place.output_offset, place.output_bytes));
      drive.advance(time_);
      drive.read_inputs(slaves::msd::kInputsSyncManager, image.inputs().subspan(place.input_offset, place.input_bytes));
    }
  }

  rt::VirtualClock clock_;
  LineRig rig_;
  std::unique_ptr<bool[]> valid_;
  std::int64_t cycle_ = 0;
  std::chrono::nanoseconds time_{};
};

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
  const auto floor = plant_alone(cycles);
  report.add({"1_drive", "cost_per_cycle", "ns", Drives(1, cycles).measure(cycles, kBatch), kDriveAimNs, floor});
  const auto hundred = Drives(100, cycles / 4).measure(cycles / 4, 1);
  report.add({"100_drives", "cost_per_cycle", "us", divided(hundred, 1e3), kHundredDrivesAimUs, std::nullopt});
  report.add({"100_drives", "cost_per_drive", "ns", divided(hundred, 100.0), kDriveAimNs, floor});
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
