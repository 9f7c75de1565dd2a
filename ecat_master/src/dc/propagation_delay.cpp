#include "driveline/ecat_master/dc/propagation_delay.hpp"

#include <algorithm>

namespace driveline::ecat_master::dc {
namespace {

constexpr std::uint8_t kPorts = 4;
/// Frames leave a controller at the next open port after the one where they arrived (ESC data sheet I, frame processing
/// order).
constexpr std::array<std::uint8_t, kPorts> kNextPort = {3, 2, 0, 1};
/// Assumed delay of a slave and its cable where nothing can be measured.
constexpr double kAssumedHopNs = 1000.0;

/// The processing unit is behind port 0, even when that port is closed.
bool passes_processing_unit(std::uint8_t from, std::uint8_t to) {
  auto port = from;
  do {
    if (port == 0) return true;
    port = kNextPort[port];
  } while (port != to);
  return false;
}

/// Part of a frame's path through a node: in at the entry, out and in again at each port with a child, out at the
/// entry.
struct Passage {
  std::uint8_t from = 0;
  std::uint8_t to = 0;
};

std::vector<Passage> passages(const DelayNode& node) {
  std::vector<Passage> all;
  auto from = node.entry_port;
  for (auto port = kNextPort[from]; port != node.entry_port; port = kNextPort[port]) {
    if (!node.children[port]) continue;
    all.push_back({from, port});
    from = port;
  }
  all.push_back({from, node.entry_port});
  return all;
}

/// Time from port to port of a node.
double between(const DelayNode& node, std::uint8_t from, std::uint8_t to) {
  return static_cast<double>(node.receive_time_ns[to] - node.receive_time_ns[from]) / node.rate;
}

/// Time spent behind the node: from the entry to the last return.
double span_of(const DelayNode& node) {
  return between(node, node.entry_port, passages(node).back().from);
}

/// Time from the entry to the processing.
double processing_of(const DelayNode& node) {
  for (const auto& passage : passages(node)) {
    if (passes_processing_unit(passage.from, passage.to)) return between(node, node.entry_port, passage.from);
  }
  return 0.0;
}

/// Extra delay of the path through a node compared with a plain hop.
double extra_of(const DelayNode& node, const Passage& passage) {
  return passes_processing_unit(passage.from, passage.to) ? node.processing_extra_ns : 0.0;
}

/// A path around a branch up to the next slaves with receive times. A hop is a path through a node and along a cable.
struct Tour {
  struct Stop {
    std::uint16_t node = 0;
    int hops = 0;           ///< hops up to this stop
    double extra_ns = 0.0;  ///< extra delay of these hops in processing units
    double spans = 0.0;     ///< time spent behind earlier stops
  };
  std::vector<Stop> stops;
  int hops = 0;
  double extra_ns = 0.0;
  double spans = 0.0;
  bool single = true;  ///< a single path without branches: equal in both directions

  void hop(const DelayNode& node, const Passage& passage) {
    ++hops;
    extra_ns += extra_of(node, passage);
  }
};

class DelayComputation {
 public:
  explicit DelayComputation(std::span<const DelayNode> nodes)
      : nodes_(nodes), entry_(nodes.size()), delays_(nodes.size()) {}

  [[nodiscard]] tl::expected<std::vector<PropagationDelay>, DelayContradiction> run() {
    const auto root = find_root();
    if (!root) return delays_;
    start_at(*root);
    while (!waiting_.empty()) {
      const auto node = waiting_.back();
      waiting_.pop_back();
      if (auto wrong = go_around(node)) return tl::unexpected(*wrong);
    }
    refer_to_first();
    return std::move(delays_);
  }

 private:
  [[nodiscard]] std::optional<std::uint16_t> find_root() const {
    std::vector<bool> child(nodes_.size());
    for (const auto& node : nodes_) {
      for (const auto& next : node.children) {
        if (next) child[*next] = true;
      }
    }
    const auto root = std::find(child.begin(), child.end(), false);
    if (root == child.end()) return std::nullopt;
    return static_cast<std::uint16_t>(root - child.begin());
  }

  /// Starts at the master, which has no receive times.
  void start_at(std::uint16_t root) {
    const auto tour = explore(root);
    for (const auto& stop : tour.stops) {
      reach(stop, kAssumedHopNs * stop.hops + stop.spans,
            tour.stops.size() > 1 ? DelayQuality::kAssumed : DelayQuality::kMeasured);
    }
  }

  void reach(const Tour::Stop& stop, double entry_ns, DelayQuality quality) {
    entry_[stop.node] = entry_ns;
    delays_[stop.node] = {entry_ns + processing_of(nodes_[stop.node]), quality};
    waiting_.push_back(stop.node);
  }

  /// Measures all branches of a node whose times are known.
  [[nodiscard]] std::optional<DelayContradiction> go_around(std::uint16_t at) {
    const auto& node = nodes_[at];
    for (const auto& passage : passages(node)) {
      if (passage.to == node.entry_port) break;
      auto tour = explore(*node.children[passage.to]);
      // Add the passage through this node, which explore() does not include.
      const double first = extra_of(node, passage);
      const double loop = between(node, passage.from, passage.to);
      const double hop = (loop - tour.spans - tour.extra_ns - first) / (tour.hops + 1);
      if (hop < 0.0) return DelayContradiction{at, passage.to};
      const double begin = entry_[at] + between(node, node.entry_port, passage.from);
      for (const auto& stop : tour.stops) {
        const int hops = stop.hops + 1;
        // A delay is at most as good as that of the previous slave.
        const auto own = tour.single ? DelayQuality::kMeasured : DelayQuality::kEstimated;
        reach(stop, begin + hop * hops + stop.extra_ns + first + stop.spans, std::max(own, delays_[at].quality));
      }
    }
    return std::nullopt;
  }

  /// Follows the branch that starts with `first`, from its entry to the return. Passes through nodes without receive
  /// times; uses an explicit stack, because they may form a chain of thousands.
  [[nodiscard]] Tour explore(std::uint16_t first) const {
    struct Level {
      std::uint16_t node;
      std::vector<Passage> passages;
      std::size_t next = 0;
    };
    Tour tour;
    std::vector<Level> stack;
    auto enter = [&](std::uint16_t node) {
      if (!nodes_[node].has_receive_times) {
        stack.push_back({node, passages(nodes_[node]), 0});
        tour.single = tour.single && stack.back().passages.size() == 2;
        return;
      }
      tour.stops.push_back({node, tour.hops, tour.extra_ns, tour.spans});
      tour.spans += span_of(nodes_[node]);
      tour.hop(nodes_[node], passages(nodes_[node]).back());
    };
    enter(first);
    while (!stack.empty()) {
      auto& level = stack.back();
      const auto passage = level.passages[level.next++];
      const auto node = level.node;
      tour.hop(nodes_[node], passage);
      if (passage.to == nodes_[node].entry_port) {
        stack.pop_back();
      } else {
        enter(*nodes_[node].children[passage.to]);
      }
    }
    return tour;
  }

  void refer_to_first() {
    const auto first = std::find_if(delays_.begin(), delays_.end(),
                                    [](const PropagationDelay& d) { return d.quality != DelayQuality::kNone; });
    if (first == delays_.end()) return;
    const double origin = first->from_first_ns;
    for (auto& delay : delays_) {
      if (delay.quality != DelayQuality::kNone) delay.from_first_ns -= origin;
    }
  }

  std::span<const DelayNode> nodes_;
  std::vector<double> entry_;  ///< time at which the frame arrives at each node's entry
  std::vector<PropagationDelay> delays_;
  std::vector<std::uint16_t> waiting_;
};

}  // namespace

tl::expected<std::vector<PropagationDelay>, DelayContradiction> propagation_delays(std::span<const DelayNode> nodes) {
  return DelayComputation(nodes).run();
}

}  // namespace driveline::ecat_master::dc
