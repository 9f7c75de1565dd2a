// How long does a frame that a master sends to `driveline simulate` take to come back, against a program that does
// nothing but echo it? Both behind the same virtual cable, in turns.
#include <arpa/inet.h>
#include <fmt/format.h>
#include <linux/if_packet.h>
#include <net/if.h>
#include <poll.h>
#include <sched.h>
#include <sys/socket.h>
#include <algorithm>
#include <memory>
#include <stdexcept>
#include <thread>
#include <vector>

#include "driveline/ecat_master/master.hpp"
#include "driveline/port/frame_waiter.hpp"
#include "driveline/port/raw_socket_port.hpp"
#include "driveline/wire/frame.hpp"
#include "line/composition.hpp"
#include "line/line_server.hpp"
#include "support/realtime.hpp"
#include "support/report.hpp"
#include "support/stopwatch.hpp"
#include "support/veth_pair.hpp"

namespace {

using namespace driveline;
using namespace driveline::bench;
using namespace std::chrono_literals;
using std::chrono::nanoseconds;

constexpr int kFrames = 10'000;
/// So few in a row that a disturbance of the machine meets both servers alike.
constexpr int kFramesPerRound = 50;
constexpr nanoseconds kPeriod = 250us;
/// Of a round, until caches and the other processor are warm.
constexpr int kWarmUp = 20;
constexpr double kAim = 1.2;
constexpr int kTries = 50;
/// Index of the first datagram: Ethernet and EtherCAT header, command.
constexpr std::size_t kIndex = 17;

/// The floor: a bare AF_PACKET echo. It sets the bit that shows a frame has been round, as the first slave does.
class Echo final : public rt::RealtimeTask {
 public:
  Echo(const std::string& interface, bool busy)
      : socket_(::socket(AF_PACKET, SOCK_RAW | (busy ? SOCK_NONBLOCK : 0) | SOCK_CLOEXEC,
                         htons(wire::kEtherTypeEtherCat))) {
    if (!socket_.valid()) throw std::runtime_error("echo: no packet socket");
    const int on = 1;
    setsockopt(socket_.get(), SOL_PACKET, PACKET_QDISC_BYPASS, &on, sizeof on);
    setsockopt(socket_.get(), SOL_PACKET, PACKET_IGNORE_OUTGOING, &on, sizeof on);
    // So that it notices its end.
    const timeval patience{0, 50'000};
    setsockopt(socket_.get(), SOL_SOCKET, SO_RCVTIMEO, &patience, sizeof patience);
    sockaddr_ll address{};
    address.sll_family = AF_PACKET;
    address.sll_protocol = htons(wire::kEtherTypeEtherCat);
    address.sll_ifindex = static_cast<int>(if_nametoindex(interface.c_str()));
    if (bind(socket_.get(), reinterpret_cast<const sockaddr*>(&address), sizeof address) != 0) {
      throw std::runtime_error("echo: cannot bind to " + interface);
    }
  }
  void run(std::stop_token stop) noexcept override {
    std::array<std::byte, port::kMaxFrameBytes> frame;
    while (!stop.stop_requested()) {
      const auto size = recv(socket_.get(), frame.data(), frame.size(), 0);
      if (size < static_cast<ssize_t>(wire::EthernetHeader::kSize)) continue;
      frame[6] |= std::byte{0x02};
      keep(send(socket_.get(), frame.data(), static_cast<std::size_t>(size), 0));
    }
  }

 private:
  port::FileDescriptor socket_;
};

cli::LineConfig drives(std::size_t count) {
  cli::LineConfig config;
  for (std::size_t i = 0; i < count; ++i) {
    const auto name = fmt::format("d{}", i);
    config.slaves.emplace_back().name = name;
    ecat_master::AxisConfig axis;
    axis.name = name;
    axis.slave = i;
    config.axes.push_back(axis);
  }
  return config;
}

std::unique_ptr<port::RawSocketPort> open(const std::string& interface, const rt::Clock& clock) {
  auto port = port::RawSocketPort::open({.interface = interface}, clock);
  if (!port) throw std::runtime_error(port.error().message);
  return std::move(*port);
}

/// A line of drives in SAFEOP with mapped process data: their control loops run, inputs are published.
class Drives {
 public:
  Drives(rt::Clock& clock, const std::string& interface, std::size_t count, bool busy)
      : config_(drives(count)),
        line_(cli::make_simulated_line(config_, clock)),
        port_(open(interface, clock)),
        waiter_(port::FrameWaiter::open(*port_, nullptr).value()),
        server_(*line_, *port_, nullptr, clock, {busy, [this](nanoseconds deadline) { waiter_->wait(deadline); }}) {}
  void configure(port::Port& master_port, rt::Clock& clock) {
    rt::RealtimeThread thread;
    start_realtime(thread, server_);
    ecat_master::Master master(master_port, clock);
    // A machine that does other things as well may leave the line without its processor for longer than a frame is
    // waited for.
    auto done = master.scan();
    for (int tries = 0; tries < kTries; ++tries) {
      if (done) done = master.configure(cli::make_slave_plans(config_));
      if (done) return;
      done = master.scan();
    }
    throw std::runtime_error(ecat_master::describe(done.error()));
  }
  cli::LineServer& server() { return server_; }

 private:
  cli::LineConfig config_;
  std::unique_ptr<slaves::Line> line_;
  std::unique_ptr<port::RawSocketPort> port_;
  std::unique_ptr<port::FrameWaiter> waiter_;
  cli::LineServer server_;
};

using Frame = std::vector<std::byte>;

/// The cyclic frame of the drives: LRW over all their process data.
Frame process_data_frame(port::RawSocketPort& port, std::size_t drives) {
  constexpr std::size_t kPerDrive = 32;
  Frame buffer(wire::EthernetHeader::kSize + wire::kMaxPayloadBytes);
  wire::FrameBuilder builder(buffer, port.mac());
  const auto length = std::min<std::size_t>(kPerDrive * drives, wire::kMaxDatagramData);
  builder.add(wire::Command::kLrw, 0, wire::DatagramAddress::logical(0), length);
  const auto frame = builder.finish();
  return {frame.begin(), frame.end()};
}

/// Sends frames every kPeriod and spins until each has come back; ns from send to receive.
void measure(port::RawSocketPort& port, rt::Clock& clock, Frame frame, int frames,
             std::vector<double>& round_trips_ns) {
  auto next = clock.now() + kPeriod;
  for (int i = -kWarmUp; i < frames; ++i) {
    while (clock.now() < next) {
    }
    // A master that was interrupted does not send in a hurry to catch up.
    next = clock.now() + kPeriod;
    frame[kIndex] = static_cast<std::byte>(i);
    if (port.send(frame) != port::SendStatus::kSent) throw std::runtime_error("a frame could not be sent");
    const auto deadline = clock.now() + 1s;
    // Older ones may still be on their way.
    auto reply = port.receive();
    while (!(reply && reply->bytes[kIndex] == frame[kIndex]) && clock.now() < deadline) reply = port.receive();
    if (!reply) throw std::runtime_error("a frame did not come back");
    if (i >= 0) round_trips_ns.push_back(static_cast<double>((reply->time - port.last_send_time()).count()));
  }
}

void measure_with(rt::RealtimeTask& task, port::RawSocketPort& port, rt::Clock& clock, const Frame& frame, int frames,
                  std::vector<double>& round_trips_ns) {
  rt::RealtimeThread thread;
  start_realtime(thread, task);
  measure(port, clock, frame, frames, round_trips_ns);
  thread.request_stop();
  thread.join();
}

/// Each server at a cable of its own.
struct Cables {
  VethPair echo;
  VethPair line;
};

void compare(Report& report, const Cables& cables, std::size_t drives, bool busy, const Options& options) {
  rt::MonotonicClock clock;
  const auto echo_port = open(cables.echo.near, clock);
  const auto line_port = open(cables.line.near, clock);
  Echo echo(cables.echo.far, busy);
  Drives line(clock, cables.line.far, drives, busy);
  line.configure(*line_port, clock);
  const auto frame = process_data_frame(*line_port, drives);
  std::vector<double> echo_ns;
  std::vector<double> line_ns;
  for (int done = 0; done < options.count(kFrames); done += kFramesPerRound) {
    measure_with(echo, *echo_port, clock, frame, kFramesPerRound, echo_ns);
    measure_with(line.server(), *line_port, clock, frame, kFramesPerRound, line_ns);
  }
  const Baseline floor{busy ? "bare_echo_spinning" : "bare_echo", summarize(std::move(echo_ns))};
  const auto name = fmt::format("{}_drives{}", drives, busy ? "_busy_poll" : "");
  report.add({fmt::format("{}_{}_bytes", floor.name, frame.size()), "round_trip", "ns", floor.figures});
  report.add({name, "round_trip", "ns", summarize(std::move(line_ns)), kAim * floor.figures.p50, floor});
}

/// The master on a processor of its own, as a real one is: on that of the server it would be preempted by the answer,
/// and starved by a server that spins.
void leave_the_last_cpu() {
  const auto cpus = std::thread::hardware_concurrency();
  cpu_set_t set;
  CPU_ZERO(&set);
  CPU_SET(cpus > 1 ? cpus - 2 : 0, &set);
  if (sched_setaffinity(0, sizeof set, &set) != 0) fmt::print(stderr, "the master's processor cannot be chosen\n");
}

void measure_all(const Options& options) {
  Report report("turnaround");
  leave_the_last_cpu();
  auto obstacle = enter_private_network();
  const auto echo = obstacle.empty() ? make_veth_pair("echo") : std::nullopt;
  const auto line = obstacle.empty() ? make_veth_pair("line") : std::nullopt;
  if (obstacle.empty() && !(echo && line))
    obstacle = "no veth pair: the kernel lacks the driver or `ip` is not installed";
  if (obstacle.empty()) {
    for (const bool busy : {false, true}) {
      for (const std::size_t drives : {1U, 8U, 32U}) compare(report, {*echo, *line}, drives, busy, options);
    }
  } else {
    fmt::print(stderr, "turnaround: skipped: {}\n", obstacle);
    report.note("skipped: " + obstacle);
  }
  report.print(options);
}

}  // namespace

int main(int argc, char** argv) {
  return run(argc, argv, "How long does a frame to a simulated line take, against a bare echo?", measure_all);
}
