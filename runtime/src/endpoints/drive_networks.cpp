#include "driveline/runtime/endpoints/drive_networks.hpp"

#include <fmt/format.h>

#include <poll.h>

#include <algorithm>
#include <mutex>
#include <stop_token>
#include <thread>
#include <utility>

#include "driveline/runtime/helper/helper_program.hpp"
#include "endpoints/endpoint_host.hpp"

namespace driveline::runtime {
namespace {

using Clock = EndpointHost::Clock;
using std::chrono::milliseconds;

/// The thread polls for frames of the line: to wake it would take a system call in the cycle.
constexpr std::chrono::microseconds kBusyPause{200};
constexpr milliseconds kIdlePause{10};
constexpr milliseconds kBusyFor{200};

}  // namespace

/// The end points, and the thread that serves them.
class DriveNetworks::Pump {
 public:
  /// Adds an end point for every device of the line that has EoE.
  Pump(slaves::SimulatedLine& line, const std::filesystem::path& program, const Settings& settings) {
    for (std::size_t i = 0; i < line.size(); ++i) {
      auto host = std::make_unique<EndpointHost>(i, line.slave(i).device(), program, settings);
      if (host->connect()) hosts_.push_back(std::move(host));
    }
  }

  [[nodiscard]] Result<void> start(milliseconds limit) {
    for (const auto& host : hosts_) {
      if (auto started = host->start(); !started) return started;
    }
    if (auto ready = wait_until_ready(Clock::now() + limit); !ready) return ready;
    if (hosts_.empty()) return {};
    thread_ = std::jthread([this](const std::stop_token& stop) {
      while (!stop.stop_requested()) turn();
    });
    return {};
  }

  [[nodiscard]] std::vector<Figures> figures() {
    const std::lock_guard lock(mutex_);
    std::vector<Figures> all;
    for (const auto& host : hosts_) all.push_back(host->figures());
    return all;
  }

 private:
  [[nodiscard]] Result<void> wait_until_ready(Clock::time_point limit) {
    for (;;) {
      turn();
      bool ready = true;
      for (const auto& figures : this->figures()) {
        const auto place = fmt::format("network of slave {}", figures.slave);
        if (!figures.failure.empty()) return fail(ErrorKind::kMachine, figures.failure, place);
        if (figures.process == 0) return fail(ErrorKind::kMachine, "its end point ended immediately", place);
        if (!figures.running && Clock::now() > limit)
          return fail(ErrorKind::kMachine, "its end point does not answer", place);
        ready &= figures.running;
      }
      if (ready) return {};
    }
  }

  void turn() {
    bool moved = false;
    {
      const std::lock_guard lock(mutex_);
      const auto now = Clock::now();
      for (const auto& host : hosts_) moved |= host->serve(now);
      if (moved) busy_until_ = now + kBusyFor;
      waiting_.clear();
      for (const auto& host : hosts_) waiting_.push_back({host->descriptor(), POLLIN, 0});
    }
    const std::chrono::nanoseconds pause =
        Clock::now() < busy_until_ ? std::chrono::nanoseconds{kBusyPause} : kIdlePause;
    const timespec limit{0, static_cast<long>(pause.count())};
    static_cast<void>(::ppoll(waiting_.data(), waiting_.size(), &limit, nullptr));
  }

  std::mutex mutex_;  ///< protects the hosts between their thread and callers of figures()
  std::vector<std::unique_ptr<EndpointHost>> hosts_;
  std::vector<pollfd> waiting_;
  Clock::time_point busy_until_{};
  std::jthread thread_;  ///< last member, so that it ends before the others are destroyed
};

DriveNetworks::DriveNetworks(std::unique_ptr<Pump> pump) noexcept : pump_(std::move(pump)) {}
DriveNetworks::~DriveNetworks() = default;

Result<std::unique_ptr<DriveNetworks>> DriveNetworks::start(slaves::SimulatedLine& line, const Settings& settings) {
  auto program = settings.program.empty() ? find_program() : Result<std::filesystem::path>(settings.program);
  if (!program) return tl::unexpected(program.error());
  auto pump = std::make_unique<Pump>(line, *program, settings);
  if (auto started = pump->start(settings.start_limit); !started) return tl::unexpected(started.error());
  return std::unique_ptr<DriveNetworks>(new DriveNetworks(std::move(pump)));
}

Result<std::filesystem::path> DriveNetworks::find_program() {
  return find_helper_program("driveline-endpoint", "DRIVELINE_ENDPOINT");
}

std::vector<DriveNetworks::Figures> DriveNetworks::figures() const {
  return pump_->figures();
}

}  // namespace driveline::runtime
