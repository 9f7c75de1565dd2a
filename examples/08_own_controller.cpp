// A custom controller in the 125 us cycle: spring and damper pull an axis to an oscillating target, by torque alone
// (CST), first at 1 kHz, then in every cycle. Everything else is the same as for any line: bring-up, limits,
// supervision, flight recorder, telemetry for DDS clients, shutdown. Ctrl-C ends it.
//   08_own_controller own_controller.toml            a simulated drive, on virtual time
//   08_own_controller own_controller.toml eth1       a drive on a network interface, in real time

#include <algorithm>
#include <chrono>
#include <cmath>
#include <csignal>
#include <cstdio>
#include <numbers>

#include "driveline/runtime/line.hpp"

using namespace driveline;

namespace {

constexpr double kRunSeconds = 4.0;

volatile std::sig_atomic_t interrupted = 0;

/// Belongs to the cycle while the line runs; its results are read afterwards.
class Spring final : public runtime::Task {
 public:
  runtime::Result<void> prepare(const runtime::TaskSetup& setup) override {
    axis_ = setup.axes[0];
    return {};
  }

  void update(const motion::TaskCycle& now) noexcept override {
    const auto& actual = now.axes[axis_.number].inputs();
    if (!axis_.drive->followed()) {
      rest_ = actual.position;
      time_s_ = 0.0;
      return;
    }
    time_s_ += std::chrono::duration<double>(now.elapsed).count();
    const double angle = std::numbers::pi * time_s_;
    const double goal = rest_ + 0.5 * (1.0 - std::cos(angle));
    const double goal_velocity = 0.5 * std::numbers::pi * std::sin(angle);
    const double torque = kStiffness * (goal - actual.position) + kDamping * (goal_velocity - actual.velocity);
    // In CST only the torque moves the axis; the position is passed on so that telemetry shows it.
    axis_.drive->command({actual.position, actual.velocity, 0.0, torque});
    worst_ = std::max(worst_, std::abs(goal - actual.position));
  }

  /// Largest distance from the target, rad.
  [[nodiscard]] double worst() const noexcept { return worst_; }

 private:
  static constexpr double kStiffness = 2.0;  // Nm/rad
  static constexpr double kDamping = 0.05;   // Nm s/rad

  runtime::TaskAxis axis_;
  double rest_ = 0.0;
  double time_s_ = 0.0;
  double worst_ = 0.0;
};

class Console final : public runtime::Observer {
 public:
  explicit Console(runtime::Line& line) : line_(line) {}
  void event(const runtime::Event& event) override { std::fprintf(stderr, "%s\n", runtime::describe(event).c_str()); }
  void poll() override {
    if (interrupted != 0) line_.request_stop();
  }

 private:
  runtime::Line& line_;
};

int fail(const std::string& sentence) {
  std::fprintf(stderr, "08_own_controller: %s\n", sentence.c_str());
  return 1;
}

double us(std::chrono::nanoseconds time) {
  return std::chrono::duration<double, std::micro>(time).count();
}

/// Runs the line once, with the controller in every `divider`-th cycle.
int run(const char* file, const runtime::Line::Options& options, std::uint32_t divider) {
  const auto opened = runtime::Line::from_file(file, options);
  if (!opened) return fail(runtime::describe(opened.error()));
  auto& line = **opened;
  if (line.config().axes.empty()) return fail("the line description has no [[axis]]");

  Spring spring;
  Console console(line);
  line.observe(console);
  const runtime::TaskPlan plan{
      .name = "spring", .timing = {.divider = divider}, .drives = {line.config().axes[0].name}};
  if (auto added = line.add(spring, plan); !added) return fail(runtime::describe(added.error()));
  runtime::Line::RunSettings settings;
  settings.duration_s = kRunSeconds;
  settings.telemetry = true;  // by the process driveline-bridge, where it is installed
  const auto report = line.run(settings);
  if (!report) return fail(runtime::describe(report.error()));

  const auto& task = report->tasks[0].figures;
  std::printf("every %u cycles: %llu calls, %.4f rad off at most\n", divider,
              static_cast<unsigned long long>(task.calls), spring.worst());
  // On virtual time calls take no time.
  if (!options.virtual_time) {
    std::printf("  a call takes %.1f us at the median, %.1f us at most\n", us(task.cost.percentile(0.5)),
                us(task.cost.max()));
  }
  std::printf("  %llu cycles, %llu periods missed, %llu samples of the axis published\n",
              static_cast<unsigned long long>(report->statistics.cycles),
              static_cast<unsigned long long>(report->statistics.missed_periods),
              static_cast<unsigned long long>(report->telemetry ? report->telemetry->published : 0));
  for (const auto& [what, where] : report->files) std::printf("  %s: %s\n", what.c_str(), where.c_str());
  return report->failure() == nullptr ? 0 : fail(runtime::describe(*report->failure()));
}

}  // namespace

int main(int argc, char** argv) {
  if (argc < 2 || argc > 3) {
    std::fputs("usage: 08_own_controller FILE [INTERFACE]\n", stderr);
    return 2;
  }
  for (const int number : {SIGINT, SIGTERM}) std::signal(number, [](int) { interrupted = 1; });
  runtime::Line::Options options;
  if (argc > 2) options.interface = argv[2];
  options.virtual_time = argc == 2;
  for (const std::uint32_t divider : {8U, 1U}) {
    if (const int status = run(argv[1], options, divider); status != 0) return status;
    if (interrupted != 0) break;
  }
  return 0;
}
