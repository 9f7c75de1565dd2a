// How punctual is a cycle of 125 us: its wake-up, the sending of its frame, and the frame's arrival at the other end?
// Compared with a bare loop and with cyclictest, in turns on one processor, idle and under load.
#include <fmt/format.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <sys/uio.h>
#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <ctime>
#include <memory>
#include <optional>
#include <semaphore>
#include <span>
#include <stdexcept>
#include <thread>
#include <vector>

#include "driveline/port/raw_socket_port.hpp"
#include "driveline/rt/clock.hpp"
#include "driveline/rt/cycle_timer.hpp"
#include "driveline/rt/switch_log.hpp"
#include "driveline/rt/time_conversion.hpp"
#include "support/child_program.hpp"
#include "support/cyclictest.hpp"
#include "support/delay_histogram.hpp"
#include "support/neighbour_line.hpp"
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
constexpr double kPeriodUs = 125.0;
/// Cycles of each method of waiting per turn: half a second, so that a disturbance of the machine affects all methods.
constexpr int kCyclesPerTurn = 4'000;
/// Duration of each method in each state of the machine, unless --duration is given.
constexpr double kSeconds = 20.0;
constexpr double kSecondsInShort = 8.0;
/// Cycles at the start of a turn that do not count: until caches are warm and the timer has learned the wake-up time.
constexpr int kWarmUp = 200;
/// Size of the frame of a master with one drive, padded to the Ethernet minimum.
constexpr std::size_t kFrameBytes = 60;
/// Offsets in the frame's data, after its headers.
constexpr std::size_t kWayAt = 26;
constexpr std::size_t kTurnAt = 28;
constexpr std::size_t kInstantAt = 32;

/// `kBareLoopAhead` wakes up as long before the instant as the cycle does, and spins until then.
enum class Way : std::uint8_t { kBareLoop, kBareLoopAhead, kCycle, kCycleAsleep };
constexpr std::array kWays = {Way::kBareLoop, Way::kBareLoopAhead, Way::kCycle, Way::kCycleAsleep};

const char* name_of(Way way) {
  constexpr std::array kNames = {"bare_loop", "bare_loop_ahead", "cycle", "cycle_pure_sleep"};
  return kNames[static_cast<std::size_t>(way)];
}

/// Aim: median of the cycle's wake-up latency over that of the bare loop with the same lead.
constexpr double kWakeAim = 1.1;
/// Aim: 99 % of the cycle's send times over 99 % of the wake-up latencies of the bare loop.
constexpr double kSendAim = 0.5;

/// The measurements of a cycle of a turn.
struct Moment {
  std::int64_t instant = 0;  ///< number of the instant on the grid
  std::int64_t missed = 0;   ///< number of instants missed just before
  nanoseconds late{};        ///< latency of the wake-up, from the first missed instant
  nanoseconds sent{};        ///< time until the frame was handed to the kernel, from the same instant
};

/// A broadcast frame; its receiver records the arrival.
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

/// Resource use of the thread of the cycle, counted by the kernel (getrusage(2)).
struct ThreadUse {
  std::int64_t page_faults = 0;
  std::int64_t sleeps = 0;  ///< voluntary context switches
};

ThreadUse use_of_thread() noexcept {
  rusage usage{};
  getrusage(RUSAGE_THREAD, &usage);
  return {usage.ru_minflt + usage.ru_majflt, usage.ru_nvcsw};
}

/// The latest wake-up of the cycle so far, and the threads that ran on its processor from the instant on.
struct LatestWakeUp {
  nanoseconds instant{};  ///< the first missed instant
  nanoseconds wake{};
  std::array<rt::CpuSwitch, 16> switches{};  ///< newest first
  std::size_t count = 0;
};

/// Takes a turn of each method of waiting, one after the other, on request; its thread lives until all turns are done.
class Turns final : public rt::RealtimeTask {
 public:
  /// `log`: of the processor of this task; null: not available.
  Turns(port::Port& port, const std::string& interface, const rt::SwitchLog* log) : port_(port), log_(log) {
    socket_.bind_to(interface);
    for (auto& moments : moments_) moments.resize(kCyclesPerTurn);
  }
  void run(std::stop_token stop) noexcept override {
    for (;;) {
      go_.acquire();
      if (stop.stop_requested()) return;
      bare_loop(Way::kBareLoop, nanoseconds{0});
      through_timer(Way::kCycle, ahead_);
      bare_loop(Way::kBareLoopAhead, ahead_.wake_ahead());
      through_timer(Way::kCycleAsleep, asleep_);
      done_.release();
    }
  }
  /// Takes one turn of each method. Called by another thread.
  void take(std::uint32_t turn) {
    turn_ = turn;
    go_.release();
    done_.acquire();
    if (failed_sends_ > 0) throw std::runtime_error("a frame could not be sent");
  }
  /// Wakes the task, so that it notices the stop request.
  void leave() { go_.release(); }
  [[nodiscard]] const std::vector<Moment>& moments(Way way) const { return moments_[static_cast<std::size_t>(way)]; }
  /// Resource use of the last turn of Way::kCycle.
  [[nodiscard]] const ThreadUse& use() const noexcept { return use_; }
  /// The latest wake-up of all turns of Way::kCycle; needs a log.
  [[nodiscard]] const LatestWakeUp& latest() const noexcept { return latest_; }

 private:
  std::vector<Moment>& moments_of(Way way) noexcept { return moments_[static_cast<std::size_t>(way)]; }
  /// The floor: clock_nanosleep to absolute times, awake from `lead` before them, then sends a frame.
  void bare_loop(Way way, nanoseconds lead) noexcept {
    Frame frame(way);
    auto next = clock_.now() + 4 * kPeriod;
    std::int64_t instant = 0;
    for (int i = -kWarmUp; i < kCyclesPerTurn; ++i) {
      const auto until = rt::to_timespec(next - lead);
      while (clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &until, nullptr) == EINTR) {
      }
      auto late = clock_.now() - next;
      while (late < nanoseconds{0}) late = clock_.now() - next;
      const auto missed = late / kPeriod;
      const auto bytes = frame.stamped(turn_, instant + missed);
      if (send(socket_.get(), bytes.data(), bytes.size(), 0) < 0) ++failed_sends_;
      const auto sent = clock_.now() - next;
      if (i >= 0) moments_of(way)[static_cast<std::size_t>(i)] = {instant + missed, missed, late, sent};
      instant += missed + 1;
      next += (missed + 1) * kPeriod;
    }
  }
  /// Uses the cycle timer and the port of the master, and sends the frame first, as the cycle does.
  void through_timer(Way way, rt::CycleTimer& timer) noexcept {
    Frame frame(way);
    timer.start(clock_.now() + 4 * kPeriod);
    ThreadUse before;
    for (int i = -kWarmUp; i < kCyclesPerTurn; ++i) {
      if (i == 0) before = use_of_thread();
      const auto start = timer.wait_next();
      if (port_.send(frame.stamped(turn_, start.cycle)) != port::SendStatus::kSent) ++failed_sends_;
      const auto late = start.late(kPeriod);
      const auto sent = late + (clock_.now() - start.wake);
      if (i >= 0) moments_of(way)[static_cast<std::size_t>(i)] = {start.cycle, start.missed, late, sent};
      if (i >= 0 && way == Way::kCycle && log_ != nullptr && late > latest_.wake - latest_.instant) keep_latest(start);
    }
    if (way != Way::kCycle) return;
    const auto after = use_of_thread();
    use_ = {after.page_faults - before.page_faults, after.sleeps - before.sleeps};
  }

  void keep_latest(const rt::CycleStart& start) noexcept {
    latest_.instant = start.wake - start.late(kPeriod);
    latest_.wake = start.wake;
    latest_.count = log_->read(latest_.instant, latest_.switches);
  }

  port::Port& port_;
  const rt::SwitchLog* log_;
  LatestWakeUp latest_;
  PacketSocket socket_;
  rt::MonotonicClock clock_;
  rt::CycleTimer ahead_{clock_, kPeriod, std::nullopt};  ///< as in `run`
  rt::CycleTimer asleep_{clock_, kPeriod};               ///< with wake_ahead_us = 0
  std::array<std::vector<Moment>, kWays.size()> moments_;
  ThreadUse use_;
  std::uint32_t turn_ = 0;
  std::uint64_t failed_sends_ = 0;
  std::binary_semaphore go_{0};
  std::binary_semaphore done_{0};
};

/// Ends the task in any case, because its thread waits for a turn.
struct Leaving {
  rt::RealtimeThread& thread;
  Turns& turns;
  ~Leaving() {
    thread.request_stop();
    turns.leave();
  }
};

/// A frame at the other end of the cable, time-stamped by the kernel on arrival, so the receiver may read it late.
struct Arrival {
  Way way{};
  std::uint32_t turn = 0;
  std::int64_t instant = 0;
  nanoseconds time{};
};

/// The distances between frames of each method. The receiver does not know the grid, only the distance between two
/// frames.
class Distances {
 public:
  void add(const Arrival& arrival) {
    auto& before = before_[static_cast<std::size_t>(arrival.way)];
    if (before && before->turn == arrival.turn && before->instant >= kWarmUp) {
      const auto missed = arrival.instant - before->instant - 1;
      off_[static_cast<std::size_t>(arrival.way)].add_late(arrival.time - before->time - kPeriod, missed, kPeriod);
    }
    before = arrival;
  }
  /// Deviations of the distances from the period.
  [[nodiscard]] const DelayHistogram& off(Way way) const { return off_[static_cast<std::size_t>(way)]; }

 private:
  std::array<std::optional<Arrival>, kWays.size()> before_;
  std::array<DelayHistogram, kWays.size()> off_ = {DelayHistogram(kPeriodUs), DelayHistogram(kPeriodUs),
                                                   DelayHistogram(kPeriodUs), DelayHistogram(kPeriodUs)};
};

/// The receiver at the other end of the cable, on another processor.
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
  /// Distances of all frames; waits for frames in flight.
  const Distances& finish() {
    std::this_thread::sleep_for(100ms);
    thread_.request_stop();
    thread_.join();
    return distances_;
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
      if (static_cast<std::size_t>(arrival.way) < kWays.size()) distances_.add(arrival);
    }
  }

  PacketSocket socket_;
  Distances distances_;
  std::jthread thread_;
};

/// Figures of a turn, in ns.
struct TurnFigures {
  Summary wake;
  Summary send;
};

/// The measurements of a method.
struct Delays {
  DelayHistogram wake{kPeriodUs};
  DelayHistogram send{kPeriodUs};
  std::int64_t missed = 0;  ///< missed periods
  TurnFigures last;         ///< figures of the last turn
};

/// All methods in a state of the machine, and the ratios of the cycle's turns to those of the others.
struct State {
  std::array<Delays, kWays.size()> ways;
  bool with_cyclictest = true;
  Delays cyclictest;
  ThreadUse use;
  std::vector<RanInstead> ran_instead;                  ///< during the latest wake-up of the cycle, until it ran
  std::array<RatioTurns, kWays.size()> wake_over_bare;  ///< ratios of medians, of each method
  std::array<RatioTurns, kWays.size()> send_over_bare;
  RatioTurns wake_over_ahead;  ///< medians, cycle over the bare loop with the same lead
  RatioTurns send_over_wake;   ///< 99 %, cycle over bare loop
  RatioTurns p999_over_cyclictest;
  RatioTurns max_over_cyclictest;

  Delays& of(Way way) { return ways[static_cast<std::size_t>(way)]; }
  [[nodiscard]] const Delays& of(Way way) const { return ways[static_cast<std::size_t>(way)]; }
};

void add_moments(Delays& to, const std::vector<Moment>& moments) {
  std::vector<double> wake;
  std::vector<double> send;
  for (const auto& moment : moments) {
    to.wake.add_late(moment.late, moment.missed, kPeriod);
    to.send.add_late(moment.sent, moment.missed, kPeriod);
    to.missed += moment.missed;
    wake.push_back(static_cast<double>(moment.late.count()));
    send.push_back(static_cast<double>(moment.sent.count()));
  }
  to.last = {summarize(std::move(wake)), summarize(std::move(send))};
}

/// False: cyclictest is not installed.
bool add_cyclictest(Delays& to) {
  const auto latencies_ns = run_cyclictest(
      {.period = 125us, .cpu = last_cpu(), .priority = rt::RealtimeConfig{}.priority.value(), .loops = kCyclesPerTurn});
  if (!latencies_ns) return false;
  for (const double latency_ns : *latencies_ns) {
    const nanoseconds latency{static_cast<std::int64_t>(latency_ns)};
    to.wake.add(latency);
    to.missed += latency / kPeriod;
  }
  to.last.wake = summarize(*latencies_ns);
  return true;
}

/// Adds the ratios of the last turn.
void compare_turn(State& state) {
  const auto& bare = state.of(Way::kBareLoop).last;
  for (const auto way : kWays) {
    const auto& last = state.of(way).last;
    state.wake_over_bare[static_cast<std::size_t>(way)].add(last.wake.p50, bare.wake.p50);
    state.send_over_bare[static_cast<std::size_t>(way)].add(last.send.p50, bare.send.p50);
  }
  const auto& cycle = state.of(Way::kCycle).last;
  state.wake_over_ahead.add(cycle.wake.p50, state.of(Way::kBareLoopAhead).last.wake.p50);
  state.send_over_wake.add(cycle.send.p99, bare.wake.p99);
  if (!state.with_cyclictest) return;
  state.p999_over_cyclictest.add(cycle.wake.p999, state.cyclictest.last.wake.p999);
  state.max_over_cyclictest.add(cycle.wake.max, state.cyclictest.last.wake.max);
}

/// The threads that ran on the processor from the instant to the wake-up, oldest first.
std::vector<RanInstead> who_ran(const LatestWakeUp& latest) {
  std::vector<RanInstead> threads;
  auto end = latest.wake;
  for (std::size_t i = 0; i < latest.count; ++i) {
    const auto& [time, thread] = latest.switches[i];
    const auto begin = std::max(time, latest.instant);
    if (begin < end) {
      const auto name = rt::thread_name(thread);
      threads.insert(threads.begin(), {name.empty() ? fmt::format("ended ({})", thread) : name,
                                       static_cast<double>((end - begin).count()) / 1000.0});
      end = begin;
    }
  }
  return threads;
}

Summary just(double value, std::size_t n) {
  return {n, value, value, value, value};
}

void add_row(Report& report, const std::string& name, const char* metric, const DelayHistogram& delays,
             const std::optional<Baseline>& floor = std::nullopt, std::vector<RanInstead> ran_instead = {}) {
  report.add({name, metric, "ns", delays.summary(), std::nullopt, floor, std::nullopt, delays, std::nullopt,
              std::move(ran_instead)});
}

void report_ways(Report& report, const std::string& name, const State& state, const Distances& distances) {
  const auto bare_name = name + "_bare_loop";
  const auto& bare = state.of(Way::kBareLoop);
  for (const auto way : kWays) {
    const auto number = static_cast<std::size_t>(way);
    const auto against = [&](const DelayHistogram& floor, const RatioTurns& ratios) {
      return way == Way::kBareLoop ? std::nullopt : std::optional(Baseline{bare_name, floor.summary(), ratios});
    };
    const auto case_name = fmt::format("{}_{}", name, name_of(way));
    add_row(report, case_name, "wake_latency", state.of(way).wake, against(bare.wake, state.wake_over_bare[number]),
            way == Way::kCycle ? state.ran_instead : std::vector<RanInstead>{});
    add_row(report, case_name, "send_time", state.of(way).send, against(bare.send, state.send_over_bare[number]));
    add_row(report, case_name, "arrival_period_off", distances.off(way), against(distances.off(Way::kBareLoop), {}));
    report.add({case_name, "missed_periods", "1",
                just(static_cast<double>(state.of(way).missed), state.of(way).wake.count())});
  }
}

/// Reports the aims, one row each.
void report_aims(Report& report, const std::string& name, const State& state) {
  const auto case_name = name + "_cycle";
  const auto& cycle = state.of(Way::kCycle);
  const auto n = static_cast<std::size_t>(cycle.wake.count());
  const auto aimed = [&](const char* metric, double value, double factor, double floor, const std::string& against,
                         const RatioTurns& ratios) {
    report.add({case_name, metric, "ns", just(value, n), factor * floor, Baseline{against, just(floor, n), ratios}});
  };
  const auto wake = cycle.wake.summary();
  aimed("wake_latency_p50", wake.p50, kWakeAim, state.of(Way::kBareLoopAhead).wake.summary().p50,
        name + "_bare_loop_ahead", state.wake_over_ahead);
  aimed("send_time_p99", cycle.send.summary().p99, kSendAim, state.of(Way::kBareLoop).wake.summary().p99,
        name + "_bare_loop_wake_latency", state.send_over_wake);
  if (state.with_cyclictest) {
    const auto against = name + "_cyclictest";
    const auto peer = state.cyclictest.wake.summary();
    aimed("wake_latency_p999", wake.p999, 1.0, peer.p999, against, state.p999_over_cyclictest);
    aimed("wake_latency_max", wake.max, 1.0, peer.max, against, state.max_over_cyclictest);
    const auto missed = just(static_cast<double>(state.cyclictest.missed), peer.n);
    report.add({case_name, "missed_periods_as_cyclictest", "1", just(static_cast<double>(cycle.missed), n), missed.p50,
                Baseline{against, missed}});
  }
  report.add({case_name, "page_faults", "1", just(static_cast<double>(state.use.page_faults), n), 0.0});
  // The cycle's own sleep is at most one switch per cycle.
  const auto sleeps = static_cast<double>(state.use.sleeps) / static_cast<double>(n);
  report.add({case_name, "voluntary_switches_per_cycle", "1", just(sleeps, n), 1.0});
}

void note_who_ran(Report& report, const std::string& name, const LatestWakeUp& latest,
                  const std::vector<RanInstead>& threads) {
  if (threads.empty()) return;
  std::string list;
  for (const auto& [thread, us] : threads)
    list += fmt::format("{}{} for {:.0f} us", list.empty() ? "" : ", ", thread, us);
  report.note(fmt::format("{}: the latest wake-up of the cycle was {:.0f} us late; its processor was given to {}.",
                          name, static_cast<double>((latest.wake - latest.instant).count()) / 1000.0, list));
}

/// Measures all methods in turns for `seconds` each; the machine is in state `name`.
void measure_state(Report& report, const VethPair& cable, const std::string& name, double seconds) {
  rt::MonotonicClock clock;
  auto port = port::RawSocketPort::open({.interface = cable.near}, clock);
  if (!port) throw std::runtime_error(port.error().message);
  const auto log = rt::SwitchLog::open(last_cpu());
  if (!log) fmt::print(stderr, "jitter: {}\n", log.error().message());
  Turns turns(**port, cable.near, log ? log->get() : nullptr);
  Receiver receiver(cable.far);
  const auto state = std::make_unique<State>();
  {
    rt::RealtimeThread thread;
    start_realtime(thread, turns);
    const Leaving leaving{thread, turns};
    const auto per_turn = std::chrono::duration<double>(kCyclesPerTurn * kPeriod).count();
    const auto count = std::max<std::uint32_t>(1, static_cast<std::uint32_t>(seconds / per_turn));
    for (std::uint32_t turn = 0; turn < count; ++turn) {
      turns.take(turn);
      for (const auto way : kWays) add_moments(state->of(way), turns.moments(way));
      state->use.page_faults += turns.use().page_faults;
      state->use.sleeps += turns.use().sleeps;
      state->with_cyclictest = state->with_cyclictest && add_cyclictest(state->cyclictest);
      compare_turn(*state);
    }
    state->ran_instead = who_ran(turns.latest());
    note_who_ran(report, name, turns.latest(), state->ran_instead);
  }
  if (!state->with_cyclictest)
    fmt::print(stderr, "jitter: no comparison with cyclictest: it is not installed (Debian: rt-tests)\n");
  const auto& distances = receiver.finish();
  for (const auto way : kWays) {
    if (distances.off(way).count() == 0) throw std::runtime_error("no frame came in at the other end of the cable");
  }
  report_ways(report, name, *state, distances);
  if (state->with_cyclictest) {
    add_row(report, name + "_cyclictest", "wake_latency", state->cyclictest.wake,
            Baseline{name + "_bare_loop", state->of(Way::kBareLoop).wake.summary()});
  }
  report_aims(report, name, *state);
}

/// Load by arithmetic on every processor, system calls, memory, network and disk. It runs with ordinary priority, below
/// real-time threads.
std::unique_ptr<ChildProgram> start_stress() {
  return ChildProgram::start({"stress-ng",   "--quiet",    "--cpu",       "0",      "--switch",  "1",     "--vm",
                              "1",           "--vm-bytes", "64M",         "--sock", "1",         "--hdd", "1",
                              "--hdd-bytes", "16M",        "--temp-path", "/tmp",   "--timeout", "0"});
}

void measure_under_load(Report& report, const VethPair& cable, double seconds) {
  // Start this first, while the machine has time for it.
  const auto neighbour = NeighbourLine::start();
  if (!neighbour) fmt::print(stderr, "jitter: no DDS and EoE traffic in the load: setpriv or ping is not installed\n");
  const auto stress = start_stress();
  if (!stress) {
    fmt::print(stderr, "jitter: nothing measured under load: stress-ng is not installed\n");
    return;
  }
  const auto must_go_on = [&] {
    if (stress->has_ended()) throw std::runtime_error("stress-ng has ended before the measurement under load");
    if (neighbour) neighbour->must_go_on();
  };
  std::this_thread::sleep_for(1s);
  must_go_on();
  measure_state(report, cable, "load", seconds);
  must_go_on();
  if (!neighbour) {
    report.note("load: without DDS and EoE traffic, for which setpriv and ping must be installed.");
    return;
  }
  const auto traffic = neighbour->finish();
  if (traffic.dds_cycles == 0 || traffic.eoe_packets == 0)
    throw std::runtime_error("there was no DDS or no EoE traffic under load");
  report.note(fmt::format(
      "load: stress-ng, and a line of eight drives, of whose telemetry {} cycles were read by DDS and which "
      "answered {} packets by EoE.",
      traffic.dds_cycles, traffic.eoe_packets));
}

void measure_all(const Options& options) {
  Report report("jitter");
  auto obstacle = enter_private_network();
  const auto cable = obstacle.empty() ? make_veth_pair("jitter") : std::nullopt;
  if (obstacle.empty() && !cable) obstacle = "no veth pair: the kernel lacks the driver or `ip` is not installed";
  const double seconds = options.duration(kSeconds, kSecondsInShort);
  if (obstacle.empty()) {
    measure_state(report, *cable, "idle", seconds);
    raise_loopback();
    measure_under_load(report, *cable, seconds);
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
