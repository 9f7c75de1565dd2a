#include "support/latency_histogram.hpp"

#include <fmt/format.h>
#include <algorithm>
#include <cmath>
#include <fstream>
#include <nlohmann/json.hpp>
#include <stdexcept>

#include "support/environment.hpp"

namespace driveline::bench {
namespace {

constexpr std::string_view kWakeFile = DRIVELINE_BENCH_DATA "/wake_latency.json";
constexpr double kFirstEdgeNs = 25.0;
constexpr double kEdgeRatio = 1.25;

}  // namespace

LatencyHistogram::LatencyHistogram(std::vector<Bin> bins) : bins_(std::move(bins)) {
  for (const auto& bin : bins_) total_ += bin.count;
  if (total_ == 0) throw std::runtime_error("a histogram without a latency");
}

std::chrono::nanoseconds LatencyHistogram::draw(std::mt19937& random) const {
  auto rank = std::uniform_int_distribution<std::uint64_t>(0, total_ - 1)(random);
  double from = 0.0;
  for (const auto& bin : bins_) {
    if (rank < bin.count)
      return std::chrono::nanoseconds{std::llround(std::uniform_real_distribution<double>(from, bin.below_ns)(random))};
    rank -= bin.count;
    from = bin.below_ns;
  }
  return {};
}

const LatencyHistogram& wake_latency() {
  static const LatencyHistogram kHistogram = [] {
    std::ifstream file{std::string(kWakeFile)};
    if (!file) throw std::runtime_error(fmt::format("{}: cannot be read", kWakeFile));
    const auto document = nlohmann::json::parse(file);
    std::vector<LatencyHistogram::Bin> bins;
    for (const auto& bin : document.at("bins")) {
      bins.push_back({bin.at("below_ns").get<double>(), bin.at("count").get<std::uint64_t>()});
    }
    return LatencyHistogram(std::move(bins));
  }();
  return kHistogram;
}

void write_latency_histogram(const std::string& file, std::string_view way, const std::vector<double>& latencies_ns) {
  std::vector<std::uint64_t> counts;
  std::vector<double> edges;
  for (const double latency : latencies_ns) {
    while (edges.empty() || latency >= edges.back()) {
      edges.push_back(edges.empty() ? kFirstEdgeNs : std::round(edges.back() * kEdgeRatio));
      counts.push_back(0);
    }
    const auto bin = std::upper_bound(edges.begin(), edges.end(), latency) - edges.begin();
    ++counts[static_cast<std::size_t>(bin)];
  }
  auto bins = nlohmann::json::array();
  for (std::size_t i = 0; i < edges.size(); ++i) bins.push_back({{"below_ns", edges[i]}, {"count", counts[i]}});
  const nlohmann::json document = {{"what", "wake-up latency of a SCHED_FIFO thread on a grid of 125 us"},
                                   {"measured_by", fmt::format("bench/wake --histogram, way of waiting: {}", way)},
                                   {"wake_ups", latencies_ns.size()},
                                   {"environment", environment_json()},
                                   {"bins", std::move(bins)}};
  std::ofstream out(file);
  out << document.dump(1) << '\n';
  if (!out.flush()) throw std::runtime_error(fmt::format("{}: cannot be written", file));
}

}  // namespace driveline::bench
