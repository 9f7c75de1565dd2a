// Measures the time from the first frame until all drives of a line are in OP.
#include <fmt/format.h>

#include <atomic>
#include <stdexcept>
#include <thread>

#include "driveline/ecat_master/master.hpp"
#include "driveline/port/raw_socket_port.hpp"
#include "driveline/runtime/setup/composition.hpp"
#include "driveline/slaves/line/simulated_line.hpp"
#include "support/environment.hpp"
#include "support/line_rig.hpp"
#include "support/real_time_limit.hpp"
#include "support/realtime.hpp"
#include "support/report.hpp"
#include "support/retry.hpp"
#include "support/stopwatch.hpp"
#include "support/veth_pair.hpp"

namespace {

using namespace driveline;
using namespace driveline::bench;
using std::chrono::nanoseconds;

constexpr nanoseconds kPeriod = std::chrono::milliseconds{1};
constexpr int kRuns = 10;
/// Time in OP over which the processor time of the drives is measured.
constexpr nanoseconds kLoadTime = std::chrono::milliseconds{50};
/// Retries for 2.7 s. Linux takes 50 ms of every second from a SCHED_FIFO thread if other threads wait for its
/// processor, and 256 drives leave little of the rest: such a start is slow, but no failure.
constexpr int kFrameRetries = 8;
constexpr double kVethAimMs = 1000.0;  // for 64 drives
constexpr std::size_t kAimDrives = 64;
constexpr double kMemoryAimMib = 64.0;  // for 256 slaves
constexpr std::size_t kMaxDrives = 256;

std::unique_ptr<slaves::SimulatedLine> make_line(rt::Clock& clock, std::size_t count) {
  return std::make_unique<slaves::SimulatedLine>(clock, runtime::make_simulated_slaves(describe_line(count, kPeriod)),
                                                 kNoDelays);
}

/// A start may fail because the machine was busy for longer than the time-out of a frame or mailbox. If every start
/// fails, the error of the last one is reported.
void require(const ecat_master::Result<void>& done) {
  if (!done) throw Disturbed(ecat_master::describe(done.error()));
}

/// Durations of the parts of a start in milliseconds, and memory of the master.
struct Start {
  double discovery = 0.0;
  double to_safe_op = 0.0;
  double to_op = 0.0;
  double memory_mib = 0.0;
  double discovery_frames = 0.0;
  double process_mib = 0.0;  ///< including the simulated line, if it is in the same process
  [[nodiscard]] double total() const noexcept { return discovery + to_safe_op + to_op; }
};

/// Starts the line, calls `in_operation(master)` while it is in OP, and shuts it down.
template <typename InOperation>
Start start_line(port::Port& port, rt::Clock& clock, std::size_t count, const InOperation& in_operation) {
  constexpr double kNsPerMs = 1e6;
  constexpr double kMib = 1024.0 * 1024.0;
  const auto config = describe_line(count, kPeriod);
  auto plans = runtime::make_slave_plans(config);
  Start start;
  const auto memory = static_cast<double>(resident_bytes());
  ecat_master::Master::Settings patience;
  patience.exchange.retries = kFrameRetries;
  ecat_master::Master master(port, clock, patience);
  double begin = now_ns();
  auto lap = [&begin] {
    const double end = now_ns();
    const double ms = (end - begin) / kNsPerMs;
    begin = end;
    return ms;
  };
  require(master.scan());
  start.discovery = lap();
  start.discovery_frames = static_cast<double>(master.exchange_statistics().frames_sent);
  require(master.configure(std::move(plans)));
  start.to_safe_op = lap();
  const auto make_runner = [&clock](ecat_master::CyclicCore& core) {
    return std::make_unique<motion::InlineRunner>(core, clock);
  };
  const auto started = master.start_cycle(nullptr, {}, runtime::cycle_settings(config, master), make_runner);
  if (!started) throw Disturbed(started.error().message());
  require(master.go_operational());
  start.to_op = lap();
  start.process_mib = static_cast<double>(resident_bytes()) / kMib;
  start.memory_mib = start.process_mib - memory / kMib;
  in_operation(master);
  require(master.shut_down());
  return start;
}

Start start_line(port::Port& port, rt::Clock& clock, std::size_t count) {
  return start_line(port, clock, count, [](ecat_master::Master&) {});
}

/// Processor time that master and drives in one process need per elapsed time, in OP.
double load_of(std::size_t drives) {
  rt::VirtualClock clock;
  const auto line = make_line(clock, drives);
  double ns = 0.0;
  start_line(*line, clock, drives, [&](ecat_master::Master& master) {
    const double begin = now_ns();
    master.pass(kLoadTime);
    ns = now_ns() - begin;
  });
  return ns / static_cast<double>(kLoadTime.count());
}

/// Serves the drives at the far end of a cable, in a thread of their own.
class Server {
 public:
  Server(slaves::SimulatedLine& line, port::Port& port, rt::Clock& clock)
      : thread_([&, this](const std::stop_token& stop) { serve(stop, line, port, clock); }) {
    // The drives' time runs from their creation, so they must have caught up before a master starts.
    const auto patience = clock.now() + std::chrono::seconds{5};
    while (!ready_.load(std::memory_order_acquire)) {
      if (clock.now() > patience) throw Disturbed("the simulated drives take longer than the time they simulate");
      clock.sleep_until(clock.now() + std::chrono::milliseconds{1});
    }
  }

 private:
  void serve(const std::stop_token& stop, slaves::SimulatedLine& line, port::Port& port, rt::Clock& clock) {
    std::array<std::byte, port::kMaxFrameBytes> buffer{};
    claim_cpu(last_cpu());
    while (!stop.stop_requested()) {
      const auto frame = port.receive();
      if (!frame) {
        const auto now = clock.now();
        line.advance(now);
        if (clock.now() - now < std::chrono::milliseconds{1}) ready_.store(true, std::memory_order_release);
        port.wait_readable(clock.now() + std::chrono::microseconds{125});
        continue;
      }
      const auto reply = std::span(buffer).first(frame->bytes.size());
      std::copy(frame->bytes.begin(), frame->bytes.end(), reply.begin());
      // An answer that cannot be sent is a lost frame, which the master handles.
      if (line.process(reply, frame->time)) static_cast<void>(port.send(reply));
    }
  }

  std::atomic<bool> ready_{false};
  std::jthread thread_;
};

std::unique_ptr<port::RawSocketPort> open(const std::string& interface, rt::Clock& clock) {
  auto port = port::RawSocketPort::open({.interface = interface}, clock);
  if (!port) throw std::runtime_error(port.error().message);
  return std::move(*port);
}

void add(Report& report, const char* where, std::size_t drives, const std::vector<Start>& starts,
         std::optional<double> aim) {
  const auto name = fmt::format("{}_{}_drives", where, drives);
  auto row = [&](const char* metric, double (*of)(const Start&), std::optional<double> row_aim) {
    std::vector<double> samples;
    for (const auto& start : starts) samples.push_back(of(start));
    report.add({name, metric, "ms", summarize(samples), row_aim, std::nullopt});
  };
  row(
      "first_frame_to_op", [](const Start& s) { return s.total(); }, aim);
  row(
      "discovery", [](const Start& s) { return s.discovery; }, std::nullopt);
  report.add(
      {name, "discovery_frames", "frames", summarize({starts.front().discovery_frames}), std::nullopt, std::nullopt});
  row(
      "configuration_to_safe_op", [](const Start& s) { return s.to_safe_op; }, std::nullopt);
  row(
      "to_op", [](const Start& s) { return s.to_op; }, std::nullopt);
}

Start start_in_process(rt::Clock& clock, std::size_t drives) {
  const auto line = make_line(clock, drives);
  return start_line(*line, clock, drives);
}

Start start_over(const VethPair& cable, rt::Clock& clock, std::size_t drives) {
  const auto line = make_line(clock, drives);
  const auto master_port = open(cable.near, clock);
  const auto drives_port = open(cable.far, clock);
  const Server server(*line, *drives_port, clock);
  return start_line(*master_port, clock, drives);
}

/// Repeats a start `runs` times until each of them is valid.
template <typename Make>
std::vector<Start> repeat(const std::string& what, int runs, const Make& make) {
  fmt::print(stderr, "startup: {} ...\n", what);
  std::vector<Start> starts;
  for (int i = 0; i < runs; ++i) starts.push_back(undisturbed(what, make));
  return starts;
}

void measure_all(const Options& options) {
  Report report("startup");
  const int runs = std::max(1, options.count(kRuns));
  rt::MonotonicClock clock;
  const auto problem = enter_private_network();
  const auto cable = problem.empty() ? make_veth_pair("dlstart") : std::nullopt;
  claim_cpu(std::max(0, last_cpu() - 1));
  for (const std::size_t drives : {std::size_t{1}, std::size_t{8}, kAimDrives, kMaxDrives}) {
    if (const auto note = beyond_real_time(fmt::format("{} drives", drives), load_of(drives))) {
      report.note(*note);
      continue;
    }
    const auto in_process =
        repeat(fmt::format("{} drives, in process", drives), runs, [&] { return start_in_process(clock, drives); });
    add(report, "in_process", drives, in_process, std::nullopt);
    if (drives == kMaxDrives) {
      report.add({fmt::format("in_process_{}_drives", drives), "memory_of_the_master", "MiB",
                  summarize({in_process.front().memory_mib}), kMemoryAimMib, std::nullopt});
      report.add({fmt::format("in_process_{}_drives", drives), "memory_of_the_process", "MiB",
                  summarize({in_process.front().process_mib}), kMemoryAimMib, std::nullopt});
    }
    if (!cable) continue;
    const auto over_veth =
        repeat(fmt::format("{} drives, over veth", drives), runs, [&] { return start_over(*cable, clock, drives); });
    add(report, "veth", drives, over_veth, drives == kAimDrives ? std::optional(kVethAimMs) : std::nullopt);
  }
  report.note(
      fmt::format("MSD drives with all their start-up SDOs and PDO mapping, EEPROM and AL delays zero; cycle {} ms;\n"
                  "the caller runs the cycle. veth: the drives in a second thread on a processor of its own.",
                  kPeriod / std::chrono::milliseconds{1}));
  report.print(options);
  if (!cable) throw Skipped("veth: no pair can be made here" + (problem.empty() ? std::string() : ": " + problem));
}

}  // namespace

int main(int argc, char** argv) {
  return run(argc, argv, "How long do 1, 8, 64 and 256 drives take from the first frame to OP?", measure_all);
}
