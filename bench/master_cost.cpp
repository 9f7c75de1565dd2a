// What does the master's cycle (send, receive, decode) cost on a packet socket, compared with loops that only send and
// receive the same frames? All use the same virtual cable, in turns; a minimal responder spins at its other end.
#include <fmt/format.h>
#include <sys/socket.h>
#include <algorithm>
#include <cstring>
#include <memory>
#include <stdexcept>
#include <thread>
#include <vector>

#include "driveline/ecat_master/cyclic/cyclic_core.hpp"
#include "driveline/port/raw_socket_port.hpp"
#include "support/cyclic_frame.hpp"
#include "support/decoder.hpp"
#include "support/packet_ring.hpp"
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
using ecat_master::CyclicCore;
using ecat_master::ProcessImage;

constexpr int kCycles = 60'000;
/// So short that a disturbance of the machine affects all loops alike.
constexpr int kCyclesPerRound = 500;
constexpr int kWarmUp = 20;
/// Aims: median and 99.9 % of the master's cycle over those of the bare loop on the same kind of socket, with a receive
/// ring.
constexpr double kAim = 1.05;
constexpr double kAimP999 = 1.2;
constexpr double kLostNs = 5e6;
/// With more incomplete cycles per round than this, the figures would show the machine's other work.
constexpr int kMaxLostPerRound = 25;

/// Answers like a line in OP, with minimal effort: sets working counters and AL status bytes.
class Responder {
 public:
  Responder(const std::string& interface, const std::vector<CyclicFrame>& frames) : frames_(frames) {
    socket_.bind_to(interface);
    thread_ = std::jthread([this](const std::stop_token& stop) { run(stop); });
  }

 private:
  void run(const std::stop_token& stop) {
    claim_cpu(last_cpu());
    std::array<std::byte, port::kMaxFrameBytes> frame;
    while (!stop.stop_requested()) {
      const auto size = recv(socket_.get(), frame.data(), frame.size(), 0);
      if (size <= 0) continue;
      frame[6] |= std::byte{0x02};
      for (const auto& one : frames_) {
        if (one.bytes.size() != static_cast<std::size_t>(size)) continue;
        for (const auto& change : one.changes) frame[change.offset] = change.value;
      }
      keep(send(socket_.get(), frame.data(), static_cast<std::size_t>(size), 0));
    }
  }

  PacketSocket socket_;
  std::vector<CyclicFrame> frames_;
  std::jthread thread_;
};

/// Runs cycles of a loop that checks nothing until the responder answers.
template <typename Loop>
void settle_bare(Loop& loop) {
  constexpr int kTimeout = 400;
  for (int i = 0; i < kTimeout; ++i) {
    // Sleep, because the responder starts on the processor of the thread that created it.
    std::this_thread::sleep_for(1ms);
    loop.drain();
    if (loop.cycle() < kLostNs) return;
  }
  throw std::runtime_error("the responder does not answer");
}

/// The baseline: sends all frames, then spins until as many have returned.
class BareLoop {
 public:
  BareLoop(const std::string& interface, const std::vector<CyclicFrame>& frames) : frames_(frames) {
    socket_.bind_to(interface);
  }
  double cycle() {
    const double begin = now_ns();
    for (const auto& frame : frames_) keep(send(socket_.get(), frame.bytes.data(), frame.bytes.size(), 0));
    for (std::size_t back = 0; back < frames_.size();) {
      const auto size = recv(socket_.get(), buffer_.data(), buffer_.size(), MSG_TRUNC);
      if (size > 0) ++back;
      if (size <= 0 && now_ns() - begin > kLostNs) break;
    }
    return now_ns() - begin;
  }
  void settle() { settle_bare(*this); }
  void check() const noexcept {}
  /// Discards frames that come too late: the next cycle would take them for its own and appear short.
  void drain() {
    for (const double until = now_ns() + kLostNs; now_ns() < until;) {
      keep(recv(socket_.get(), buffer_.data(), buffer_.size(), MSG_TRUNC));
    }
  }

 private:
  PacketSocket socket_;
  std::vector<CyclicFrame> frames_;
  std::array<std::byte, port::kMaxFrameBytes> buffer_;
};

/// The same with a receive ring that is shared with the kernel: receives without a system call.
class RingLoop {
 public:
  RingLoop(const std::string& interface, const std::vector<CyclicFrame>& frames)
      : ring_(socket_.get()), frames_(frames) {
    socket_.bind_to(interface);
  }
  double cycle() {
    const double begin = now_ns();
    for (const auto& frame : frames_) keep(send(socket_.get(), frame.bytes.data(), frame.bytes.size(), 0));
    for (std::size_t back = 0; back < frames_.size();) {
      // Copy into the program's memory, as recv() does: the bytes in the ring are in the cache of the other processor.
      if (ring_.take_into(buffer_)) {
        keep(buffer_[0]);
        ++back;
      } else if (now_ns() - begin > kLostNs) {
        break;
      }
    }
    return now_ns() - begin;
  }
  void settle() { settle_bare(*this); }
  void check() const noexcept {}
  void drain() {
    for (const double until = now_ns() + kLostNs; now_ns() < until;) ring_.discard();
  }

 private:
  PacketSocket socket_;
  PacketRing ring_;
  std::vector<CyclicFrame> frames_;
  std::array<std::byte, port::kMaxFrameBytes> buffer_;
};

/// The cycle of the master on the raw socket port.
class MasterLoop {
 public:
  MasterLoop(const std::string& interface, const ProcessImage& image) : decoder_(image), port_(open(interface)) {
    CyclicCore::Settings settings;
    settings.receive_window = 5ms;
    settings.slaves = static_cast<std::uint16_t>(image.places().size());
    tasks_.add(decoder_, {});
    settings.tasks = &tasks_;
    core_ = std::make_unique<CyclicCore>(*port_, clock_, image, nullptr, motion::SampleRings{}, settings);
  }
  double cycle() {
    const double begin = now_ns();
    // On a running line the cycle timer provides the wake-up time.
    const std::chrono::nanoseconds wake{static_cast<std::int64_t>(begin)};
    core_->cycle({cycle_++, wake, wake, 0});
    return now_ns() - begin;
  }
  void drain() noexcept {}  // the master numbers its frames and detects late ones
  /// Checks that the cycle has read the responder's values, because wrong frames do not show in the figures.
  void check() const {
    const auto& statistics = core_->statistics();
    if (statistics.wkc_errors > 0) {
      throw std::runtime_error(
          fmt::format("{} frames of the master came back with wrong working counters", statistics.wkc_errors));
    }
  }
  /// Runs cycles until the responder answers like a line.
  void settle() {
    constexpr int kTimeout = 400;
    for (int i = 0; i < kTimeout; ++i) {
      cycle();
      if (core_->bad_cycles() == 0 && core_->al_status().slaves != 0) return;
    }
    throw std::runtime_error("the responder sends wrong answers");
  }

 private:
  std::unique_ptr<port::RawSocketPort> open(const std::string& interface) {
    auto port = port::RawSocketPort::open({.interface = interface}, clock_);
    if (!port) throw std::runtime_error(port.error().message);
    return std::move(*port);
  }

  rt::MonotonicClock clock_;
  Decoder decoder_;
  motion::TaskSchedule tasks_;
  std::unique_ptr<port::RawSocketPort> port_;
  std::unique_ptr<CyclicCore> core_;
  std::int64_t cycle_ = 0;
};

/// Runs a round of a loop created for this round only, so that no other socket receives its frames.
template <typename Make>
void round_of(const Make& make, TurnSamples& turns) {
  auto loop = make();
  loop->settle();
  for (int i = 0; i < kWarmUp; ++i) loop->cycle();
  int lost = 0;
  std::vector<double> samples;
  for (int i = 0; i < kCyclesPerRound; ++i) {
    samples.push_back(loop->cycle());
    if (samples.back() < kLostNs) continue;
    loop->drain();
    if (++lost > kMaxLostPerRound) throw Disturbed(fmt::format("{} of {} cycles lost frames", lost, i + 1));
  }
  loop->check();
  turns.add_turn(samples);
}

/// The samples of the three loops, in ns per cycle.
struct Samples {
  TurnSamples master;
  TurnSamples bare;
  TurnSamples ring;
};

Samples take_turns(const VethPair& cable, std::size_t axes, int cycles) {
  const auto image = make_image(axes);
  const auto frames = cyclic_frames(image);
  const Responder responder(cable.far, frames);
  Samples samples;
  for (int round = 0; round < std::max(1, cycles / kCyclesPerRound); ++round) {
    round_of([&] { return std::make_unique<BareLoop>(cable.near, frames); }, samples.bare);
    round_of([&] { return std::make_unique<MasterLoop>(cable.near, image); }, samples.master);
    round_of([&] { return std::make_unique<RingLoop>(cable.near, frames); }, samples.ring);
  }
  return samples;
}

void measure_axes(Report& report, const VethPair& cable, std::size_t axes, int cycles) {
  const auto name = fmt::format("{}_axes", axes);
  const auto samples = undisturbed(name, [&] { return take_turns(cable, axes, cycles); });
  const auto compared_with = [&samples](const char* loop, const TurnSamples& floor) {
    return Baseline{loop, summarize(floor.all()), ratios_by_turn(samples.master.medians(), floor.medians())};
  };
  const auto against_bare = compared_with("bare_af_packet_loop", samples.bare);
  const auto against_ring = compared_with("bare_packet_mmap_loop", samples.ring);
  const auto figures = summarize(samples.master.all());
  const auto& floor = against_ring.figures;
  report.add({name, "send_receive_decode", "ns", figures, kAim * floor.p50, against_ring, kAimP999 * floor.p999});
  report.add({name, "bare_packet_mmap_loop", "ns", floor});
  report.add({name, "against_af_packet", "ns", figures, std::nullopt, against_bare});
  report.add({name, "bare_af_packet_loop", "ns", against_bare.figures});
}

void measure_all(const Options& options) {
  Report report("master_cost");
  const auto problem = enter_private_network();
  const auto cable = problem.empty() ? make_veth_pair("dlcost") : std::nullopt;
  if (!cable) {
    report.print(options);
    throw Skipped("no veth pair can be made here" + (problem.empty() ? std::string() : ": " + problem));
  }
  claim_cpu(std::max(0, last_cpu() - 1));
  for (const std::size_t axes : {1U, 8U, 32U, 100U}) measure_axes(report, *cable, axes, options.count(kCycles));
  report.note(
      fmt::format("Cycles back to back over a veth pair; the responder spins on the last CPU. Rounds of {} cycles\n"
                  "in turns: bare AF_PACKET loop, master, bare PACKET_MMAP loop. The master also checks headers\n"
                  "and working counters, copies the process image both ways, and reads and writes two entries\n"
                  "of each axis.",
                  kCyclesPerRound));
  report.print(options);
}

}  // namespace

int main(int argc, char** argv) {
  return run(argc, argv,
             "What does the master's cycle on a packet socket cost against bare loops with the same frames?",
             measure_all);
}
