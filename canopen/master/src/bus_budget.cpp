#include "driveline/canopen_master/bus_budget.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <vector>

namespace driveline::canopen {
namespace {

using std::chrono::milliseconds;
using std::chrono::nanoseconds;
using Seconds = std::chrono::duration<double>;

/// Longest SYNC period that is proposed.
constexpr int kLongestProposalMs = 1000;

struct Bits {
  std::uint32_t least = 0;
  std::uint32_t worst = 0;
  void add(std::size_t bytes) noexcept {
    least += frame_bits(bytes);
    worst += worst_frame_bits(bytes);
  }
};

std::uint32_t bits_in(nanoseconds period, std::uint32_t bit_rate) {
  return static_cast<std::uint32_t>(std::lround(Seconds(period).count() * bit_rate));
}

/// Bits of each node in a period.
std::vector<Bits> bits_by_node(const PdoImage& image) {
  std::vector<Bits> nodes(image.nodes());
  for (const auto pdos : {image.rpdos(), image.tpdos()}) {
    for (const auto& pdo : pdos) {
      if (pdo.exchange == PdoExchange::kWithSync) nodes[pdo.node].add(pdo.length);
    }
  }
  return nodes;
}

double share(std::uint32_t bits, nanoseconds interval, std::uint32_t bit_rate) {
  return interval.count() > 0 ? bits / (Seconds(interval).count() * bit_rate) : 0.0;
}

/// Rounded; a half is rounded up.
std::uint64_t percent(std::uint64_t part, std::uint64_t whole) {
  return whole == 0 ? 0 : (200 * part + whole) / (2 * whole);
}

double other_load(const MasterPlan& plan, const PdoImage& image) {
  double load = share(worst_frame_bits(1), plan.master_heartbeat, plan.bit_rate);
  for (const auto& node : plan.nodes) {
    const auto& control = node.error_control;
    load += share(worst_frame_bits(1), control.heartbeat, plan.bit_rate);
    // The question is a remote frame, which has no data bytes.
    load += share(worst_frame_bits(0) + worst_frame_bits(1), control.guard_time, plan.bit_rate);
  }
  for (const auto& pdo : image.rpdos()) {
    if (pdo.exchange == PdoExchange::kOnChange) load += share(worst_frame_bits(pdo.length), pdo.resend, plan.bit_rate);
  }
  return load;
}

}  // namespace

BusBudget bus_budget(const MasterPlan& plan, const PdoImage& image) {
  constexpr std::size_t kSyncBytes = 0;
  BusBudget budget;
  budget.bit_rate = plan.bit_rate;
  budget.period = plan.period;
  budget.period_bits = bits_in(plan.period, plan.bit_rate);
  budget.other_load = other_load(plan, image);
  Bits total;
  total.add(kSyncBytes);
  bool room = true;
  for (const auto& node : bits_by_node(image)) {
    if (node.worst == 0) continue;
    ++budget.nodes;
    total.least += node.least;
    total.worst += node.worst;
    room = room && total.worst + kLongestFrameBits <= budget.period_bits;
    if (room) budget.most_nodes = budget.nodes;
  }
  budget.bits = total.least;
  budget.worst_bits = total.worst;
  budget.needed = std::chrono::duration_cast<nanoseconds>(Seconds(static_cast<double>(total.worst) / plan.bit_rate));
  budget.fits = total.worst + kLongestFrameBits <= budget.period_bits;
  if (total.worst < budget.period_bits) budget.acyclic_frames = (budget.period_bits - total.worst) / kLongestFrameBits;
  for (int ms = 1; ms <= kLongestProposalMs && budget.least_period.count() == 0; ++ms) {
    if (total.worst + kLongestFrameBits <= bits_in(milliseconds{ms}, plan.bit_rate)) {
      budget.least_period = milliseconds{ms};
    }
  }
  return budget;
}

std::string describe(const BusBudget& budget, const std::string& things) {
  const auto ms = [](nanoseconds time) { return std::chrono::duration<double, std::milli>(time).count(); };
  if (budget.fits) {
    return fmt::format("{} {} load the bus to {} %, at most {} %, and leave room for {} more frame{} in each period",
                       budget.nodes, things, percent(budget.bits, budget.period_bits),
                       percent(budget.worst_bits, budget.period_bits), budget.acyclic_frames,
                       budget.acyclic_frames == 1 ? "" : "s");
  }
  // A half is rounded up, as by hand.
  const auto hundredths = (budget.needed + std::chrono::microseconds{5}) / std::chrono::microseconds{10};
  auto text = fmt::format("{} {} need {}.{:02d} ms of bus in the worst case, SYNC is {:g} ms", budget.nodes, things,
                          hundredths / 100, hundredths % 100, ms(budget.period));
  if (budget.least_period.count() > 0) {
    text += fmt::format(": take {:g} ms", ms(budget.least_period));
    if (budget.most_nodes > 0) text += fmt::format(", or {} {}", budget.most_nodes, things);
  } else if (budget.most_nodes > 0) {
    text += fmt::format(": take {} {}", budget.most_nodes, things);
  }
  return text;
}

}  // namespace driveline::canopen
