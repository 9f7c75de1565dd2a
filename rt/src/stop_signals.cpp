#include "driveline/rt/stop_signals.hpp"

#include <atomic>
#include <csignal>

namespace driveline::rt {
namespace {

std::atomic<bool> stop_flag{false};
static_assert(std::atomic<bool>::is_always_lock_free, "used in a signal handler");

extern "C" void on_stop_signal(int signal) {
  // A second signal: the program is already shutting down and the user does not want to wait.
  if (stop_flag.exchange(true)) {
    std::signal(signal, SIG_DFL);
    std::raise(signal);
  }
}

}  // namespace

void catch_stop_signals() {
  struct sigaction action = {};
  action.sa_handler = on_stop_signal;
  action.sa_flags = SA_RESTART;  // file accesses are restarted, not interrupted
  sigemptyset(&action.sa_mask);
  for (const int signal : {SIGINT, SIGTERM, SIGHUP}) {
    struct sigaction before = {};
    sigaction(signal, nullptr, &before);
    // Signals that are ignored from the start (nohup) stay ignored.
    if (before.sa_handler != SIG_IGN) sigaction(signal, &action, nullptr);
  }
  action.sa_handler = SIG_IGN;
  sigaction(SIGPIPE, &action, nullptr);
}

void refuse_long_files_with_errors() {
  std::signal(SIGXFSZ, SIG_IGN);
}

bool stop_requested() noexcept {
  return stop_flag.load(std::memory_order_relaxed);
}

}  // namespace driveline::rt
