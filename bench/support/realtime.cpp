#include "support/realtime.hpp"

#include <fmt/format.h>
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

}  // namespace driveline::bench
