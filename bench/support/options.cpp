#include "support/options.hpp"

#include <fmt/format.h>
#include <CLI/CLI.hpp>
#include <exception>

#include "driveline/rt/cpu_latency.hpp"
#include "support/environment.hpp"
#include "support/retry.hpp"

namespace driveline::bench {

int run(int argc, char** argv, const char* question, void (*measure)(const Options& options)) {
  Options options;
  CLI::App app{question};
  app.add_flag("--json", options.json, "Print one JSON document");
  app.add_flag("--quick", options.quick, "A tenth of the measurements, as a functional check");
  app.add_option("--figures", options.figures, "Folder for curves instead of a report (dc, homing_paths)");
  app.add_option("--histogram", options.histogram, "File for the measured histogram (wake)");
  app.add_flag("--short", options.shorter,
               "A third of the measurements, for a report of all programs within ten minutes");
  app.add_option("--duration", options.duration_s, "Seconds for each way (jitter), or altogether (soak); up to a week")
      ->check(CLI::Range(0.5, 7 * 86'400.0));
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? 0 : 2;
  }
  // As `driveline run` does: measure the program, not the wake-up time of an idle processor.
  rt::CpuLatencyHold awake;
  if (const auto item = awake.request(std::chrono::microseconds{0}); !item.ok) {
    fmt::print(stderr, "{}: {} requested, {} in effect: {}\n", item.name, item.requested, item.effective, item.remedy);
  }
  watch_machine();
  try {
    measure(options);
  } catch (const Skipped& reason) {
    fmt::print(stderr, "{}: skipped: {}\n", argv[0], reason.what());
    return kSkippedStatus;
  } catch (const Disturbed& reason) {
    fmt::print(stderr, "{}: disturbed: {}\n", argv[0], reason.what());
    return kDisturbedStatus;
  } catch (const std::exception& error) {
    fmt::print(stderr, "{}: {}\n", argv[0], error.what());
    return 1;
  }
  return 0;
}

}  // namespace driveline::bench
