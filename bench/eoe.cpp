// Measures the throughput of TCP/IP to the drives over EoE, and its cost for the cycle.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <numeric>

#include "driveline/ecat_master/cyclic/acyclic_channel.hpp"
#include "driveline/port/port.hpp"
#include "driveline/port/raw_socket_port.hpp"
#include "driveline/rt/clock.hpp"
#include "driveline/runtime/endpoints/drive_networks.hpp"
#include "driveline/runtime/served/line_server.hpp"
#include "driveline/runtime/setup/composition.hpp"
#include "driveline/slaves/msd/device_layout.hpp"
#include "driveline/wire/datagram.hpp"
#include "driveline/wire/eoe_frames.hpp"
#include "driveline/wire/frame.hpp"
#include "driveline/wire/mailbox.hpp"
#include "driveline/wire/wire_time.hpp"
#include "support/eoe_line.hpp"
#include "support/realtime.hpp"
#include "support/report.hpp"
#include "support/retry.hpp"
#include "support/tcp.hpp"
#include "support/veth_pair.hpp"

namespace {

using namespace driveline;
using namespace driveline::bench;
using namespace std::chrono_literals;
using std::chrono::nanoseconds;

constexpr double kInProcessAim = 0.8;  ///< share of the arithmetic limit, for a drive
constexpr double kVethAim = 0.5;
constexpr double kCostAim = 1.05;                            ///< p99.9 of the cycle cost with load over the one without
constexpr std::size_t kMailbox = slaves::msd::kMailboxSize;  ///< in either direction
constexpr int kPairs = 20;

/// Serves the drives at the far end of a cable.
class ServedDrives {
 public:
  ServedDrives(const EoeLine::Settings& settings, const std::string& interface)
      : line_(runtime::make_simulated_line(EoeLine::describe(settings), clock_)) {
    auto networks = runtime::DriveNetworks::start(*line_);
    if (!networks) throw std::runtime_error(runtime::describe(networks.error()));
    networks_ = std::move(*networks);
    port::RawSocketConfig config;
    config.interface = interface;
    auto opened = port::RawSocketPort::open(config, clock_);
    if (!opened) throw std::runtime_error(opened.error().message);
    port_ = std::move(*opened);
    server_ = std::make_unique<runtime::LineServer>(*line_, *port_, clock_);
    rt::RealtimeConfig realtime;
    realtime.policy = rt::RealtimePolicy::kDegrade;
    realtime.cpu = std::max(0, last_cpu() - 1);
    if (!thread_.start(realtime, *server_)) throw std::runtime_error("the line's thread cannot be started");
  }
  ServedDrives(const ServedDrives&) = delete;
  ServedDrives& operator=(const ServedDrives&) = delete;
  ~ServedDrives() {
    thread_.request_stop();
    thread_.join();
  }

 private:
  rt::MonotonicClock clock_;
  std::unique_ptr<slaves::SimulatedLine> line_;
  std::unique_ptr<runtime::DriveNetworks> networks_;
  std::unique_ptr<port::RawSocketPort> port_;
  std::unique_ptr<runtime::LineServer> server_;
  rt::RealtimeThread thread_;
};

/// Number of whole mailboxes that the acyclic frames of a cycle carry: a datagram each, which is not split across
/// frames.
double mailboxes_per_cycle(std::size_t acyclic_bytes) {
  using ecat_master::AcyclicChannel;
  constexpr std::size_t kDatagram = kMailbox + wire::DatagramHeader::kOverhead;
  const auto in_frame = (std::min(acyclic_bytes, port::kMaxFrameBytes) - wire::kDatagramsOffset) / kDatagram;
  // A frame that is too long for one cycle is sent once enough cycles have saved up time for it.
  if (in_frame == 0) return static_cast<double>(acyclic_bytes) / (wire::kDatagramsOffset + kDatagram);
  const auto frame = wire::kDatagramsOffset + in_frame * kDatagram + wire::kPreambleFcsGap;
  const auto frames = std::min(AcyclicChannel::kMaxFrames, (acyclic_bytes + wire::kPreambleFcsGap) / frame);
  return static_cast<double>(frames * in_frame);
}

/// Lower limit of the echo time, in ms per MiB of all drives together: a segment of 1448 bytes is a frame of 1514,
/// which is split into fragments of as many blocks of 32 bytes as fit into the mailbox. Each mailbox of a drive carries
/// a fragment per cycle, and both directions of all drives share the acyclic capacity of the cycle.
double limit_ms_per_mib(const EoeLine::Settings& settings, std::size_t acyclic_bytes) {
  constexpr double kSegment = 1448.0;
  constexpr double kFrame = 1514.0;
  constexpr auto kPiece = wire::EoeFragmenter::fragment_size(kMailbox - wire::MailboxHeader::kSize);
  const double fragments = std::ceil(kFrame / static_cast<double>(kPiece));
  const double cycles_of_mailbox = fragments / static_cast<double>(settings.drives);
  const double cycles_of_wire = 2.0 * fragments / mailboxes_per_cycle(acyclic_bytes);
  const double period_ms = std::chrono::duration<double, std::milli>(settings.period).count();
  return std::max(cycles_of_mailbox, cycles_of_wire) * period_ms * 1048576.0 / kSegment;
}

std::string case_of(const EoeLine::Settings& settings) {
  return fmt::format("{}_{}us_{}_drive{}", settings.interface.empty() ? "in_process" : "veth", settings.period / 1us,
                     settings.drives, settings.drives == 1 ? "" : "s");
}

/// Returns the time for a MiB, in ms. `one_drive`: this time with a single drive, the aim for several drives; none:
/// there is a single drive.
double measure_speed(Report& report, const EoeLine::Settings& settings, std::optional<double> one_drive,
                     const Options& options) {
  EoeLine line(settings);
  std::vector<std::string> addresses;
  for (std::size_t i = 0; i < settings.drives; ++i) addresses.push_back(EoeLine::address(i));
  const auto round_trips = ping(addresses.front(), std::max(20, options.count(500)));
  const auto load = echo_load(addresses, options.quick     ? nanoseconds{1500ms}
                                         : options.shorter ? nanoseconds{3s}
                                                           : nanoseconds{10s});
  line.check();
  const Baseline limit{"arithmetic_limit", {1, limit_ms_per_mib(settings, line.acyclic_bytes()), 0, 0, 0}};
  const double aim = settings.interface.empty() ? kInProcessAim : kVethAim;
  const auto figures = summarize(load);
  report.add(
      {case_of(settings), "tcp_echo_per_mib", "ms", figures, one_drive.value_or(limit.figures.p50 / aim), limit});
  report.add({case_of(settings), "ping", "us", summarize(round_trips)});
  return figures.p50;
}

double p999(std::vector<double> samples) {
  return summarize(std::move(samples)).p999;
}

/// Periods that wake-ups with these latencies have skipped.
double missed_periods(const std::vector<double>& wake_ups_ns, nanoseconds period) {
  double missed = 0.0;
  for (const double late_ns : wake_ups_ns) missed += std::floor(late_ns / static_cast<double>(period.count()));
  return missed;
}

/// Alternates windows with and without load in a single run.
void measure_cost(Report& report, const EoeLine::Settings& settings, const Options& options) {
  EoeLine line(settings);
  std::vector<std::string> addresses;
  for (std::size_t i = 0; i < settings.drives; ++i) addresses.push_back(EoeLine::address(i));
  const nanoseconds window = options.quick ? 250ms : options.shorter ? 1s : 2s;
  std::vector<double> cost_ratios;
  std::vector<double> wake_ratios;
  std::vector<double> missed_quiet;
  std::vector<double> missed_loaded;
  for (int i = 0; i < (options.quick || options.shorter ? kPairs / 2 : kPairs); ++i) {
    static_cast<void>(line.take_costs());
    static_cast<void>(line.take_wake_ups());
    std::this_thread::sleep_for(window);
    const double quiet_cost = p999(line.take_costs());
    const auto quiet_wakes = line.take_wake_ups();
    missed_quiet.push_back(missed_periods(quiet_wakes, settings.period));
    static_cast<void>(echo_load(addresses, window));
    cost_ratios.push_back(p999(line.take_costs()) / quiet_cost);
    const auto loaded_wakes = line.take_wake_ups();
    missed_loaded.push_back(missed_periods(loaded_wakes, settings.period));
    wake_ratios.push_back(p999(loaded_wakes) / p999(quiet_wakes));
  }
  line.check();
  const auto name = case_of(settings);
  constexpr double kPercent = 0.01;
  const auto add_upper = [&](const char* metric, const std::vector<double>& ratios, std::optional<double> aim) {
    const double upper = upper_95(ratios) / kPercent;
    report.add({name, metric, "%", {ratios.size(), upper, upper, upper, upper}, aim});
  };
  report.add({name, "cycle_cost_p999_with_over_without", "%", divided(summarize(cost_ratios), kPercent)});
  add_upper("cycle_cost_p999_upper_end_of_95_interval", cost_ratios, kCostAim / kPercent);
  report.add({name, "wake_latency_p999_with_over_without", "%", divided(summarize(wake_ratios), kPercent)});
  add_upper("wake_latency_p999_upper_end_of_95_interval", wake_ratios, std::nullopt);
  report.add({name, "missed_periods_with", "1", summarize(missed_loaded)});
  report.add({name, "missed_periods_without", "1", summarize(missed_quiet)});
  const double more = mean_difference_95(missed_loaded, missed_quiet).low;
  report.add(
      {name, "missed_periods_more_lower_end_of_95_interval", "1", {cost_ratios.size(), more, more, more, more}, 0.0});
}

/// The build puts the drives' end point one folder above the benchmarks; an installation, beside them.
void find_end_point() {
  std::error_code error;
  const auto folder = std::filesystem::read_symlink("/proc/self/exe", error).parent_path();
  const auto built = folder.parent_path() / "driveline-endpoint";
  if (std::filesystem::exists(built, error)) ::setenv("DRIVELINE_ENDPOINT", built.c_str(), 0);
}

void measure_all(const Options& options) {
  find_end_point();
  if (const auto why = enter_private_network(); !why.empty()) throw Skipped(why);
  Report report("eoe");
  const auto pair = make_veth_pair("dl-eoe");
  for (const nanoseconds period : {nanoseconds{125us}, nanoseconds{1ms}}) {
    std::optional<double> one_near;
    std::optional<double> one_far;
    for (const std::size_t drives : {1U, 8U}) {
      const EoeLine::Settings near{drives, period, {}};
      undisturbed(case_of(near), [&] { one_near = measure_speed(report, near, one_near, options); });
      if (!pair) continue;
      const EoeLine::Settings far{drives, period, pair->near};
      undisturbed(case_of(far), [&] {
        const ServedDrives served(far, pair->far);
        one_far = measure_speed(report, far, one_far, options);
      });
    }
  }
  const EoeLine::Settings near{1, 125us, {}};
  undisturbed("cost in process", [&] { measure_cost(report, near, options); });
  if (pair) {
    const EoeLine::Settings far{1, 125us, pair->near};
    undisturbed("cost over a cable", [&] {
      const ServedDrives served(far, pair->far);
      measure_cost(report, far, options);
    });
  }
  report.note(
      "tcp_echo_per_mib: a TCP echo of every drive at once, both ways at the same time, all drives together; against\n"
      "what fragments of 480 bytes, one a cycle in either mailbox, and the bytes that the cycle leaves would allow.\n"
      "In process the cost of a cycle includes the simulated drives and their mailbox traffic.");
  report.print(options);
  if (!pair) throw Skipped("no virtual cable for the figures over a network interface");
}

}  // namespace

int main(int argc, char** argv) {
  return run(argc, argv, "What does TCP/IP to the drives reach over EoE, and what does it cost the cycle?",
             measure_all);
}
