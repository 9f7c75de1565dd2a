// driveline-bridge: publishes telemetry over DDS in a separate process, so that code that reads network packets stays
// out of the process that runs the line, and has no access that could harm the line.

#include <unistd.h>

#include <atomic>
#include <csignal>
#include <cstdio>

#include "bridge.hpp"
#include "line_process.hpp"
#include "options.hpp"

namespace {

std::atomic<bool> stop{false};

/// Time limit in s for the last samples; a library that is stuck is then ended by SIGALRM.
constexpr unsigned kFarewellSeconds = 5;

void request_stop(int /*signal*/) {
  stop.store(true, std::memory_order_relaxed);
  ::alarm(kFarewellSeconds);
}

}  // namespace

int main(int argc, char** argv) {
  auto options = driveline::bridge::read_options(argc - 1, argv + 1);
  if (options.help) {
    std::fputs(driveline::bridge::kHelp, stdout);
    return 0;
  }
  if (!options.problem.empty()) {
    std::fprintf(stderr, "driveline-bridge: %s; --help shows more\n", options.problem.c_str());
    return 2;
  }
  if (options.process >= 0) {
    if (const auto wrong = driveline::bridge::take_feed_of_process(options); !wrong.empty()) {
      std::fprintf(stderr, "driveline-bridge: %s\n", wrong.c_str());
      return 1;
    }
  }
  std::signal(SIGPIPE, SIG_IGN);
  std::signal(SIGTERM, request_stop);
  // Ctrl-C on a terminal is meant for the process that runs the line, unless this process was started by hand.
  std::signal(SIGINT, options.supervisor >= 0 ? SIG_IGN : request_stop);
  const auto wrong = driveline::bridge::Bridge(options, stop).run();
  if (wrong.empty()) return 0;
  // With a supervisor, the supervisor reports the error.
  if (options.supervisor < 0) std::fprintf(stderr, "driveline-bridge: %s\n", wrong.c_str());
  return 1;
}
