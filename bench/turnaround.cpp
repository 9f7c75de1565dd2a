// How long does a frame of a master take to `driveline simulate` and back, compared with programs that only echo it?
// Each has a virtual cable of its own, in turns, on both kinds of socket: one with a system call per received frame
// (recv) and one with a receive ring (PACKET_MMAP).
#include <fmt/format.h>
#include <poll.h>
#include <sys/socket.h>
#include <algorithm>
#include <array>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <stdexcept>
#include <thread>
#include <vector>

#include "driveline/ecat_master/master.hpp"
#include "driveline/port/frame_waiter.hpp"
#include "driveline/port/raw_socket_port.hpp"
#include "driveline/runtime/served/line_server.hpp"
#include "driveline/runtime/setup/composition.hpp"
#include "driveline/wire/frame.hpp"
#include "support/cyclic_frame.hpp"
#include "support/packet_socket.hpp"
#include "support/realtime.hpp"
#include "support/report.hpp"
#include "support/retry.hpp"
#include "support/stopwatch.hpp"
#include "support/veth_pair.hpp"

namespace {

using namespace driveline;
using namespace driveline::bench;
using namespace std::chrono_literals;
using std::chrono::nanoseconds;

constexpr int kFrames = 10'000;
/// So short that a disturbance of the machine affects all servers alike.
constexpr int kFramesPerRound = 50;
constexpr nanoseconds kPeriod = 250us;
/// Frames at the start of a round that do not count: until caches and the other processor are warm.
constexpr int kWarmUp = 20;
constexpr nanoseconds kLost = 1s;
/// Aim: median of the line over that of the echo on the same kind of socket.
constexpr double kAim = 1.2;
constexpr int kTries = 50;
/// Retries for 2.7 s, while the line is brought up.
constexpr int kFrameRetries = 8;
/// 6.5 s, in increments of 100 us (register 0x0420).
constexpr std::uint16_t kWatchdog = 0xFFFF;
/// Offset of the index of the first datagram, after the Ethernet and EtherCAT headers and the command.
constexpr std::size_t kIndex = 17;
/// Offset of the source address; the first slave sets a bit in its first octet (ETG.1000.4 5.3.2).
constexpr std::size_t kSource = 6;
constexpr std::byte kBeenRound{0x02};

enum class Socket { kRecv, kRing };

const char* name_of(Socket socket) {
  return socket == Socket::kRing ? "packet_mmap" : "recv";
}

/// The baseline: receives a frame, sets the bit that marks processed frames, sends it.
class Echo final : public rt::RealtimeTask {
 public:
  Echo(const std::string& interface, Socket kind, bool busy)
      : busy_(busy),
        socket_(busy || kind == Socket::kRing ? PacketSocket::Look::kReturnsAtOnce : PacketSocket::Look::kSleeps),
        ring_(kind == Socket::kRing ? port::ReceiveRing::map(socket_.get()) : std::nullopt) {
    if (ring_.has_value() != (kind == Socket::kRing))
      throw std::runtime_error("echo: the kernel gives no receive ring");
    socket_.bind_to(interface);
  }
  void run(std::stop_token stop) noexcept override {
    while (!stop.stop_requested()) {
      const auto size = ring_ ? take() : recv(socket_.get(), frame_.data(), frame_.size(), 0);
      if (size < static_cast<ssize_t>(wire::EthernetHeader::kSize)) continue;
      frame_[kSource] |= kBeenRound;
      keep(send(socket_.get(), frame_.data(), static_cast<std::size_t>(size), 0));
    }
  }

 private:
  /// recv() for the ring: copies the frame into the program's memory; sleeps for 50 ms at most.
  ssize_t take() noexcept {
    auto frame = ring_->take();
    if (!frame && !busy_) {
      pollfd request{socket_.get(), POLLIN, 0};
      poll(&request, 1, 50);
      frame = ring_->take();
    }
    if (!frame) return -1;
    const auto size = std::min(frame->bytes.size(), frame_.size());
    std::copy_n(frame->bytes.begin(), size, frame_.begin());
    ring_->release();
    return static_cast<ssize_t>(size);
  }

  bool busy_;
  PacketSocket socket_;
  std::optional<port::ReceiveRing> ring_;
  std::array<std::byte, port::kMaxFrameBytes> frame_;
};

runtime::LineConfig drives(std::size_t count) {
  runtime::LineConfig config;
  for (std::size_t i = 0; i < count; ++i) {
    const auto name = fmt::format("d{}", i);
    config.slaves.emplace_back().name = name;
    motion::AxisConfig axis;
    axis.name = name;
    axis.slave = i;
    config.axes.push_back(axis);
  }
  return config;
}

std::unique_ptr<port::RawSocketPort> open(const std::string& interface, const rt::Clock& clock, Socket kind) {
  auto port = port::RawSocketPort::open({.interface = interface, .receive_ring = kind == Socket::kRing}, clock);
  if (!port) throw std::runtime_error(port.error().message);
  if ((*port)->has_receive_ring() != (kind == Socket::kRing)) {
    throw std::runtime_error(interface + ": the kernel gives no receive ring");
  }
  return std::move(*port);
}

/// A line of drives in OP, not enabled: their control loops run, outputs are taken and inputs published.
class Drives {
 public:
  Drives(rt::Clock& clock, const std::string& interface, Socket kind, std::size_t count, bool busy)
      : config_(drives(count)),
        line_(runtime::make_simulated_line(config_, clock)),
        port_(open(interface, clock, kind)),
        waiter_(port::FrameWaiter::open(*port_, nullptr).value()),
        server_(*line_, *port_, nullptr, clock, {busy, [this](nanoseconds deadline) { waiter_->wait(deadline); }}) {}

  /// Brings the line to OP; returns the frame that a master of this line sends in every cycle. Throws.
  CyclicFrame bring_up(port::Port& master_port, rt::Clock& clock) {
    rt::RealtimeThread thread;
    start_realtime(thread, server_);
    ecat_master::Master::Settings patience;
    patience.exchange.retries = kFrameRetries;
    ecat_master::Master master(master_port, clock, patience);
    // On a busy machine the line may have no processor for longer than the frame time-out.
    auto done = to_op(master, clock);
    for (int tries = 1; !done && tries < kTries; ++tries) done = to_op(master, clock);
    if (!done) throw std::runtime_error(ecat_master::describe(done.error()));
    const auto frames = cyclic_frames(master.image());
    if (frames.size() != 1) throw std::runtime_error("the process data do not fit into one frame");
    return frames.front();
  }
  runtime::LineServer& server() { return server_; }

 private:
  ecat_master::Result<void> to_op(ecat_master::Master& master, rt::Clock& clock) {
    if (auto done = master.scan(); !done) return done;
    auto plans = runtime::make_slave_plans(config_);
    // Between rounds the line gets no frames, possibly for long on a busy machine, but the drives require a watchdog.
    for (auto& plan : plans) plan.watchdog.process_data = kWatchdog;
    if (auto done = master.configure(std::move(plans)); !done) return done;
    ecat_master::CyclicCore::Settings settings;
    settings.period = 1ms;
    settings.receive_window = 750us;
    const auto started = master.start_cycle(nullptr, {}, settings, [&clock](ecat_master::CyclicCore& core) {
      return std::make_unique<motion::InlineRunner>(core, clock);
    });
    if (!started) throw std::runtime_error(started.error().message());
    auto done = master.go_operational();
    if (!done) static_cast<void>(master.shut_down());
    return done;
  }

  runtime::LineConfig config_;
  std::unique_ptr<slaves::SimulatedLine> line_;
  std::unique_ptr<port::RawSocketPort> port_;
  std::unique_ptr<port::FrameWaiter> waiter_;
  runtime::LineServer server_;
};

/// Checks a frame that has returned; throws if it is not the expected answer.
using Judge = std::function<void(const CyclicFrame& sent, std::span<const std::byte> answer)>;

void must_be_echoed(const CyclicFrame& sent, std::span<const std::byte> answer) {
  auto expected = sent.bytes;
  expected[kSource] |= kBeenRound;
  if (!std::equal(answer.begin(), answer.end(), expected.begin(), expected.end())) {
    throw std::runtime_error("the echo changed the frame");
  }
}

/// Checks the AL status of all drives and the working counters of all datagrams.
void must_be_from_op(const CyclicFrame& sent, std::span<const std::byte> answer) {
  if (answer.size() != sent.bytes.size()) throw std::runtime_error("the line changed the length of the frame");
  if (const auto* missing = sent.missing_in(answer)) {
    throw std::runtime_error(
        fmt::format("not all drives took part in OP: byte {} of the frame is 0x{:02X}, not 0x{:02X}", missing->offset,
                    static_cast<unsigned>(answer[missing->offset]), static_cast<unsigned>(missing->value)));
  }
}

/// A server, the near end of its cable, and its measurements.
struct Contestant {
  std::string name;
  rt::RealtimeTask& server;
  port::RawSocketPort& port;
  Judge judge;
  TurnSamples round_trips_ns{};
};

/// Sends a frame every kPeriod and spins until it has returned; ns from send to receive. No other frame may come in.
void measure(Contestant& contestant, rt::Clock& clock, CyclicFrame frame, int frames) {
  auto& port = contestant.port;
  // Discard remains of the bring-up or of a disturbed measurement.
  while (port.receive()) {
  }
  auto next = clock.now() + kPeriod;
  std::vector<double> round_trips_ns;
  for (int i = -kWarmUp; i < frames; ++i) {
    while (clock.now() < next) {
    }
    // An interrupted master does not send faster to catch up.
    next = clock.now() + kPeriod;
    frame.bytes[kIndex] = static_cast<std::byte>(i);
    if (port.send(frame.bytes) != port::SendStatus::kSent) throw std::runtime_error("a frame could not be sent");
    const auto deadline = clock.now() + kLost;
    auto reply = port.receive();
    while (!reply && clock.now() < deadline) reply = port.receive();
    if (!reply) throw Disturbed(contestant.name + ": a frame did not come back within a second");
    const auto round_trip = reply->time - port.last_send_time();
    if (reply->bytes.size() <= kIndex || reply->bytes[kIndex] != frame.bytes[kIndex]) {
      throw Disturbed(contestant.name + ": a frame came in that was not the one sent last");
    }
    contestant.judge(frame, reply->bytes);
    if (i >= 0) round_trips_ns.push_back(static_cast<double>(round_trip.count()));
  }
  contestant.round_trips_ns.add_turn(round_trips_ns);
}

void take_turn(Contestant& contestant, rt::Clock& clock, const CyclicFrame& frame, int frames) {
  rt::RealtimeThread thread;
  start_realtime(thread, contestant.server);
  measure(contestant, clock, frame, frames);
  thread.request_stop();
  thread.join();
}

/// A cable for each server.
struct Cables {
  VethPair echo;
  VethPair line;
};

/// Echo and line on one kind of socket.
struct Figures {
  Summary echo;
  Summary line;
  RatioTurns ratios;  ///< ratios of the medians, per turn
};

Figures compare(const Cables& cables, Socket kind, std::size_t count, bool busy, const Options& options) {
  rt::MonotonicClock clock;
  const auto echo_port = open(cables.echo.near, clock, Socket::kRing);
  const auto line_port = open(cables.line.near, clock, Socket::kRing);
  Echo echo(cables.echo.far, kind, busy);
  Drives line(clock, cables.line.far, kind, count, busy);
  const auto frame = line.bring_up(*line_port, clock);
  Contestant echo_side{"echo", echo, *echo_port, must_be_echoed};
  Contestant line_side{"line", line.server(), *line_port, must_be_from_op};
  Rests rests;
  for (int done = 0; done < options.count(kFrames); done += kFramesPerRound) {
    rests.take_when_due(now_ns());
    for (auto* contestant : {&echo_side, &line_side}) take_turn(*contestant, clock, frame, kFramesPerRound);
  }
  return {summarize(echo_side.round_trips_ns.all()), summarize(line_side.round_trips_ns.all()),
          ratios_by_turn(line_side.round_trips_ns.medians(), echo_side.round_trips_ns.medians())};
}

void measure_case(Report& report, const Cables& cables, std::size_t count, bool busy, const Options& options) {
  for (const auto kind : {Socket::kRecv, Socket::kRing}) {
    const auto name = fmt::format("{}_drives{}_{}", count, busy ? "_busy_poll" : "", name_of(kind));
    fmt::print(stderr, "turnaround: {} ...\n", name);
    const auto figures = undisturbed(name, [&] { return compare(cables, kind, count, busy, options); });
    const Baseline floor{fmt::format("echo_{}{}", name_of(kind), busy ? "_spinning" : ""), figures.echo,
                         figures.ratios};
    report.add({name, "echo_round_trip", "ns", floor.figures});
    // `simulate` uses a ring if the kernel has one.
    const auto aim = kind == Socket::kRing ? std::optional(kAim * floor.figures.p50) : std::nullopt;
    report.add({name, "round_trip", "ns", figures.line, aim, floor});
  }
}

void measure_all(const Options& options) {
  Report report("turnaround");
  auto obstacle = enter_private_network();
  const auto echo = obstacle.empty() ? make_veth_pair("echo") : std::nullopt;
  const auto line = obstacle.empty() ? make_veth_pair("line") : std::nullopt;
  if (obstacle.empty() && !(echo && line))
    obstacle = "no veth pair: the kernel lacks the driver or `ip` is not installed";
  if (obstacle.empty()) {
    // The master gets a processor of its own, as a real one has: on the server's processor it would be preempted by the
    // answer, and starved by a server that spins.
    claim_cpu(std::max(0, last_cpu() - 1));
    for (const bool busy : {false, true}) {
      for (const std::size_t count : {1U, 8U, 32U}) measure_case(report, {*echo, *line}, count, busy, options);
    }
  }
  report.note(fmt::format(
      "MSD drives in OP, the cyclic frame of their master; every answer is checked: the AL status of all\n"
      "drives, all working counters. packet_mmap: server and echo receive through a ring shared with the\n"
      "kernel, as simulate does; recv: both with a system call for each frame. Rounds of {} frames in turns.",
      kFramesPerRound));
  report.print(options);
  if (!obstacle.empty()) throw Skipped(obstacle);
}

}  // namespace

int main(int argc, char** argv) {
  return run(argc, argv, "How long does a frame to a simulated line take, against a bare echo?", measure_all);
}
