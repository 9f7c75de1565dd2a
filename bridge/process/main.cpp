// Telemetry over DDS in a process of its own: what reads packets of a network stays out of the process that holds the
// line, and has nothing that could hurt it.

#include <unistd.h>

#include <atomic>
#include <csignal>
#include <cstdio>

#include "bridge.hpp"
#include "line_process.hpp"
#include "options.hpp"

namespace {

std::atomic<bool> stop{false};

/// For the last samples; a library that is stuck by then is ended by SIGALRM.
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
    std::fprintf(stderr, "driveline-bridge: %s; --help tells more\n", options.problem.c_str());
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
  // Ctrl-C of a terminal is for the process that holds the line; by hand it is for this one.
  std::signal(SIGINT, options.supervisor >= 0 ? SIG_IGN : request_stop);
  const auto wrong = driveline::bridge::Bridge(options, stop).run();
  if (wrong.empty()) return 0;
  // A supervisor tells it in its own words.
  if (options.supervisor < 0) std::fprintf(stderr, "driveline-bridge: %s\n", wrong.c_str());
  return 1;
}
