#include "driveline/rt/stop_signals.hpp"

#include <array>
#include <csignal>
#include <ctime>

#include "driveline/rt/time_conversion.hpp"

namespace driveline::rt {
namespace {

constinit StopRequest stop_request;

/// Signals that end a program by default, other than SIGQUIT and those that report an error of the program (signal(7)).
/// Besides users, process managers and log rotation (SIGUSR1), resource limits (SIGXCPU) and power supplies (SIGPWR)
/// send them.
constexpr std::array kStopSignals{SIGINT,  SIGTERM,   SIGHUP,  SIGUSR1, SIGUSR2, SIGXCPU,
                                  SIGALRM, SIGVTALRM, SIGPROF, SIGIO,   SIGPWR,  SIGSTKFLT};

extern "C" void on_stop_signal(int signal) {
  std::timespec now{};
  clock_gettime(CLOCK_MONOTONIC, &now);
  if (stop_request.note(from_timespec(now))) {
    std::signal(signal, SIG_DFL);
    std::raise(signal);
  }
}

void handle_unless_handled(int signal, const struct sigaction& action) {
  struct sigaction before = {};
  sigaction(signal, nullptr, &before);
  if (before.sa_handler == SIG_DFL) sigaction(signal, &action, nullptr);
}

}  // namespace

void catch_stop_signals() {
  struct sigaction action = {};
  action.sa_handler = on_stop_signal;
  action.sa_flags = SA_RESTART;  // file accesses are restarted, not interrupted
  sigemptyset(&action.sa_mask);
  for (const int signal : kStopSignals) handle_unless_handled(signal, action);
  for (int signal = SIGRTMIN; signal <= SIGRTMAX; ++signal) handle_unless_handled(signal, action);
  action.sa_handler = SIG_IGN;
  sigaction(SIGPIPE, &action, nullptr);
}

void refuse_long_files_with_errors() {
  std::signal(SIGXFSZ, SIG_IGN);
}

bool stop_requested() noexcept {
  return stop_request.requested();
}

}  // namespace driveline::rt
