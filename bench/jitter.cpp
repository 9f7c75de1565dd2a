// How punctual is a cycle of 125 us: its wake-up, the sending of its frame, and the frame's arrival as the other side
// sees it? Against a bare loop and against cyclictest, in turns on one processor, idle and under load.
#include <fmt/format.h>
#include <sys/socket.h>
#include <sys/uio.h>
#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <ctime>
#include <map>
#include <memory>
#include <semaphore>
#include <span>
#include <stdexcept>
#include <thread>
#include <vector>

#include "driveline/port/raw_socket_port.hpp"
#include "driveline/rt/clock.hpp"
#include "driveline/rt/cycle_timer.hpp"
#include "driveline/rt/time_conversion.hpp"
#include "support/child_program.hpp"
#include "support/cyclictest.hpp"
#include "support/microsecond_bins.hpp"
#include "support/packet_socket.hpp"
#include "support/realtime.hpp"
#include "support/report.hpp"
#include "support/veth_pair.hpp"

namespace {

using namespace driveline;
using namespace driveline::bench;
using namespace std::chrono_literals;
using std::chrono::nanoseconds;

constexpr nanoseconds kPeriod = 125us;
/// Of each way of waiting, in one turn: half a second, so that a disturbance of the machine meets all of them.
constexpr int kCyclesPerTurn = 4'000;
/// Each way in each state of the machine, unless --duration says otherwise.
constexpr double kSeconds = 20.0;
/// Cycles at the start of a turn that do not count: until caches are warm, and the timer knows what a wake-up takes.
constexpr int kWarmUp = 200;
/// What a master of one drive sends, padded to the least that Ethernet carries.
constexpr std::size_t kFrameBytes = 60;
/// In the data of the frame, behind its headers.
constexpr std::size_t kWayAt = 26;
constexpr std::size_t kTurnAt = 28;
constexpr std::size_t kInstantAt = 32;

enum class Way : std::uint8_t { kBareLoop, kCycle, kCycleAsleep };
constexpr std::array kWays = {Way::kBareLoop, Way::kCycle, Way::kCycleAsleep};

const char* name_of(Way way) {
  constexpr std::array kNames = {"bare_loop", "cycle", "cycle_pure_sleep"};
  return kNames[static_cast<std::size_t>(way)];
}

/// One cycle of a turn.
struct Moment {
  std::int64_t instant = 0;  ///< of the grid
  std::int64_t missed = 0;   ///< instants just before
  nanoseconds late{};        ///< of the wake-up, from the first that was missed
  nanoseconds sent{};        ///< the same of the frame, when it was handed to the kernel
};

/// A frame that is addressed to nobody: who gets it counts it.
class Frame {
 public:
  explicit Frame(Way way) {
    bytes_.fill(std::byte{0});
    std::fill_n(bytes_.begin(), 6, std::byte{0xFF});
    bytes_[6] = std::byte{0x02};
    bytes_[12] = std::byte{0x88};
    bytes_[13] = std::byte{0xA4};
    bytes_[kWayAt] = static_cast<std::byte>(way);
  }
  std::span<const std::byte> stamped(std::uint32_t turn, std::int64_t instant) noexcept {
    std::memcpy(bytes_.data() + kTurnAt, &turn, sizeof turn);
    std::memcpy(bytes_.data() + kInstantAt, &instant, sizeof instant);
    return bytes_;
  }

 private:
  std::array<std::byte, kFrameBytes> bytes_{};
};

/// Takes the turns of all ways of waiting, one after the other, when it is told to; its thread lives for all of them.
class Turns final : public rt::RealtimeTask {
 public:
  Turns(port::Port& port, const std::string& interface) : port_(port) {
    socket_.bind_to(interface);
    for (auto& moments : moments_) moments.resize(kCyclesPerTurn);
  }
  void run(std::stop_token stop) noexcept override {
    for (;;) {
      go_.acquire();
      if (stop.stop_requested()) return;
      bare_loop(moments_[0]);
      through_timer(Way::kCycle, ahead_, moments_[1]);
      through_timer(Way::kCycleAsleep, asleep_, moments_[2]);
      done_.release();
    }
  }
  /// Another thread: one turn of each.
  void take(std::uint32_t turn) {
    turn_ = turn;
    go_.release();
    done_.acquire();
    if (failed_sends_ > 0) throw std::runtime_error("a frame could not be sent");
  }
  /// Wakes the task, so that it sees that it is to stop.
  void leave() { go_.release(); }
  [[nodiscard]] const std::vector<Moment>& moments(Way way) const { return moments_[static_cast<std::size_t>(way)]; }

 private:
  /// The floor: clock_nanosleep to absolute times, and a frame.
  void bare_loop(std::vector<Moment>& moments) noexcept {
    Frame frame(Way::kBareLoop);
    auto next = clock_.now() + 4 * kPeriod;
    std::int64_t instant = 0;
    for (int i = -kWarmUp; i < kCyclesPerTurn; ++i) {
      const auto until = rt::to_timespec(next);
      while (clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &until, nullptr) == EINTR) {
      }
      const auto late = clock_.now() - next;
      const auto missed = late / kPeriod;
      const auto bytes = frame.stamped(turn_, instant + missed);
      if (send(socket_.get(), bytes.data(), bytes.size(), 0) < 0) ++failed_sends_;
      const auto sent = clock_.now() - next;
      if (i >= 0) moments[static_cast<std::size_t>(i)] = {instant + missed, missed, late, sent};
      instant += missed + 1;
      next += (missed + 1) * kPeriod;
    }
  }
  /// The cycle timer and the port of the master, the frame first of all, as the cycle does it.
  void through_timer(Way way, rt::CycleTimer& timer, std::vector<Moment>& moments) noexcept {
    Frame frame(way);
    timer.start(clock_.now() + 4 * kPeriod);
    for (int i = -kWarmUp; i < kCyclesPerTurn; ++i) {
      const auto start = timer.wait_next();
      if (port_.send(frame.stamped(turn_, start.cycle)) != port::SendStatus::kSent) ++failed_sends_;
      const auto late = start.late(kPeriod);
      const auto sent = late + (clock_.now() - start.wake);
      if (i >= 0) moments[static_cast<std::size_t>(i)] = {start.cycle, start.missed, late, sent};
    }
  }

  port::Port& port_;
  PacketSocket socket_;
  rt::MonotonicClock clock_;
  rt::CycleTimer ahead_{clock_, kPeriod, std::nullopt};  ///< as `run` has it
  rt::CycleTimer asleep_{clock_, kPeriod};               ///< with wake_ahead_us = 0
  std::array<std::vector<Moment>, kWays.size()> moments_;
  std::uint32_t turn_ = 0;
  std::uint64_t failed_sends_ = 0;
  std::binary_semaphore go_{0};
  std::binary_semaphore done_{0};
};

/// Ends the task whatever comes: its thread waits for a turn.
struct Leaving {
  rt::RealtimeThread& thread;
  Turns& turns;
  ~Leaving() {
    thread.request_stop();
    turns.leave();
  }
};

/// A frame at the other end of the cable, stamped by the kernel when it came in; how late it is looked at does not
/// matter.
struct Arrival {
  Way way{};
  std::uint32_t turn = 0;
  std::int64_t instant = 0;
  nanoseconds time{};
};

/// The other end of the cable, on another processor.
class Receiver {
 public:
  explicit Receiver(const std::string& interface) : socket_(PacketSocket::Look::kSleeps) {
    const int bytes = 8 << 20;
    setsockopt(socket_.get(), SOL_SOCKET, SO_RCVBUFFORCE, &bytes, sizeof bytes);
    const int on = 1;
    if (setsockopt(socket_.get(), SOL_SOCKET, SO_TIMESTAMPNS, &on, sizeof on) != 0)
      throw std::runtime_error("the kernel gives no time stamps of frames that come in");
    socket_.bind_to(interface);
    thread_ = std::jthread([this](const std::stop_token& stop) { run(stop); });
  }
  /// All frames so far, when no more are on their way.
  std::vector<Arrival> finish() {
    std::this_thread::sleep_for(100ms);
    thread_.request_stop();
    thread_.join();
    return std::move(arrivals_);
  }

 private:
  void run(const std::stop_token& stop) {
    claim_cpu(std::max(0, last_cpu() - 1));
    while (!stop.stop_requested()) take();
  }
  void take() {
    std::array<std::byte, kFrameBytes> bytes{};
    alignas(cmsghdr) std::array<std::byte, 128> control{};
    iovec part{bytes.data(), bytes.size()};
    msghdr message{};
    message.msg_iov = &part;
    message.msg_iovlen = 1;
    message.msg_control = control.data();
    message.msg_controllen = control.size();
    if (recvmsg(socket_.get(), &message, 0) < static_cast<ssize_t>(kFrameBytes)) return;
    for (auto* header = CMSG_FIRSTHDR(&message); header != nullptr; header = CMSG_NXTHDR(&message, header)) {
      if (header->cmsg_level != SOL_SOCKET || header->cmsg_type != SCM_TIMESTAMPNS) continue;
      std::timespec stamp{};
      std::memcpy(&stamp, CMSG_DATA(header), sizeof stamp);
      Arrival arrival{static_cast<Way>(bytes[kWayAt]), 0, 0, rt::from_timespec(stamp)};
      std::memcpy(&arrival.turn, bytes.data() + kTurnAt, sizeof arrival.turn);
      std::memcpy(&arrival.instant, bytes.data() + kInstantAt, sizeof arrival.instant);
      arrivals_.push_back(arrival);
    }
  }

  PacketSocket socket_;
  std::vector<Arrival> arrivals_;
  std::jthread thread_;
};

/// What was measured of one way, ns.
struct Delays {
  std::vector<double> wake;
  std::vector<double> send;
  std::vector<double> arrival;  ///< how far the distance to the frame before is from the period
};

void add_moments(Delays& to, const std::vector<Moment>& moments) {
  for (const auto& moment : moments) {
    add_delays(to.wake, moment.late, moment.missed, kPeriod);
    add_delays(to.send, moment.sent, moment.missed, kPeriod);
  }
}

/// The other side does not know the grid: what it can see is the distance of two frames.
void add_arrivals(std::map<Way, Delays>& to, const std::vector<Arrival>& arrivals) {
  std::map<Way, Arrival> before;
  for (const auto& arrival : arrivals) {
    const auto found = before.find(arrival.way);
    if (found != before.end() && found->second.turn == arrival.turn && found->second.instant >= kWarmUp) {
      const auto missed = arrival.instant - found->second.instant - 1;
      add_delays(to[arrival.way].arrival, arrival.time - found->second.time - kPeriod, missed, kPeriod);
    }
    before[arrival.way] = arrival;
  }
}

void add_row(Report& report, const std::string& name, const char* metric, const std::vector<double>& delays_ns,
             const std::optional<Baseline>& floor = std::nullopt) {
  Row row{name, metric, "ns", summarize(delays_ns), std::nullopt, floor};
  row.bins.emplace().deadline_us = static_cast<double>(kPeriod.count()) / 1000.0;
  row.bins->add(delays_ns);
  report.add(std::move(row));
}

void report_state(Report& report, const std::string& state, const std::map<Way, Delays>& ways,
                  const std::vector<double>& cyclictest) {
  const auto floor_of = [&](std::vector<double> Delays::*what) {
    return Baseline{state + "_bare_loop", summarize(ways.at(Way::kBareLoop).*what)};
  };
  for (const auto& [metric, what] : {std::pair{"wake_latency", &Delays::wake}, std::pair{"send_time", &Delays::send},
                                     std::pair{"arrival_period_off", &Delays::arrival}}) {
    const auto floor = floor_of(what);
    for (const auto way : kWays) {
      const bool bare = way == Way::kBareLoop;
      add_row(report, fmt::format("{}_{}", state, name_of(way)), metric, ways.at(way).*what,
              bare ? std::nullopt : std::optional(floor));
    }
    if (what == &Delays::wake && !cyclictest.empty()) add_row(report, state + "_cyclictest", metric, cyclictest, floor);
  }
}

/// All ways in turns for `seconds` each; the machine is in `state`.
void measure_state(Report& report, const VethPair& cable, const std::string& state, double seconds) {
  rt::MonotonicClock clock;
  auto port = port::RawSocketPort::open({.interface = cable.near}, clock);
  if (!port) throw std::runtime_error(port.error().message);
  Turns turns(**port, cable.near);
  Receiver receiver(cable.far);
  std::map<Way, Delays> ways;
  std::vector<double> cyclictest;
  bool peer = true;
  {
    rt::RealtimeThread thread;
    start_realtime(thread, turns);
    const Leaving leaving{thread, turns};
    const auto per_turn = std::chrono::duration<double>(kCyclesPerTurn * kPeriod).count();
    const auto count = std::max<std::uint32_t>(1, static_cast<std::uint32_t>(seconds / per_turn));
    for (std::uint32_t turn = 0; turn < count; ++turn) {
      turns.take(turn);
      for (const auto way : kWays) add_moments(ways[way], turns.moments(way));
      if (!peer) continue;
      const auto latencies = run_cyclictest({.period = 125us,
                                             .cpu = last_cpu(),
                                             .priority = rt::RealtimeConfig{}.priority.value(),
                                             .loops = kCyclesPerTurn});
      peer = latencies.has_value();
      if (peer) cyclictest.insert(cyclictest.end(), latencies->begin(), latencies->end());
    }
  }
  if (!peer) fmt::print(stderr, "jitter: no comparison with cyclictest: it is not installed (Debian: rt-tests)\n");
  add_arrivals(ways, receiver.finish());
  for (const auto way : kWays) {
    if (ways[way].arrival.empty()) throw std::runtime_error("no frame came in at the other end of the cable");
  }
  report_state(report, state, ways, cyclictest);
}

void measure_all(const Options& options) {
  Report report("jitter");
  auto obstacle = enter_private_network();
  const auto cable = obstacle.empty() ? make_veth_pair("jitter") : std::nullopt;
  if (obstacle.empty() && !cable) obstacle = "no veth pair: the kernel lacks the driver or `ip` is not installed";
  const double seconds = options.duration_s > 0.0 ? options.duration_s : options.quick ? kSeconds / 10 : kSeconds;
  if (obstacle.empty()) {
    measure_state(report, *cable, "idle", seconds);
    // On every processor: arithmetic, memory, system calls. As ordinary work, which a real-time thread goes before.
    const auto load = ChildProgram::start(
        {"stress-ng", "--quiet", "--cpu", "0", "--switch", "1", "--vm", "1", "--vm-bytes", "64M", "--timeout", "0"});
    if (load) {
      std::this_thread::sleep_for(1s);
      const auto must_go_on = [&load] {
        if (load->has_ended()) throw std::runtime_error("stress-ng has ended before the measurement under load");
      };
      must_go_on();
      measure_state(report, *cable, "load", seconds);
      must_go_on();
    } else {
      fmt::print(stderr, "jitter: nothing measured under load: stress-ng is not installed\n");
    }
  }
  report.note(fmt::format(
      "Delays against a grid of 125 us; instants that were missed count, each with its own. Each way for {} s, in "
      "turns of\n"
      "half a second on one processor. send_time: the kernel has taken the frame. arrival_period_off: how far two\n"
      "frames are from 125 us apart at the other end of a veth pair, by the kernel's stamps. cyclictest tells whole\n"
      "microseconds, of a latency beyond the period only that one instant, and the first cycles of each turn, which "
      "the\n"
      "other ways leave out.",
      seconds));
  report.print(options);
  if (!obstacle.empty()) throw Skipped(obstacle);
}

}  // namespace

int main(int argc, char** argv) {
  return run(argc, argv, "How punctual is a cycle of 125 us, its frame, and the frame's arrival?", measure_all);
}
