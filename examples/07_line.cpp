// A drive line from its description: brought up, moved along its path, supervised and shut down by the library, as in
// `driveline run`. This program adds consumers for every sample of every cycle and for events.
//   07_line line8.toml            the simulated line of the description, on virtual time
//   07_line line8.toml eth1       the same axes on a network interface, in real time

#include <algorithm>
#include <cmath>
#include <csignal>
#include <cstdio>
#include <vector>

#include "driveline/runtime/line.hpp"

using namespace driveline;

namespace {

volatile std::sig_atomic_t interrupted = 0;

/// Records the highest torque of every axis. Runs on an ordinary thread: it may be slow, the cycle does not wait.
class HighestTorques final : public snapshot::SampleConsumer {
 public:
  explicit HighestTorques(std::size_t axes) : highest_(axes) {}
  void lines(std::span<const snapshot::LineSample>) override {}
  void axes(std::span<const snapshot::AxisSample> samples) override {
    for (const auto& sample : samples) {
      highest_[sample.axis] = std::max(highest_[sample.axis], std::abs(sample.actual_torque));
    }
  }
  /// Highest torque in Nm or N. To be called after the run.
  [[nodiscard]] double of(std::size_t axis) const { return highest_[axis]; }

 private:
  std::vector<double> highest_;
};

/// Prints events, and turns Ctrl-C into a stop request.
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
  std::fprintf(stderr, "07_line: %s\n", sentence.c_str());
  return 1;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc < 2 || argc > 3) {
    std::fputs("usage: 07_line FILE [INTERFACE]\n", stderr);
    return 2;
  }
  for (const int number : {SIGINT, SIGTERM}) std::signal(number, [](int) { interrupted = 1; });

  runtime::Line::Options options;
  if (argc > 2) options.interface = argv[2];
  options.virtual_time = argc == 2;
  const auto line = runtime::Line::from_file(argv[1], options);
  if (!line) return fail(runtime::describe(line.error()));

  HighestTorques torques((*line)->config().axes.size());
  Console console(**line);
  (*line)->add(torques);
  (*line)->observe(console);
  const auto report = (*line)->run();
  if (!report) return fail(runtime::describe(report.error()));

  for (std::size_t i = 0; i < report->axes.size(); ++i) {
    const auto& axis = report->axes[i];
    std::printf("%-8s following error at most %.4g %s, torque at most %.3g\n", axis.name.c_str(),
                axis.following_error_max / axis.increments_per_unit, axis.unit.c_str(), torques.of(i));
  }
  std::printf("%.3f s in operation, %llu cycles, %llu periods missed\n", report->duration_s,
              static_cast<unsigned long long>(report->statistics.cycles),
              static_cast<unsigned long long>(report->statistics.missed_periods));
  return report->failure() == nullptr ? 0 : fail(runtime::describe(*report->failure()));
}
