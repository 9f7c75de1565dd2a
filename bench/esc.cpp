// Measures the cost of emulated slaves per frame: frames addressed to no slave, to all slaves, and process data, for 1
// to 256 slaves on a line, with nothing else in the loop.
#include <fmt/format.h>
#include <algorithm>
#include <cstring>
#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

#include "driveline/esi/sii.hpp"
#include "driveline/rt/clock.hpp"
#include "driveline/slaves/line/simulated_line.hpp"
#include "driveline/wire/frame.hpp"
#include "support/environment.hpp"
#include "support/realtime.hpp"
#include "support/report.hpp"
#include "support/stopwatch.hpp"

namespace {

using namespace driveline;
using namespace driveline::bench;
using namespace std::chrono_literals;
using wire::Command;
using wire::DatagramAddress;

constexpr std::uint16_t kProcessData = 23;  // bytes in each direction
constexpr std::uint16_t kOutputs = 0x1400;
constexpr std::uint16_t kInputs = 0x1800;
constexpr std::uint16_t kStation = 0x1001;
constexpr double kElsewhereAimNs = 20.0;
constexpr double kLrwAimNs = 100.0;
constexpr double kMemoryAimMib = 256.0;

/// A device whose application costs nothing, so that only controller and line are measured.
class IdleDevice final : public slaves::Device {
 public:
  IdleDevice() {
    using Use = slaves::SyncManagerLayout::Use;
    profile_.sii_image.resize(128);
    profile_.sii_image[14] = static_cast<std::byte>(
        esi::sii_checksum(std::span(std::as_const(profile_.sii_image)).first<esi::SiiConfigArea::kSize>()));
    profile_.sync_managers = {{Use::kMailboxOut, 0x1000, 128, 128, 128},
                              {Use::kMailboxIn, 0x1200, 128, 128, 128},
                              {Use::kOutputs, kOutputs, 0, 0, kProcessData},
                              {Use::kInputs, kInputs, 0, 0, kProcessData}};
  }
  const slaves::DeviceProfile& profile() const noexcept override { return profile_; }
  std::size_t process_data_size(std::size_t sync_manager) const noexcept override {
    return sync_manager >= 2 ? kProcessData : 0;
  }
  wire::AlStatusCode transition(wire::AlState, wire::AlState) noexcept override { return wire::AlStatusCode::kNoError; }
  void fall_back(wire::AlState, wire::AlState, wire::AlStatusCode) noexcept override {}
  void write_outputs(std::size_t, std::span<const std::byte>) noexcept override {}
  void read_inputs(std::size_t, std::span<std::byte> data) noexcept override {
    ++published;
    data[0] = static_cast<std::byte>(published);
  }
  void mailbox_request(std::span<const std::byte>) override {}
  std::size_t mailbox_reply(std::span<std::byte>) override { return 0; }
  void advance(std::chrono::nanoseconds) noexcept override {}
  std::chrono::nanoseconds process_data_period() const noexcept override { return 125us; }

  unsigned published = 0;  ///< number of requests for the inputs

 private:
  slaves::DeviceProfile profile_;
};

using Frame = std::vector<std::byte>;

/// The frames of a pass, and their expected effects, which are checked.
struct Work {
  std::vector<Frame> frames;
  std::vector<unsigned> working_counters;  ///< increment by each frame, per pass
  std::chrono::nanoseconds period{};       ///< between passes on the clock of the line; 0: the devices do not run
};

/// The working counter of the only datagram of a frame, after its data; a short frame is padded after it.
unsigned working_counter(const Frame& frame) {
  constexpr std::size_t kLength = wire::kDatagramsOffset + 6;
  const std::span bytes(frame);
  const auto length = bytes::load_le<std::uint16_t>(bytes.subspan<kLength, 2>()) & 0x7FFU;
  return bytes::load_le<std::uint16_t>(
      bytes.subspan(wire::kDatagramsOffset + wire::DatagramHeader::kSize + length).first<2>());
}

/// A line in OP with one process image of all slaves, split into as many frames as needed.
class IdleLine {
 public:
  explicit IdleLine(std::size_t count) : line_(clock_, make_slaves(count)), count_(count) { start_up(); }

  slaves::SimulatedLine& line() { return line_; }
  std::chrono::nanoseconds now() const { return clock_.now(); }
  void pass(std::chrono::nanoseconds time) { clock_.advance(time); }

  static Frame make_frame(Command command, DatagramAddress address, std::span<const std::byte> data) {
    Frame buffer(wire::EthernetHeader::kSize + wire::kMaxPayloadBytes);
    wire::FrameBuilder builder(buffer, {});
    const auto place = builder.add(command, 0, address, data.size());
    std::copy(data.begin(), data.end(), builder.data(*place).begin());
    const auto frame = builder.finish();
    return {frame.begin(), frame.end()};
  }

  /// LRW frames that together cover the process data of every slave once.
  [[nodiscard]] Work process_data(std::chrono::nanoseconds period) const {
    constexpr std::size_t kPerFrame = wire::kMaxDatagramData / (2 * kProcessData);
    Work work{{}, {}, period};
    for (std::size_t first = 0; first < count_; first += kPerFrame) {
      const std::size_t slaves = std::min(kPerFrame, count_ - first);
      work.frames.push_back(make_frame(Command::kLrw, DatagramAddress::logical(logical(first)),
                                       Frame(slaves * 2 * kProcessData, std::byte{0x5A})));
      // In an LRW, a written slave adds 2 and a read one 1 (ETG.1000.4 5.4.1.2).
      work.working_counters.push_back(3 * static_cast<unsigned>(slaves));
    }
    return work;
  }
  /// A frame that reads the AL status, and is answered by `slaves` slaves.
  [[nodiscard]] static Work al_status(Command command, std::uint16_t station, std::size_t slaves) {
    const Frame two_bytes(2);
    return {{make_frame(command, DatagramAddress::physical(station, 0x0130), two_bytes)},
            {static_cast<unsigned>(slaves)},
            0ns};
  }

  /// Number of requests for its inputs, of each device.
  [[nodiscard]] std::vector<unsigned> published() const {
    std::vector<unsigned> counts;
    for (const auto* device : devices_) counts.push_back(device->published);
    return counts;
  }
  /// Throws std::runtime_error unless all slaves are in OP.
  void check_op() {
    for (std::size_t i = 0; i < count_; ++i) {
      if (line_.slave(i).state() == wire::AlState::kOp) continue;
      throw std::runtime_error(fmt::format("slave {} is not in OP, AL status code 0x{:04X}", i,
                                           unsigned{line_.slave(i).esc().memory().get(wire::reg::kAlStatusCode)}));
    }
  }

 private:
  std::vector<std::unique_ptr<slaves::Slave>> make_slaves(std::size_t count) {
    std::vector<std::unique_ptr<slaves::Slave>> result;
    for (std::size_t i = 0; i < count; ++i) {
      auto device = std::make_unique<IdleDevice>();
      devices_.push_back(device.get());
      result.push_back(std::make_unique<slaves::Slave>(std::move(device)));
    }
    return result;
  }
  static std::uint32_t logical(std::size_t slave) {
    return 0x10000U + static_cast<std::uint32_t>(slave * 2 * kProcessData);
  }

  void send(Command command, std::uint16_t adp, std::uint16_t ado, std::span<const std::byte> data) {
    auto frame = make_frame(command, DatagramAddress::physical(adp, ado), data);
    line_.process(frame, clock_.now());
    clock_.advance(1ms);  // the frame needs this time to reach the last slave
    line_.advance(clock_.now());
  }
  void set_sync_manager(unsigned n, const wire::SyncManagerChannel& channel) {
    std::array<std::byte, wire::SyncManagerChannel::kSize> raw{};
    channel.encode(raw);
    send(Command::kBwr, 0, static_cast<std::uint16_t>(0x0800 + 8 * n), raw);
  }
  void request(wire::AlState state) {
    send(Command::kBwr, 0, 0x0120, bytes::to_le_bytes(wire::AlControl{state, false, false}.raw()));
  }
  void start_up() {
    for (std::size_t i = 0; i < count_; ++i) {
      const auto station = static_cast<std::uint16_t>(kStation + i);
      send(Command::kApwr, static_cast<std::uint16_t>(0U - i), 0x0010, bytes::to_le_bytes(station));
      std::array<std::byte, 2 * wire::FmmuEntity::kSize> fmmus{};
      wire::FmmuEntity{logical(i), kProcessData, 0, 7, kOutputs, 0, wire::FmmuEntity::kTypeWrite, true}.encode(
          std::span(fmmus).first<16>());
      wire::FmmuEntity{logical(i) + kProcessData, kProcessData, 0, 7, kInputs, 0, wire::FmmuEntity::kTypeRead, true}
          .encode(std::span(fmmus).last<16>());
      send(Command::kFpwr, station, 0x0600, fmmus);
    }
    set_sync_manager(0, {0x1000, 128, 0x26, 0, 1, 0});
    set_sync_manager(1, {0x1200, 128, 0x22, 0, 1, 0});
    request(wire::AlState::kPreOp);
    set_sync_manager(2, {kOutputs, kProcessData, 0x64, 0, 1, 0});
    set_sync_manager(3, {kInputs, kProcessData, 0x20, 0, 1, 0});
    request(wire::AlState::kSafeOp);
    for (auto& frame : process_data(0ns).frames) line_.process(frame, clock_.now());
    request(wire::AlState::kOp);
    check_op();
  }

  std::vector<const IdleDevice*> devices_;
  rt::VirtualClock clock_{1s};
  slaves::SimulatedLine line_;
  std::size_t count_;
};

/// Passes `work` and checks every pass: all frames have returned with the expected working counters, and the inputs
/// were published as often as the time of the line requires.
class Passes {
 public:
  Passes(IdleLine& line, Work work) : line_(line), work_(std::move(work)), published_(line.published()) {}

  /// The measured part: passes the frames once.
  void pass() {
    line_.pass(work_.period);
    for (auto& frame : work_.frames) back_ += line_.line().process(frame, line_.now()) ? 1 : 0;
    ++done_;
  }
  /// Checks the passes since the last check. Throws std::runtime_error.
  void check() {
    if (back_ != done_ * work_.frames.size()) {
      throw std::runtime_error(fmt::format("{} of {} frames came back", back_, done_ * work_.frames.size()));
    }
    for (std::size_t i = 0; i < work_.frames.size(); ++i) {
      // The counter is not cleared between passes, so it accumulates modulo 2^16.
      const auto expected = (before_[i] + work_.working_counters[i] * (done_ - checked_)) & 0xFFFFU;
      const auto found = working_counter(work_.frames[i]);
      if (found != expected) throw std::runtime_error(fmt::format("working counter {}, expected {}", found, expected));
      before_[i] = found;
    }
    checked_ = done_;
  }
  /// Checks the line at the end. A slave that has left OP does not return to it, so a single check is enough.
  void check_line() {
    line_.check_op();
    const auto published = line_.published();
    for (std::size_t i = 0; i < published.size(); ++i) {
      const auto times = published[i] - published_[i];
      const bool right = work_.period == 0ns ? times == 0 : times + 1 >= done_;
      if (!right) {
        throw std::runtime_error(fmt::format("slave {} published its inputs {} times in {} passes", i, times, done_));
      }
    }
  }

 private:
  IdleLine& line_;
  Work work_;
  std::vector<unsigned> published_;
  std::vector<unsigned> before_ = std::vector<unsigned>(work_.frames.size());
  unsigned done_ = 0;
  unsigned checked_ = 0;
  std::size_t back_ = 0;
};

/// ns per pass of `work`. Passes that are short compared with the resolution of the clock are measured in batches.
Summary measure(IdleLine& line, const Work& work, int rounds, int batch) {
  constexpr int kWarmUp = 32;
  std::vector<double> samples;
  samples.reserve(static_cast<std::size_t>(rounds));
  Passes passes(line, work);
  Rests rests;
  int cold = std::max(kWarmUp, rounds / 10);
  while (samples.size() < static_cast<std::size_t>(rounds)) {
    const double begin = now_ns();
    for (int i = 0; i < batch; ++i) passes.pass();
    const double cost = (now_ns() - begin - reading_cost_ns()) / batch;
    passes.check();
    if (rests.take_when_due(begin)) cold = kWarmUp;
    if (cold-- <= 0) samples.push_back(cost);
  }
  passes.check_line();
  return summarize(std::move(samples));
}

/// The baseline: copies the bytes of the frames once. ns per slave.
Baseline copy_frames(const std::vector<Frame>& frames, int rounds, double slaves) {
  constexpr int kBatch = 64;
  Frame copy(port::kMaxFrameBytes);
  std::vector<double> samples;
  for (int round = 0; round < rounds; ++round) {
    const double begin = now_ns();
    for (int i = 0; i < kBatch; ++i) {
      for (const auto& frame : frames) {
        std::memcpy(copy.data(), frame.data(), frame.size());
        keep(*copy.data());
      }
    }
    samples.push_back((now_ns() - begin - reading_cost_ns()) / kBatch / slaves);
  }
  return {"copy_of_the_frames", summarize(std::move(samples))};
}

/// Frames per second at the percentiles of the cost: p99 is the rate that 99 % of the frames reach.
Summary rates(const Summary& cost_ns, std::size_t frames) {
  const auto rate = [frames](double cost) { return static_cast<double>(frames) * 1e9 / cost; };
  return {cost_ns.n, rate(cost_ns.p50), rate(cost_ns.p99), rate(cost_ns.p999), rate(cost_ns.max)};
}

void measure_line(Report& report, std::size_t count, const Options& options) {
  IdleLine line(count);
  const int rounds = options.count(static_cast<int>(2'000'000 / (count + 80)));
  const int batch = std::max(1, 64 / static_cast<int>(count));
  const auto slaves = static_cast<double>(count);
  const auto add = [&](const char* what, const Work& work, std::optional<double> aim) {
    const auto name = fmt::format("{}_{}_slaves", what, count);
    const auto cost = measure(line, work, rounds, batch);
    const auto floor = copy_frames(work.frames, rounds / 10 + 1, slaves);
    report.add({name, "cost_per_slave", "ns", divided(cost, slaves), aim, floor});
    report.add({name, "throughput", "frames/s", rates(cost, work.frames.size())});
  };
  add("brd", IdleLine::al_status(Command::kBrd, 0, count), {});
  add("fprd_elsewhere", IdleLine::al_status(Command::kFprd, 0x0BAD, 0), kElsewhereAimNs);
  add("lrw_23_23", line.process_data(0ns), kLrwAimNs);
  // Outputs are handed to the devices and inputs published before every frame, as in a running line.
  add("lrw_23_23_and_hand_over", line.process_data(125us), {});
  const double mib = static_cast<double>(resident_bytes()) / (1024.0 * 1024.0);
  report.add({fmt::format("{}_slaves", count),
              "resident_memory",
              "MiB",
              {1, mib, mib, mib, mib},
              count == 256 ? std::optional(kMemoryAimMib) : std::nullopt});
}

void measure_all(const Options& options) {
  Report report("esc");
  claim_cpu(last_cpu());
  for (const std::size_t count : {1U, 8U, 64U, 256U}) measure_line(report, count, options);
  report.print(options);
}

}  // namespace

int main(int argc, char** argv) {
  return run(argc, argv, "What do emulated slave controllers cost per frame, for 1 to 256 slaves?", measure_all);
}
