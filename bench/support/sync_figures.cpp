#include "support/sync_figures.hpp"

#include <fcntl.h>
#include <linux/can.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <stdexcept>
#include <stop_token>
#include <thread>
#include <vector>

#include "driveline/canopen_master/can_cycle.hpp"
#include "driveline/canopen_port/socketcan_port.hpp"
#include "driveline/motion/cycle/cycle_runner.hpp"
#include "driveline/rt/time_conversion.hpp"
#include "support/realtime.hpp"
#include "support/retry.hpp"
#include "support/samples.hpp"

namespace driveline::bench {
namespace {

using canopen::Frame;
using std::chrono::nanoseconds;

constexpr nanoseconds kSyncEvery = std::chrono::milliseconds{2};
constexpr nanoseconds kAhead = std::chrono::microseconds{100};
constexpr std::uint32_t kSync = 0x80;
constexpr std::uint8_t kNodes = 8;
constexpr double kSyncAim = 1.1;  ///< 99th percentiles, over the bare loop
constexpr int kSettlingCycles = 10;

/// The other end of the bus.
class Peers {
 public:
  explicit Peers(rt::FileDescriptor end) : end_(std::move(end)), thread_([this] { answer(); }) {}
  ~Peers() { ::shutdown(end_.get(), SHUT_RDWR); }
  Peers(const Peers&) = delete;
  Peers& operator=(const Peers&) = delete;

 private:
  void answer() const {
    can_frame frame{};
    while (::recv(end_.get(), &frame, sizeof frame, 0) == sizeof frame) {
      if (frame.can_id != kSync) continue;
      for (std::uint8_t node = 1; node <= kNodes; ++node) {
        can_frame pdo{};
        pdo.can_id = 0x180U + node;
        pdo.len = 6;
        pdo.data[0] = 0x37;
        static_cast<void>(::send(end_.get(), &pdo, sizeof pdo, MSG_NOSIGNAL | MSG_DONTWAIT));
      }
    }
  }

  rt::FileDescriptor end_;
  std::jthread thread_;
};

/// Notes when the last SYNC had left.
class NotingPort final : public canopen::CanPort {
 public:
  NotingPort(canopen::CanPort& inner, rt::Clock& clock) : inner_(inner), clock_(clock) {}

  [[nodiscard]] nanoseconds left_at() const noexcept { return left_at_; }
  [[nodiscard]] canopen::SendStatus send(const Frame& frame) noexcept override {
    const auto status = inner_.send(frame);
    if (frame.identifier.value == kSync) left_at_ = clock_.now();
    return status;
  }
  [[nodiscard]] std::optional<canopen::ReceivedFrame> receive() noexcept override { return inner_.receive(); }
  bool wait_readable(nanoseconds deadline) noexcept override { return inner_.wait_readable(deadline); }
  [[nodiscard]] canopen::PortStatistics statistics() const noexcept override { return inner_.statistics(); }

 private:
  canopen::CanPort& inner_;
  rt::Clock& clock_;
  nanoseconds left_at_{0};
};

/// A cycle of which the time is noted at which each SYNC left after its grid instant; skipped periods count whole.
class NotedCycle final : public motion::Cycle {
 public:
  NotedCycle(motion::Cycle& inner, const NotingPort& port, std::size_t count) : inner_(inner), port_(port) {
    late_ns.reserve(count);
  }
  [[nodiscard]] nanoseconds period() const noexcept override { return inner_.period(); }
  [[nodiscard]] nanoseconds first_grid(nanoseconds earliest) const noexcept override {
    return inner_.first_grid(earliest);
  }
  [[nodiscard]] nanoseconds grid_shift() const noexcept override { return inner_.grid_shift(); }
  void prepare() noexcept override { inner_.prepare(); }
  void cycle(const rt::CycleStart& start) noexcept override {
    inner_.cycle(start);
    if (++cycles_ <= kSettlingCycles || late_ns.size() == late_ns.capacity()) return;
    late_ns.push_back(static_cast<double>((port_.left_at() - start.grid + start.missed * kSyncEvery).count()));
  }
  std::vector<double> late_ns;

 private:
  motion::Cycle& inner_;
  const NotingPort& port_;
  int cycles_ = 0;
};

/// Sleeps and sends, nothing else.
class BareLoop final : public rt::RealtimeTask {
 public:
  BareLoop(NotingPort& port, rt::Clock& clock, std::size_t count) : port_(port), clock_(clock) {
    late_ns.reserve(count);
  }
  void run(std::stop_token stop) noexcept override {
    const Frame sync = Frame::of(kSync, {});
    nanoseconds next = clock_.now() / kSyncEvery * kSyncEvery + 4 * kSyncEvery;
    for (int i = 0; !stop.stop_requested(); ++i) {
      const auto until = rt::to_timespec(next);
      while (clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &until, nullptr) == EINTR) {
      }
      static_cast<void>(port_.send(sync));
      const auto late = port_.left_at() - next;
      if (i >= kSettlingCycles && late_ns.size() < late_ns.capacity()) {
        late_ns.push_back(static_cast<double>(late.count()));
      }
      while (port_.receive()) {
      }
      next += (late / kSyncEvery + 1) * kSyncEvery;
    }
  }
  std::vector<double> late_ns;

 private:
  NotingPort& port_;
  rt::Clock& clock_;
};

canopen::MasterPlan plan_of_eight() {
  canopen::MasterPlan plan;
  plan.period = kSyncEvery;
  for (std::uint8_t id = 1; id <= kNodes; ++id) {
    auto& node = plan.nodes.emplace_back();
    node.name = std::to_string(id);
    node.id = id;
    node.rpdos = {{.number = 2, .objects = {{0x60C1, 1, 32}}}};
    node.tpdos = {{.number = 1, .objects = {{0x6041, 0, 16}, {0x6064, 0, 32}}}};
  }
  return plan;
}

/// One turn of the master.
std::vector<double> turn_of_master(NotingPort& port, rt::Clock& clock, double seconds, std::size_t count) {
  const auto plan = plan_of_eight();
  canopen::AcyclicChannel channel;
  canopen::CanCycle cycle(port, clock, plan, *canopen::PdoImage::build(plan), channel, nullptr, {}, {});
  for (std::size_t node = 0; node < plan.nodes.size(); ++node) cycle.set_operational(node, true);
  NotedCycle noted(cycle, port, count);
  rt::RealtimeConfig config;
  config.policy = rt::RealtimePolicy::kDegrade;
  config.cpu = last_cpu();
  motion::RealtimeRunner runner(noted, clock, config, kAhead);
  if (!runner.start()) throw std::runtime_error("the thread of the cycle cannot be created");
  runner.pass(std::chrono::duration_cast<nanoseconds>(std::chrono::duration<double>(seconds)));
  runner.stop();
  return std::move(noted.late_ns);
}

std::vector<double> turn_of_loop(NotingPort& port, rt::Clock& clock, double seconds, std::size_t count) {
  BareLoop loop(port, clock, count);
  rt::RealtimeThread thread;
  start_realtime(thread, loop);
  std::this_thread::sleep_for(std::chrono::duration<double>(seconds));
  thread.request_stop();
  thread.join();
  return std::move(loop.late_ns);
}

double percentile_99(std::vector<double> samples) {
  if (samples.empty()) throw Disturbed("no SYNC was sent in a turn");
  std::sort(samples.begin(), samples.end());
  return samples[samples.size() * 99 / 100];
}

}  // namespace

void measure_sync(Report& report, int pairs, double seconds) {
  std::array<int, 2> ends{};
  if (::socketpair(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC | SOCK_NONBLOCK, 0, ends.data()) != 0) {
    throw std::runtime_error("no pair of sockets");
  }
  rt::MonotonicClock clock;
  canopen::SocketCanPort bus(rt::FileDescriptor(ends[0]), {}, clock);
  NotingPort port(bus, clock);
  rt::FileDescriptor other(ends[1]);
  const int flags = ::fcntl(other.get(), F_GETFL);
  ::fcntl(other.get(), F_SETFL, flags & ~O_NONBLOCK);
  const Peers peers(std::move(other));
  const auto count = static_cast<std::size_t>(2.0 * seconds * 500.0);
  TurnSamples of_master;
  TurnSamples of_loop;
  std::vector<double> master_p99;
  std::vector<double> loop_p99;
  for (int pair = 0; pair < pairs; ++pair) {
    // Each is the first one of every other pair.
    std::vector<double> loop;
    if (pair % 2 != 0) loop = turn_of_loop(port, clock, seconds, count);
    const auto master = turn_of_master(port, clock, seconds, count);
    if (pair % 2 == 0) loop = turn_of_loop(port, clock, seconds, count);
    master_p99.push_back(percentile_99(master));
    loop_p99.push_back(percentile_99(loop));
    of_master.add_turn(master);
    of_loop.add_turn(loop);
  }
  const Baseline floor{"sleep_and_send_loop", summarize(of_loop.all()),
                       ratios_by_turn(of_master.medians(), of_loop.medians())};
  report.add({"sync_of_8_axes", "leaves_behind_the_grid", "ns", summarize(of_master.all()), std::nullopt, floor});
  const Summary floor_p99 = summarize(loop_p99);
  report.add({"sync_of_8_axes", "p99_of_a_turn", "ns", summarize(master_p99), kSyncAim * floor_p99.p50,
              Baseline{"sleep_and_send_loop", floor_p99, ratios_by_turn(master_p99, loop_p99)}});
}

}  // namespace driveline::bench
