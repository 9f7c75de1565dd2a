// Executes one of the hot paths a given number of times, on virtual time and without reading a clock, so that a tool
// that counts instructions (scripts/bench_instructions.py) finds the same number on every run.
#include <fmt/format.h>
#include <array>
#include <charconv>
#include <cstdio>
#include <cstring>
#include <exception>
#include <memory>
#include <optional>
#include <span>
#include <stdexcept>
#include <string_view>
#include <utility>
#include <vector>

#include "driveline/ecat_master/cyclic/cyclic_core.hpp"
#include "driveline/port/port.hpp"
#include "driveline/rt/clock.hpp"
#include "driveline/trajectory/interpolator.hpp"
#include "driveline/trajectory/path.hpp"
#include "driveline/wire/frame.hpp"
#include "support/can_rig.hpp"
#include "support/cyclic_frame.hpp"
#include "support/decoder.hpp"
#include "support/drive_cycles.hpp"
#include "support/line_rig.hpp"
#include "support/stopwatch.hpp"

namespace {

using namespace driveline;
using namespace driveline::bench;
using std::chrono::nanoseconds;

constexpr std::size_t kAxes = 8;

/// Answers every frame at once, like a line in OP.
class AnsweringPort final : public port::Port {
 public:
  explicit AnsweringPort(std::vector<CyclicFrame> frames) : frames_(std::move(frames)) {}

  [[nodiscard]] port::SendStatus send(std::span<const std::byte> frame) noexcept override {
    std::memcpy(answer_.data(), frame.data(), frame.size());
    for (const auto& one : frames_) {
      if (one.bytes.size() != frame.size()) continue;
      for (const auto& change : one.changes) answer_[change.offset] = change.value;
    }
    waiting_ = frame.size();
    return port::SendStatus::kSent;
  }
  [[nodiscard]] std::optional<port::ReceivedFrame> receive() noexcept override {
    if (waiting_ == 0) return std::nullopt;
    return port::ReceivedFrame{std::span(answer_).first(std::exchange(waiting_, 0)), {}};
  }
  bool wait_readable(nanoseconds /*deadline*/) noexcept override { return waiting_ != 0; }
  [[nodiscard]] nanoseconds last_send_time() const noexcept override { return {}; }

 private:
  std::vector<CyclicFrame> frames_;
  std::array<std::byte, port::kMaxFrameBytes> answer_{};
  std::size_t waiting_ = 0;
};

/// The master's cycle: outputs into the frame, send, receive, check, inputs, and an application that decodes them.
void master(int count) {
  const auto image = make_image(kAxes);
  Decoder decoder(image);
  AnsweringPort port(cyclic_frames(image));
  rt::VirtualClock clock;
  motion::TaskSchedule tasks;
  tasks.add(decoder, {});
  ecat_master::CyclicCore::Settings settings;
  settings.slaves = kAxes;
  settings.tasks = &tasks;
  ecat_master::CyclicCore core(port, clock, image, nullptr, motion::SampleRings{}, settings);
  for (int i = 0; i < count; ++i) {
    clock.advance(settings.period);
    core.cycle({i, clock.now(), clock.now(), 0});
  }
  const auto& statistics = core.statistics();
  if (statistics.wkc_errors + statistics.lost_frames > 0) throw std::runtime_error("frames were lost or wrong");
}

/// A whole cycle: the master's, the axes on their path, the slave controllers, and the drives.
void cycle(int count) {
  rt::VirtualClock clock;
  LineRig rig(clock, kAxes, count * LineRig::kPeriod + std::chrono::seconds{1});
  rig.bring_up([&](ecat_master::CyclicCore& core) -> std::unique_ptr<motion::CycleRunner> {
    return std::make_unique<motion::InlineRunner>(core, clock);
  });
  for (int i = 0; i < count; ++i) {
    rig.master().pass(nanoseconds{1});
    rig.drain();
  }
  rig.check();
}

/// A whole cycle of a CAN line: SYNC, the master with its axes on their path, the bus, the devices and their drives.
void can_cycle(int count) {
  constexpr nanoseconds kSyncPeriod = std::chrono::milliseconds{2};
  // The same one for every count, because it counts, too, and at 2 ms it is no small part.
  constexpr nanoseconds kPath = std::chrono::seconds{20};
  if (count * kSyncPeriod > kPath - std::chrono::seconds{1}) throw std::runtime_error("the path is too short");
  rt::VirtualClock clock;
  CanRig rig(clock, kAxes, kSyncPeriod, kPath);
  rig.bring_up([&](canopen::CanCycle& cycle) -> std::unique_ptr<motion::CycleRunner> {
    return std::make_unique<motion::InlineRunner>(cycle, clock);
  });
  for (int i = 0; i < count; ++i) {
    rig.master().pass(nanoseconds{1});
    rig.drain();
  }
  rig.check();
}

/// The simulated drives alone.
void drive(int count) {
  DriveCycles drives(kAxes, count);
  for (int i = 0; i < count; ++i) {
    drives.prepare(1);
    drives.execute();
    drives.read_inputs();
  }
  drives.check();
}

/// Setpoints of a cubic spline in every cycle.
void interpolation(int count) {
  constexpr int kPoints = 1000;
  constexpr double kPointS = 1e-3;
  trajectory::PathBuilder builder;
  std::vector<double> positions(kAxes);
  const auto require = [](const auto& done) {
    if (!done) throw std::runtime_error(done.error().message());
  };
  for (std::size_t i = 0; i < kAxes; ++i) {
    require(builder.add_axis({fmt::format("axis{}", i), trajectory::AxisKind::kRotary}));
  }
  for (int point = 0; point <= kPoints; ++point) {
    for (std::size_t i = 0; i < kAxes; ++i)
      positions[i] = static_cast<double>((point * (37 + 2 * static_cast<int>(i))) % 101);
    require(builder.add_point(point * kPointS, positions));
  }
  auto path = builder.build();
  require(path);
  auto spline = trajectory::Interpolator::clamped_spline(*path);
  std::vector<trajectory::AxisSetpoint> setpoints(kAxes);
  constexpr int kCycles = kPoints * 8;  // of 125 us, to the end of the path; then from its start again
  for (int i = 0; i < count; ++i) {
    spline.evaluate((i % kCycles) * kPointS / 8.0, setpoints);
    keep(setpoints.front());
  }
}

/// A frame of a line is built, and its datagrams are read.
void codec(int count) {
  std::array<std::byte, port::kMaxFrameBytes> buffer{};
  for (int i = 0; i < count; ++i) {
    wire::FrameBuilder builder(buffer, {});
    keep(builder.add(wire::Command::kBrd, 0, wire::DatagramAddress::physical(0, 0x0130), 2));
    for (std::uint32_t datagram = 0; datagram < kAxes; ++datagram) {
      const auto place = builder.add(wire::Command::kLrw, static_cast<std::uint8_t>(datagram),
                                     wire::DatagramAddress::logical(0x1000 * datagram), 38);
      bytes::store_le(builder.data(*place), static_cast<std::uint32_t>(i));
    }
    const auto frame = builder.finish();
    std::uint32_t sum = 0;
    auto cursor = wire::DatagramCursor::open(frame);
    while (cursor && !cursor->done()) {
      const auto datagram = cursor->next();
      if (!datagram) throw std::runtime_error("a frame of our own cannot be read");
      sum += datagram->working_counter() + std::to_integer<std::uint32_t>(datagram->data.front());
    }
    keep(sum);
  }
}

struct HotPath {
  std::string_view name;
  void (*run)(int count);
};
constexpr std::array kHotPaths = {HotPath{"master", master}, HotPath{"cycle", cycle}, HotPath{"drive", drive},
                                  HotPath{"interpolation", interpolation}, HotPath{"codec", codec},
                                  HotPath{"can_cycle", can_cycle},
                                  // of which the counter takes the part of the master
                                  HotPath{"can_master", can_cycle}};

int bad_usage() {
  fmt::print(stderr, "usage: hot_paths PATH COUNT\n       hot_paths compiler\npaths:");
  for (const auto& path : kHotPaths) fmt::print(stderr, " {}", path.name);
  fmt::print(stderr, "\n");
  return 2;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc == 2 && argv[1] == std::string_view("compiler")) {
    fmt::print("{}\n", __VERSION__);
    return 0;
  }
  if (argc != 3) return bad_usage();
  const std::string_view number = argv[2];
  int count = 0;
  const auto parsed = std::from_chars(number.data(), number.data() + number.size(), count);
  if (parsed.ec != std::errc{} || parsed.ptr != number.data() + number.size() || count < 1) return bad_usage();
  for (const auto& path : kHotPaths) {
    if (path.name != argv[1]) continue;
    try {
      path.run(count);
      return 0;
    } catch (const std::exception& error) {
      fmt::print(stderr, "hot_paths: {}\n", error.what());
      return 1;
    }
  }
  return bad_usage();
}
