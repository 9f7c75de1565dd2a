#include "client.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <csignal>
#include <cstdio>
#include <cstring>

namespace driveline::bridge::clients {
namespace {

std::atomic<bool> stop_flag{false};
static_assert(std::atomic<bool>::is_always_lock_free, "used in a signal handler");

extern "C" void on_stop_signal(int signal) {
  // The second one is of a user who does not want to wait.
  if (stop_flag.exchange(true)) {
    std::signal(signal, SIG_DFL);
    std::raise(signal);
  }
}

/// "event" of "driveline/v1/event".
std::string_view short_name(std::string_view topic) {
  return topic.substr(topic.rfind('/') + 1);
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
    if (before.sa_handler != SIG_IGN) sigaction(signal, &action, nullptr);  // nohup
  }
  std::signal(SIGPIPE, SIG_IGN);
  std::signal(SIGXFSZ, SIG_IGN);  // a file that may not get longer is an error like a full disk
}

bool stop_requested() noexcept {
  return stop_flag.load(std::memory_order_relaxed);
}

Clock::time_point after(double seconds) {
  return Clock::now() + std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(seconds));
}

Outcome<std::vector<const Topic*>> select_topics(const std::vector<std::string>& names) {
  std::vector<const Topic*> chosen;
  for (const auto& name : names) {
    const Topic* found = find_topic(name);
    std::string known;
    for (const auto& topic : topics()) {
      if (found == nullptr && short_name(topic.name) == name) found = &topic;
      known += (known.empty() ? "" : ", ") + std::string(topic.name);
    }
    if (found == nullptr) return misused(fmt::format("there is no topic \"{}\"; there are {}", name, known));
    if (std::find(chosen.begin(), chosen.end(), found) == chosen.end()) chosen.push_back(found);
  }
  return chosen;
}

Outcome<void> print(std::string_view text) {
  const bool written = std::fwrite(text.data(), 1, text.size(), stdout) == text.size();
  if (written && std::fflush(stdout) == 0) return {};
  return failed(fmt::format("the output cannot be written: {}", std::strerror(errno)));
}

}  // namespace driveline::bridge::clients
