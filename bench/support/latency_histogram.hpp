#pragma once

#include <chrono>
#include <cstdint>
#include <random>
#include <string>
#include <string_view>
#include <vector>

namespace driveline::bench {

/// Latencies measured on a machine.
class LatencyHistogram {
 public:
  struct Bin {
    double below_ns = 0.0;
    std::uint64_t count = 0;
  };
  /// `bins` in ascending order. Throws if they are empty.
  explicit LatencyHistogram(std::vector<Bin> bins);

  /// Draws a latency with its measured frequency; uniformly distributed within its bin.
  [[nodiscard]] std::chrono::nanoseconds draw(std::mt19937& random) const;
  [[nodiscard]] std::uint64_t count() const noexcept { return total_; }

 private:
  std::vector<Bin> bins_;
  std::uint64_t total_ = 0;
};

/// The wake-up latency stored in bench/data, as measured by program `wake`; read once. Throws if it cannot be read.
[[nodiscard]] const LatencyHistogram& wake_latency();

/// Writes `latencies_ns` as a histogram with the environment and the method of waiting. Throws if it cannot be written.
void write_latency_histogram(const std::string& file, std::string_view way, const std::vector<double>& latencies_ns);

}  // namespace driveline::bench
