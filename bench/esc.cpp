// What do emulated slaves cost per frame? Frames that are for nobody, for everybody and process data, for 1 to 256
// slaves on a line, nothing else in the loop.
#include <fmt/format.h>
#include <algorithm>
#include <cstring>
#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

#include "driveline/esi/sii.hpp"
#include "driveline/rt/clock.hpp"
#include "driveline/slaves/line/line.hpp"
#include "driveline/wire/frame.hpp"
#include "support/environment.hpp"
#include "support/report.hpp"
#include "support/stopwatch.hpp"

namespace {

using namespace driveline;
using namespace driveline::bench;
using namespace std::chrono_literals;
using wire::Command;
using wire::DatagramAddress;

constexpr std::uint16_t kProcessData = 23;  // bytes each way
constexpr std::uint16_t kOutputs = 0x1400;
constexpr std::uint16_t kInputs = 0x1800;
constexpr std::uint16_t kStation = 0x1001;
constexpr double kElsewhereAimNs = 20.0;
constexpr double kLrwAimNs = 100.0;
constexpr double kMemoryAimMib = 256.0;

/// A device whose own life costs nothing, so that only controller and line are measured.
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
  void read_inputs(std::size_t, std::span<std::byte> data) noexcept override { data[0] ^= std::byte{1}; }
  void mailbox_request(std::span<const std::byte>) override {}
  std::size_t mailbox_reply(std::span<std::byte>) override { return 0; }
  void advance(std::chrono::nanoseconds) noexcept override {}
  std::chrono::nanoseconds process_data_period() const noexcept override { return 125us; }

 private:
  slaves::DeviceProfile profile_;
};

using Frame = std::vector<std::byte>;

/// A line in OP with one process image of all slaves, cut into as many frames as it needs.
class IdleLine {
 public:
  explicit IdleLine(std::size_t count) : line_(clock_, make_slaves(count)), count_(count) { start_up(); }

  slaves::Line& line() { return line_; }
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

  /// LRW frames that cover the process data of every slave once.
  [[nodiscard]] std::vector<Frame> process_data_frames() const {
    constexpr std::size_t kPerFrame = wire::kMaxDatagramData / (2 * kProcessData);
    std::vector<Frame> frames;
    for (std::size_t first = 0; first < count_; first += kPerFrame) {
      const std::size_t slaves = std::min(kPerFrame, count_ - first);
      frames.push_back(make_frame(Command::kLrw, DatagramAddress::logical(logical(first)),
                                  Frame(slaves * 2 * kProcessData, std::byte{0x5A})));
    }
    return frames;
  }

 private:
  static std::vector<std::unique_ptr<slaves::Slave>> make_slaves(std::size_t count) {
    std::vector<std::unique_ptr<slaves::Slave>> result;
    for (std::size_t i = 0; i < count; ++i) {
      result.push_back(std::make_unique<slaves::Slave>(std::make_unique<IdleDevice>()));
    }
    return result;
  }
  static std::uint32_t logical(std::size_t slave) {
    return 0x10000U + static_cast<std::uint32_t>(slave * 2 * kProcessData);
  }

  void send(Command command, std::uint16_t adp, std::uint16_t ado, std::span<const std::byte> data) {
    auto frame = make_frame(command, DatagramAddress::physical(adp, ado), data);
    line_.process(frame, clock_.now());
    clock_.advance(1ms);  // the frame needs its time to the last slave
    line_.advance(clock_.now());
  }
  void set_sync_manager(unsigned n, const wire::SyncManagerChannel& channel) {
    std::array<std::byte, wire::SyncManagerChannel::kSize> raw{};
    channel.encode(raw);
    send(Command::kBwr, 0, static_cast<std::uint16_t>(0x0800 + 8 * n), raw);
  }
  void request(wire::AlState state) {
    send(Command::kBwr, 0, 0x0120, wire::to_le_bytes(wire::AlControl{state, false, false}.raw()));
  }
  void start_up() {
    for (std::size_t i = 0; i < count_; ++i) {
      const auto station = static_cast<std::uint16_t>(kStation + i);
      send(Command::kApwr, static_cast<std::uint16_t>(0U - i), 0x0010, wire::to_le_bytes(station));
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
    for (auto& frame : process_data_frames()) line_.process(frame, clock_.now());
    request(wire::AlState::kOp);
    for (std::size_t i = 0; i < count_; ++i) {
      if (line_.slave(i).state() == wire::AlState::kOp) continue;
      std::fprintf(stderr, "esc: slave %zu did not reach OP, AL status code 0x%04X\n", i,
                   unsigned{line_.slave(i).esc().memory().get(wire::reg::kAlStatusCode)});
      std::exit(1);
    }
  }

  rt::VirtualClock clock_{1s};
  slaves::Line line_;
  std::size_t count_;
};

/// ns per set of frames: all `frames` pass the line, `period` after the ones before on the line's clock. Sets that
/// are short against the resolution of the clock are measured several at a time.
Summary measure(IdleLine& line, std::vector<Frame> frames, std::chrono::nanoseconds period, int rounds, int batch) {
  std::vector<double> samples;
  samples.reserve(static_cast<std::size_t>(rounds));
  for (int round = -rounds / 10; round < rounds; ++round) {
    const double begin = now_ns();
    for (int i = 0; i < batch; ++i) {
      line.pass(period);
      for (auto& frame : frames) line.line().process(frame, line.now());
    }
    const double cost = (now_ns() - begin - reading_cost_ns()) / batch;
    if (round >= 0) samples.push_back(cost);
  }
  return summarize(std::move(samples));
}

/// The floor: the bytes of the frames copied once, and nothing done to them. ns per slave.
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
  const auto add = [&](const char* what, const std::vector<Frame>& frames, std::chrono::nanoseconds period,
                       std::optional<double> aim) {
    const auto name = fmt::format("{}_{}_slaves", what, count);
    const auto cost = measure(line, frames, period, rounds, batch);
    report.add(
        {name, "cost_per_slave", "ns", divided(cost, slaves), aim, copy_frames(frames, rounds / 10 + 1, slaves)});
    report.add({name, "throughput", "frames/s", rates(cost, frames.size())});
  };
  const Frame two_bytes(2);
  add("brd", {IdleLine::make_frame(Command::kBrd, DatagramAddress::physical(0, 0x0130), two_bytes)}, 0ns, {});
  add("fprd_elsewhere", {IdleLine::make_frame(Command::kFprd, DatagramAddress::physical(0x0BAD, 0x0130), two_bytes)},
      0ns, kElsewhereAimNs);
  add("lrw_23_23", line.process_data_frames(), 0ns, kLrwAimNs);
  // Outputs handed to the device and inputs published before every frame, as in a running line.
  add("lrw_23_23_and_hand_over", line.process_data_frames(), 125us, {});
  const double mib = static_cast<double>(resident_bytes()) / (1024.0 * 1024.0);
  report.add({fmt::format("{}_slaves", count),
              "resident_memory",
              "MiB",
              {1, mib, mib, mib, mib},
              count == 256 ? std::optional(kMemoryAimMib) : std::nullopt});
}

void measure_all(const Options& options) {
  Report report("esc");
  for (const std::size_t count : {1U, 8U, 64U, 256U}) measure_line(report, count, options);
  report.print(options);
}

}  // namespace

int main(int argc, char** argv) {
  return run(argc, argv, "What do emulated slave controllers cost per frame, for 1 to 256 slaves?", measure_all);
}
