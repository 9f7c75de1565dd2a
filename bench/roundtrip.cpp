// How long does a frame take from a master's port to the other end of a cable and back, compared with a bare loop on
// the same kind of socket? Every method has a cable of its own and takes its turn on the same processor.
#include <fmt/format.h>
#include <sys/socket.h>
#include <algorithm>
#include <array>
#include <atomic>
#include <memory>
#include <span>
#include <stdexcept>
#include <thread>
#include <vector>

#include "driveline/port/raw_socket_port.hpp"
#include "driveline/port/xdp_port.hpp"
#include "driveline/wire/ethernet.hpp"
#include "support/packet_ring.hpp"
#include "support/packet_socket.hpp"
#include "support/realtime.hpp"
#include "support/report.hpp"
#include "support/retry.hpp"
#include "support/stopwatch.hpp"
#include "support/veth_pair.hpp"
#include "support/xdp_loop.hpp"

namespace {

using namespace driveline;
using namespace driveline::bench;

constexpr int kFrames = 20'000;
/// So short that a disturbance of the machine affects all methods alike.
constexpr int kFramesPerTurn = 100;
constexpr int kWarmUp = 20;
constexpr double kLostNs = 1e9;
/// Aim: median of a port over that of the bare loop on the same kind of socket.
constexpr double kPortAim = 1.05;
/// Aim: median of a port with more than a packet socket over that of the bare loop on a packet socket.
constexpr double kFasterAim = 0.9;
/// Sizes with headers: the Ethernet minimum, a drive with mailboxes, process data of thirty drives, the maximum.
constexpr std::array<std::size_t, 4> kFrameBytes = {60, 256, 1024, 1514};
/// Offset of the number of the round trip, after the headers.
constexpr std::size_t kNumberAt = 30;

/// The frame that all methods send: broadcast, so that the other end accepts it.
class Frame {
 public:
  explicit Frame(std::size_t bytes) : bytes_(bytes) {
    std::fill_n(bytes_.begin(), 6, std::byte{0xFF});
    bytes_[6] = std::byte{0x04};
    bytes_[12] = static_cast<std::byte>(wire::kEtherTypeEtherCat >> 8);
    bytes_[13] = static_cast<std::byte>(wire::kEtherTypeEtherCat & 0xFF);
  }
  std::span<const std::byte> numbered(int number) noexcept {
    bytes_[kNumberAt] = static_cast<std::byte>(number);
    return bytes_;
  }
  /// Whether this is the answer to the last numbered frame.
  [[nodiscard]] bool is_answer(std::span<const std::byte> answer) const noexcept {
    return answer.size() == bytes_.size() && answer[kNumberAt] == bytes_[kNumberAt] &&
           answer[6] == (bytes_[6] | std::byte{0x02});
  }

 private:
  std::vector<std::byte> bytes_;
};

/// A method of sending a frame and receiving it back.
class Way {
 public:
  Way() = default;
  Way(const Way&) = delete;
  Way& operator=(const Way&) = delete;
  virtual ~Way() = default;
  /// Sends `frame`, spins until a frame comes in, and returns that; empty: none came in, or `frame` was not sent.
  virtual std::span<const std::byte> exchange(std::span<const std::byte> frame) noexcept = 0;
};

/// send() and recv(), the minimum for a master on a plain packet socket.
class PlainLoop final : public Way {
 public:
  explicit PlainLoop(const std::string& interface) { socket_.bind_to(interface); }
  std::span<const std::byte> exchange(std::span<const std::byte> frame) noexcept override {
    const double begin = now_ns();
    if (send(socket_.get(), frame.data(), frame.size(), 0) < 0) return {};
    for (;;) {
      const auto size = recv(socket_.get(), buffer_.data(), buffer_.size(), MSG_TRUNC);
      if (size > 0) return std::span(buffer_).first(std::min(static_cast<std::size_t>(size), buffer_.size()));
      if (now_ns() - begin > kLostNs) return {};
    }
  }

 private:
  PacketSocket socket_;
  std::array<std::byte, port::kMaxFrameBytes> buffer_{};
};

/// send() and a receive ring.
class RingLoop final : public Way {
 public:
  explicit RingLoop(const std::string& interface) : ring_(socket_.get()) { socket_.bind_to(interface); }
  std::span<const std::byte> exchange(std::span<const std::byte> frame) noexcept override {
    const double begin = now_ns();
    if (send(socket_.get(), frame.data(), frame.size(), 0) < 0) return {};
    while (!ring_.take_into(buffer_)) {
      if (now_ns() - begin > kLostNs) return {};
    }
    return std::span(buffer_).first(frame.size());
  }

 private:
  PacketSocket socket_;
  PacketRing ring_;
  std::array<std::byte, port::kMaxFrameBytes> buffer_{};
};

/// An AF_XDP socket; the kernel copies the frames.
class BareXdp final : public Way {
 public:
  explicit BareXdp(const std::string& interface) : loop_(interface) {}
  std::span<const std::byte> exchange(std::span<const std::byte> frame) noexcept override {
    const double begin = now_ns();
    if (!loop_.send(frame)) return {};
    for (;;) {
      if (const auto answer = loop_.take()) return *answer;
      if (now_ns() - begin > kLostNs) return {};
    }
  }

 private:
  XdpLoop loop_;
};

/// A port as the master uses it.
class ThroughPort final : public Way {
 public:
  explicit ThroughPort(std::unique_ptr<port::Port> port) : port_(std::move(port)) {}
  std::span<const std::byte> exchange(std::span<const std::byte> frame) noexcept override {
    const double begin = now_ns();
    if (port_->send(frame) != port::SendStatus::kSent) return {};
    for (;;) {
      if (const auto answer = port_->receive()) return answer->bytes;
      if (now_ns() - begin > kLostNs) return {};
    }
  }

 private:
  std::unique_ptr<port::Port> port_;
};

/// The clock of the ports.
rt::MonotonicClock& port_clock() {
  static rt::MonotonicClock clock;
  return clock;
}

std::unique_ptr<Way> raw_port(const std::string& interface, bool ring) {
  auto port = port::RawSocketPort::open({.interface = interface, .receive_ring = ring}, port_clock());
  if (!port) throw std::runtime_error(port.error().message);
  if ((*port)->has_receive_ring() != ring) throw std::runtime_error(interface + ": the kernel gives no receive ring");
  return std::make_unique<ThroughPort>(std::move(*port));
}

std::unique_ptr<Way> xdp_port(const std::string& interface) {
  // Pairs of virtual interfaces do not support zero copy.
  auto port = port::XdpPort::open(
      {.interface = interface, .first = port::XdpMode::kNative, .last = port::XdpMode::kNative}, port_clock());
  if (!port) throw std::runtime_error(port.error().message);
  return std::make_unique<ThroughPort>(std::move(*port));
}

/// A kind of socket, bare and through the port that uses it. To add a kind, add an entry.
struct Kind {
  const char* name;
  const char* bare_name;
  std::unique_ptr<Way> (*make_bare)(const std::string& interface);
  std::unique_ptr<Way> (*make_port)(const std::string& interface);
};

/// The first one is the packet socket; the aim is that the others are faster.
constexpr std::array kKinds = {
    Kind{"packet_socket", "bare_packet_socket_loop",
         [](const std::string& interface) -> std::unique_ptr<Way> { return std::make_unique<PlainLoop>(interface); },
         [](const std::string& interface) { return raw_port(interface, false); }},
    Kind{"receive_ring", "bare_receive_ring_loop",
         [](const std::string& interface) -> std::unique_ptr<Way> { return std::make_unique<RingLoop>(interface); },
         [](const std::string& interface) { return raw_port(interface, true); }},
    Kind{"af_xdp", "bare_af_xdp_loop",
         [](const std::string& interface) -> std::unique_ptr<Way> { return std::make_unique<BareXdp>(interface); },
         [](const std::string& interface) { return xdp_port(interface); }},
};

/// Why AF_XDP, the last kind, cannot be measured here; empty: it can.
std::string no_af_xdp(const std::string& interface) {
  const auto port = port::XdpPort::open(
      {.interface = interface, .first = port::XdpMode::kNative, .last = port::XdpMode::kNative}, port_clock());
  return port ? std::string{} : port.error().message;
}

/// The other ends of all cables, on a processor of their own: returns the frames of the cable that takes its turn.
class Responder {
 public:
  explicit Responder(const std::vector<VethPair>& cables) : sockets_(cables.size()) {
    for (std::size_t i = 0; i < cables.size(); ++i) sockets_[i].bind_to(cables[i].far);
    thread_ = std::jthread([this](const std::stop_token& stop) { run(stop); });
    // Sleep, because the responder starts on the processor of the thread that created it.
    while (!ready_.load(std::memory_order_acquire)) std::this_thread::sleep_for(std::chrono::milliseconds{1});
  }
  void listen_at(std::size_t cable) noexcept { cable_.store(cable, std::memory_order_release); }

 private:
  void run(const std::stop_token& stop) {
    claim_cpu(last_cpu());
    ready_.store(true, std::memory_order_release);
    std::array<std::byte, port::kMaxFrameBytes> frame{};
    while (!stop.stop_requested()) {
      const auto& socket = sockets_[cable_.load(std::memory_order_acquire)];
      const auto size = recv(socket.get(), frame.data(), frame.size(), 0);
      if (size <= 0) continue;
      frame[6] |= std::byte{0x02};
      keep(send(socket.get(), frame.data(), static_cast<std::size_t>(size), 0));
    }
  }

  std::vector<PacketSocket> sockets_;
  std::atomic<std::size_t> cable_{0};
  std::atomic<bool> ready_{false};
  std::jthread thread_;
};

/// A method with its cable and its measurements, in ns.
struct Contestant {
  std::unique_ptr<Way> way;
  std::size_t cable = 0;
  TurnSamples round_trips{};
};

void take_turn(Contestant& contestant, Responder& responder, Frame& frame) {
  responder.listen_at(contestant.cable);
  std::vector<double> samples;
  for (int i = -kWarmUp; i < kFramesPerTurn; ++i) {
    const auto bytes = frame.numbered(i);
    const double begin = now_ns();
    const auto answer = contestant.way->exchange(bytes);
    const double end = now_ns();
    if (answer.empty()) throw Disturbed("a frame was not sent, or did not come back within a second");
    if (!frame.is_answer(answer)) throw Disturbed("a frame came in that is not the one that was sent last");
    if (i >= 0) samples.push_back(end - begin - reading_cost_ns());
  }
  contestant.round_trips.add_turn(samples);
}

using Contestants = std::vector<Contestant>;

/// Measures all methods in turns with frames of this size: bare loop and port of the first kind, of the second, and so
/// on.
Contestants compare(std::span<const Kind> kinds, const std::vector<VethPair>& cables, std::size_t bytes, int frames) {
  Contestants contestants;
  for (const auto& kind : kinds) {
    for (const auto make : {kind.make_bare, kind.make_port}) {
      const auto cable = contestants.size();
      contestants.push_back({make(cables[cable].near), cable});
    }
  }
  Responder responder(cables);
  Frame frame(bytes);
  Rests rests;
  for (int turn = 0; turn < std::max(2, frames / kFramesPerTurn); ++turn) {
    for (auto& contestant : contestants) {
      rests.take_when_due(now_ns());
      take_turn(contestant, responder, frame);
    }
  }
  return contestants;
}

Baseline compared_with(const char* name, const Contestant& floor, const Contestant& one) {
  return {name, summarize(floor.round_trips.all()),
          ratios_by_turn(one.round_trips.medians(), floor.round_trips.medians())};
}

void measure_size(Report& report, std::span<const Kind> kinds, const std::vector<VethPair>& cables, std::size_t bytes,
                  int frames) {
  const auto name = fmt::format("{}_bytes", bytes);
  fmt::print(stderr, "roundtrip: {} ...\n", name);
  const auto contestants = undisturbed(name, [&] { return compare(kinds, cables, bytes, frames); });
  const auto& packet_socket = contestants.front();
  for (std::size_t i = 0; i < kinds.size(); ++i) {
    const auto& bare = contestants[2 * i];
    const auto& port = contestants[2 * i + 1];
    const auto case_name = fmt::format("{}_{}", name, kinds[i].name);
    const auto figures = summarize(port.round_trips.all());
    const auto floor = compared_with(kinds[i].bare_name, bare, port);
    report.add({case_name, "bare_round_trip", "ns", floor.figures});
    report.add({case_name, "round_trip", "ns", figures, kPortAim * floor.figures.p50, floor});
    if (i == 0) continue;
    const auto common = compared_with(kinds[0].bare_name, packet_socket, port);
    report.add({case_name, "against_packet_socket", "ns", figures, kFasterAim * common.figures.p50, common});
  }
}

void measure_all(const Options& options) {
  Report report("roundtrip");
  auto obstacle = enter_private_network();
  std::vector<VethPair> cables;
  for (std::size_t i = 0; i < 2 * kKinds.size() && obstacle.empty(); ++i) {
    const auto cable = make_veth_pair(fmt::format("trip{}", i));
    if (!cable) obstacle = "no veth pair: the kernel lacks the driver or `ip` is not installed";
    if (cable) cables.push_back(*cable);
  }
  std::span<const Kind> kinds = kKinds;
  if (obstacle.empty()) {
    // The other kinds are measured all the same.
    obstacle = no_af_xdp(cables.front().near);
    if (!obstacle.empty()) kinds = kinds.first(kKinds.size() - 1);
    claim_cpu(std::max(0, last_cpu() - 1));
    for (const auto bytes : kFrameBytes) measure_size(report, kinds, cables, bytes, options.count(kFrames));
  }
  report.note(fmt::format(
      "From before a frame is sent until it is in this program's memory again, over a veth pair; a responder\n"
      "spins at its other end. Bare loops and ports by turns of {} frames on one processor.",
      kFramesPerTurn));
  report.print(options);
  if (!obstacle.empty()) throw Skipped(obstacle);
}

}  // namespace

int main(int argc, char** argv) {
  return run(argc, argv, "How long does a frame to the other end of a cable and back take, by port and size?",
             measure_all);
}
