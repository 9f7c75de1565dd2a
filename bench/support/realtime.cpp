#include "support/realtime.hpp"

#include <fmt/format.h>
#include <pthread.h>
#include <sched.h>
#include <chrono>
#include <stdexcept>
#include <thread>

namespace driveline::bench {
namespace {

/// Above ordinary kernel threads, below the interrupt threads of a PREEMPT_RT kernel (50).
constexpr int kPriority = 20;

}  // namespace

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

void claim_cpu(int cpu) {
  cpu_set_t set;
  CPU_ZERO(&set);
  CPU_SET(static_cast<unsigned>(cpu), &set);
  static_cast<void>(pthread_setaffinity_np(pthread_self(), sizeof set, &set));
  const sched_param priority{.sched_priority = kPriority};
  static_cast<void>(pthread_setschedparam(pthread_self(), SCHED_FIFO, &priority));

  int policy = SCHED_OTHER;
  sched_param effective{};
  if (pthread_getschedparam(pthread_self(), &policy, &effective) != 0 || policy != SCHED_FIFO) {
    fmt::print(stderr, "scheduler: SCHED_FIFO {} requested, not in effect: run it as root or with CAP_SYS_NICE\n",
               kPriority);
  }
  CPU_ZERO(&set);
  if (pthread_getaffinity_np(pthread_self(), sizeof set, &set) != 0 || CPU_COUNT(&set) != 1 ||
      !CPU_ISSET(static_cast<unsigned>(cpu), &set)) {
    fmt::print(stderr, "affinity: processor {} requested, not in effect: this process may not use it\n", cpu);
  }
}

bool Rests::take_when_due(double now_ns) noexcept {
  constexpr double kWorkNs = 500e6;
  constexpr auto kRest = std::chrono::milliseconds{50};
  if (next_ns_ == 0.0) next_ns_ = now_ns + kWorkNs;
  if (now_ns < next_ns_) return false;
  std::this_thread::sleep_for(kRest);
  next_ns_ = now_ns + kWorkNs + std::chrono::duration<double, std::nano>(kRest).count();
  return true;
}

int last_cpu() noexcept {
  return static_cast<int>(std::thread::hardware_concurrency()) - 1;
}

}  // namespace driveline::bench
