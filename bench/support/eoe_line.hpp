#pragma once

#include <atomic>
#include <chrono>
#include <memory>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include "driveline/runtime/line.hpp"

namespace driveline::bench {

/// A line of simulated drives, each with its own network stack behind its EoE port. It runs in its own threads while
/// the caller talks TCP/IP to the drives. Needs a network namespace of the process.
class EoeLine final : private runtime::Observer, private snapshot::SampleConsumer {
 public:
  /// Location and number of the drives.
  struct Settings {
    std::size_t drives = 1;
    std::chrono::nanoseconds period = std::chrono::microseconds{125};
    std::string interface;  ///< interface that leads to the drives; empty: they are in this process
  };

  /// Brings up the line; returns when it is in OP and every drive answers. Throws std::runtime_error on failure.
  explicit EoeLine(const Settings& settings);
  EoeLine(const EoeLine&) = delete;
  EoeLine& operator=(const EoeLine&) = delete;
  ~EoeLine() override;

  /// Description of such a line, also for the process that serves it.
  [[nodiscard]] static runtime::LineConfig describe(const Settings& settings);
  /// Address of a drive: 192.168.38.5 and so on.
  [[nodiscard]] static std::string address(std::size_t drive);

  /// Returns the costs of the cycles since the last call, in ns.
  [[nodiscard]] std::vector<double> take_costs();
  /// Returns the wake-up latencies of the cycles since the last call, in ns.
  [[nodiscard]] std::vector<double> take_wake_ups();
  /// Bytes of a cycle that are left for acyclic frames.
  [[nodiscard]] std::size_t acyclic_bytes() const noexcept { return acyclic_bytes_.load(); }
  /// Throws std::runtime_error if the line has ended.
  void check() const;

 private:
  void event(const runtime::Event& event) override;
  void poll() override {
    if (stop_.load()) line_->request_stop();
  }
  void lines(std::span<const snapshot::LineSample> samples) override;
  void axes(std::span<const snapshot::AxisSample> /*samples*/) override {}

  std::unique_ptr<runtime::Line> line_;
  std::atomic<bool> stop_{false};
  std::atomic<bool> in_op_{false};
  std::atomic<bool> ended_{false};
  std::atomic<std::size_t> acyclic_bytes_{0};
  mutable std::mutex mutex_;  ///< protects the following members
  std::vector<double> costs_;
  std::vector<double> wake_ups_;
  std::string failure_;
  std::thread thread_;
};

}  // namespace driveline::bench
