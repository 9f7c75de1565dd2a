#include "support/realtime.hpp"

#include <fmt/format.h>
#include <pthread.h>
#include <sched.h>
#include <stdexcept>
#include <thread>

namespace driveline::bench {

void start_realtime(rt::RealtimeThread& thread, rt::RealtimeTask& task) {
  rt::RealtimeConfig config;
  config.policy = rt::RealtimePolicy::kDegrade;
  config.name = "bench";
  config.cpu = static_cast<int>(std::thread::hardware_concurrency()) - 1;
  const auto report = thread.start(config, task);
  if (!report) throw std::runtime_error(report.error().message());
  for (const auto& item : report->settings) {
    if (item.ok) continue;
    fmt::print(stderr, "{}: {} requested, {} in effect: {}\n", item.name, item.requested, item.effective, item.remedy);
  }
}

void claim_cpu(int cpu) noexcept {
  cpu_set_t set;
  CPU_ZERO(&set);
  CPU_SET(static_cast<unsigned>(cpu), &set);
  static_cast<void>(pthread_setaffinity_np(pthread_self(), sizeof set, &set));
  const sched_param priority{.sched_priority = 20};
  static_cast<void>(pthread_setschedparam(pthread_self(), SCHED_FIFO, &priority));
}

int last_cpu() noexcept {
  return static_cast<int>(std::thread::hardware_concurrency()) - 1;
}

}  // namespace driveline::bench
