#include "support/eoe_line.hpp"

#include <fmt/format.h>

#include <filesystem>
#include <stdexcept>
#include <utility>

#include "support/realtime.hpp"
#include "support/retry.hpp"
#include "support/tcp.hpp"

namespace driveline::bench {
namespace {

constexpr auto kTimeout = std::chrono::seconds{60};
/// 6.5 s, in increments of 100 us: a busy machine must not make the drives leave OP.
constexpr std::uint16_t kWatchdog = 65000;

}  // namespace

runtime::LineConfig EoeLine::describe(const Settings& settings) {
  runtime::LineConfig config;
  config.name = "eoe";
  config.period = settings.period;
  config.max_lost_cycles = 100'000;
  config.realtime.policy = rt::RealtimePolicy::kDegrade;
  config.realtime.cpu = last_cpu();
  config.telemetry.enabled = false;
  config.output.directory = std::filesystem::temp_directory_path() / "driveline-bench-eoe";
  config.output.plots = false;
  auto& eoe = config.eoe.emplace();
  eoe.interface = "dl-bench";
  eoe.address = *runtime::parse_network("192.168.38.1/24");
  eoe.gateway = eoe.address.address;
  for (std::size_t i = 0; i < settings.drives; ++i) {
    auto& slave = config.slaves.emplace_back();
    slave.name = fmt::format("d{}", i);
    slave.ip = runtime::parse_ip(address(i));
    slave.plan.watchdog.process_data = kWatchdog;
  }
  if (!settings.interface.empty()) config.interface = settings.interface;
  return config;
}

std::string EoeLine::address(std::size_t drive) {
  return fmt::format("192.168.38.{}", 5 + drive);
}

EoeLine::EoeLine(const Settings& settings) {
  auto line = runtime::Line::from_config(describe(settings));
  if (!line) throw std::runtime_error(runtime::describe(line.error()));
  line_ = std::move(*line);
  line_->observe(*this);
  line_->add(static_cast<snapshot::SampleConsumer&>(*this));
  thread_ = std::thread([this] {
    const auto report = line_->run();
    const std::scoped_lock lock(mutex_);
    if (!report) failure_ = runtime::describe(report.error());
    ended_.store(true);
  });
  try {
    const auto deadline = std::chrono::steady_clock::now() + kTimeout;
    while (!in_op_.load()) {
      check();
      if (std::chrono::steady_clock::now() > deadline) throw Disturbed("the line did not come to OP");
      std::this_thread::sleep_for(std::chrono::milliseconds{10});
    }
    for (std::size_t i = 0; i < settings.drives; ++i) await_answer(address(i), kTimeout);
  } catch (...) {
    stop_.store(true);
    thread_.join();
    throw;
  }
}

EoeLine::~EoeLine() {
  stop_.store(true);
  thread_.join();
  std::error_code ignored;  // the folder may contain files of other programs
  std::filesystem::remove(line_->config().output.directory, ignored);
}

void EoeLine::event(const runtime::Event& event) {
  if (const auto* configured = event.as<runtime::events::Configured>())
    acyclic_bytes_.store(configured->wire.acyclic_bytes);
  if (event.is<runtime::events::EoeUp>()) in_op_.store(true);
  if (!event.is_fault()) return;
  const std::scoped_lock lock(mutex_);
  failure_ = runtime::describe(event);
}

void EoeLine::lines(std::span<const snapshot::LineSample> samples) {
  const std::scoped_lock lock(mutex_);
  for (const auto& sample : samples) {
    costs_.push_back(static_cast<double>(sample.cost_ns));
    wake_ups_.push_back(static_cast<double>(sample.wake_latency_ns));
  }
}

std::vector<double> EoeLine::take_costs() {
  const std::scoped_lock lock(mutex_);
  return std::exchange(costs_, {});
}

std::vector<double> EoeLine::take_wake_ups() {
  const std::scoped_lock lock(mutex_);
  return std::exchange(wake_ups_, {});
}

void EoeLine::check() const {
  const std::scoped_lock lock(mutex_);
  if (ended_.load()) throw std::runtime_error(failure_.empty() ? "the line has ended" : failure_);
}

}  // namespace driveline::bench
