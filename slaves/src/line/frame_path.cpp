#include "driveline/slaves/line/frame_path.hpp"

namespace driveline::slaves {

namespace {

/// Frames leave a controller at the next open port after the port where they were received.
constexpr std::array<unsigned, kPortCount> kNextPort = {3, 2, 0, 1};

}  // namespace

void FramePath::trace(const Wiring& wiring, std::span<const SlavePorts> slaves, MasterPort from) {
  steps_.clear();
  received_.assign(wiring.slave_count(), {kNotReceived, kNotReceived, kNotReceived, kNotReceived});
  exit_.reset();
  blocked_.reset();
  delay_ = {};
  const auto& start = wiring.master(from);
  if (!start) return;
  PortId at = *start;
  auto time = wiring.at(at).delay;
  if (wiring.at(at).broken) return;
  // Each port is entered at most once; a frame that would enter a port again circulates endlessly.
  for (std::size_t hops = 0; hops < wiring.slave_count() * kPortCount; ++hops) {
    const auto& slave = slaves[at.slave];
    if (slave.closed[at.port]) {
      blocked_ = at;
      return;
    }
    received_[at.slave][at.port] = time;
    bool processed = false;
    unsigned port = at.port;
    for (unsigned turn = 0; turn <= kPortCount; ++turn) {
      if (port == 0 && !processed) {
        steps_.push_back({at.slave, time, turn != 0});
        processed = true;
      }
      port = kNextPort[port];
      if (!slave.closed[port]) break;
    }
    time += processed ? slave.delays.processing : slave.delays.forwarding;
    const auto& end = wiring.at({at.slave, port});
    if (end.kind == Wiring::End::Kind::kNothing || end.broken) return;  // open port without a link
    time += end.delay;
    if (end.kind == Wiring::End::Kind::kMaster) {
      exit_ = end.master;
      delay_ = time;
      return;
    }
    at = end.slave;
  }
}

}  // namespace driveline::slaves
