#include "driveline/rt/realtime_thread.hpp"

#include <limits.h>
#include <pthread.h>
#include <signal.h>
#include <unistd.h>

#include <algorithm>
#include <future>
#include <stdexcept>
#include <utility>

#include "driveline/rt/realtime_platform.hpp"
#include "realtime_setup.hpp"

namespace driveline::rt {

/// State shared by the starting thread and the real-time thread; lives until the real-time thread has been joined.
struct RealtimeThread::Launch {
  RealtimeConfig config;
  RealtimeTask* task = nullptr;
  std::stop_source stop;
  pthread_t thread{};
  RealtimeReport report;        // written by the thread until the set-up is done, then read by the starter
  std::promise<bool> will_run;  // set when the set-up is done: whether the task will run
  CpuLatencyHold latency;       // released after the thread has been joined
  std::promise<void> end;       // set when the task has ended
  std::future<void> ended = end.get_future();

  int create() noexcept;
  static void* enter(void* launch) noexcept;
  void live() noexcept;
};

namespace {

std::size_t rounded_stack_size(std::size_t bytes) {
  const auto page = static_cast<std::size_t>(sysconf(_SC_PAGESIZE));
  const std::size_t at_least = std::max(bytes, static_cast<std::size_t>(PTHREAD_STACK_MIN));
  return (at_least + page - 1) / page * page;
}

}  // namespace

int RealtimeThread::Launch::create() noexcept {
  pthread_attr_t attributes;
  int error = pthread_attr_init(&attributes);
  if (error != 0) {
    return error;
  }
  error = pthread_attr_setstacksize(&attributes, rounded_stack_size(config.stack_bytes));
  if (error == 0) {
    // A new thread inherits the signal mask, so block all signals meanwhile.
    sigset_t all;
    sigset_t before;
    sigfillset(&all);
    pthread_sigmask(SIG_SETMASK, &all, &before);
    error = pthread_create(&thread, &attributes, &Launch::enter, this);
    pthread_sigmask(SIG_SETMASK, &before, nullptr);
  }
  pthread_attr_destroy(&attributes);
  return error;
}

void* RealtimeThread::Launch::enter(void* launch) noexcept {
  static_cast<Launch*>(launch)->live();
  return nullptr;
}

void RealtimeThread::Launch::live() noexcept {
  pthread_setname_np(pthread_self(), config.name.substr(0, 15).c_str());  // only for display
  report.settings.push_back(setup::prefault_stack());
  report.settings.push_back(setup::pin_to_cpu(config.cpu));
  // Set the scheduler after the slow steps, so that they do not run with a real-time priority, and before the timer
  // slack, which newer kernels change together with the scheduling class.
  report.settings.push_back(setup::set_scheduler(config.priority));
  report.settings.push_back(setup::set_timer_slack(config.timer_slack));

  const bool run = config.policy == RealtimePolicy::kDegrade || report.complete();
  will_run.set_value(run);
  if (run) {
    task->run(stop.get_token());
  }
  end.set_value();
}

RealtimeThread::RealtimeThread() = default;

RealtimeThread::~RealtimeThread() {
  request_stop();
  join();
}

tl::expected<RealtimeReport, RealtimeError> RealtimeThread::start(const RealtimeConfig& config, RealtimeTask& task) {
  if (launch_) {
    throw std::logic_error("real-time thread: started again without join()");
  }
  auto launch = std::make_unique<Launch>();
  launch->config = config;
  launch->task = &task;
  launch->report.platform = inspect_platform(PlatformSource::this_machine(), config.cpu);
  launch->report.cpu_latency = config.cpu_latency
                                   ? launch->latency.request(*config.cpu_latency, config.cpu_latency_device)
                                   : CpuLatencyHold::not_requested();
  launch->report.settings.push_back(setup::lock_memory(config.lock_memory));
  launch->report.settings.push_back(setup::keep_heap(config.lock_memory));

  std::future<bool> runs = launch->will_run.get_future();
  const int error = launch->create();
  if (error != 0) {
    launch->report.settings.push_back(setup::no_thread(error));
    return tl::unexpected(RealtimeError{std::move(launch->report)});
  }
  launch_ = std::move(launch);
  if (!runs.get()) {
    RealtimeError refusal{launch_->report};
    join();
    return tl::unexpected(std::move(refusal));
  }
  return launch_->report;
}

void RealtimeThread::request_stop() noexcept {
  if (launch_) {
    launch_->stop.request_stop();
  }
}

void RealtimeThread::join() noexcept {
  if (launch_) {
    pthread_join(launch_->thread, nullptr);
    launch_.reset();
  }
}

bool RealtimeThread::join_for(std::chrono::nanoseconds timeout) {
  if (launch_ && launch_->ended.wait_for(timeout) != std::future_status::ready) {
    return false;
  }
  join();
  return true;
}

}  // namespace driveline::rt
