// Measures what a simulated CAN bus and the CANopen front end of a drive cost, how much memory they take, and what the
// slcan door on TCP carries; and checks the time on the bus by arithmetic of its own.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <optional>
#include <random>
#include <span>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "driveline/canopen_wire/frame_bits.hpp"
#include "driveline/slaves/can/bus.hpp"
#include "driveline/slaves/msd/can/can_table.hpp"
#include "driveline/slaves/msd/can/msd_can_drive.hpp"
#include "support/can_front_ends.hpp"
#include "support/can_master_figures.hpp"
#include "support/environment.hpp"
#include "support/realtime.hpp"
#include "support/report.hpp"
#include "support/retry.hpp"
#include "support/samples.hpp"
#include "support/slcan_line.hpp"
#include "support/stopwatch.hpp"
#include "support/sync_figures.hpp"

namespace {

using namespace driveline;
using namespace driveline::bench;
using namespace std::chrono_literals;
using canopen::Frame;
using slaves::msd::CanConnection;
using slaves::msd::DipSwitch;
using slaves::msd::MsdCanDrive;

constexpr int kFrames = 200'000;
constexpr int kCycles = 20'000;
constexpr int kRoundTrips = 20'000;
constexpr std::size_t kReceivers = 8;
constexpr std::size_t kFramesPerTurn = 50;
constexpr double kFrameAim = 2.0;     ///< medians, a frame through the bus over the floor
constexpr double kFrontEndAim = 0.1;  ///< of the cost of the drive
constexpr double kUploadAimPercent = 1.0;
constexpr double kRoundTripAim = 1.5;  ///< medians, over the echo
constexpr double kNodeAimKib = 8.0;
constexpr double kDriveAimKib = 30.0;

/// A figure that is not a series.
Summary one(double value) {
  return {1, value, value, value, value};
}

/// A node that takes frames and keeps a copy of the last one.
class Taker final : public slaves::can::Node {
 public:
  void connected(slaves::can::Controller& controller) override { controller_ = &controller; }
  void receive(const Frame& frame, std::chrono::nanoseconds /*now*/) override {
    last_ = frame;
    keep(last_);
    ++received_;
  }
  void advance(std::chrono::nanoseconds /*now*/) override {}
  [[nodiscard]] std::chrono::nanoseconds next_wake() const noexcept override { return slaves::can::kNever; }
  [[nodiscard]] slaves::can::Controller& controller() { return *controller_; }
  [[nodiscard]] std::uint64_t received() const noexcept { return received_; }

 private:
  slaves::can::Controller* controller_ = nullptr;
  Frame last_;
  std::uint64_t received_ = 0;
};

/// A sender and eight nodes that receive.
class EightTakers {
 public:
  EightTakers() : takers_(kReceivers) {
    bus_.attach(sender_);
    for (Taker& taker : takers_) bus_.attach(taker);
    bus_.advance(1ms);
  }
  /// Passes these frames; the bus needs no time between them.
  void pass(std::span<const Frame> frames) {
    for (const Frame& frame : frames) {
      if (!sender_.controller().send(frame)) throw std::runtime_error("the queue is full");
      while (sender_.controller().queue().size() > 0 || bus_.next_event() != slaves::can::kNever) {
        bus_.advance(bus_.next_event());
      }
    }
  }
  [[nodiscard]] slaves::can::Bus& bus() { return bus_; }
  [[nodiscard]] std::uint64_t received() const { return takers_.back().received(); }

 private:
  slaves::can::Bus bus_;
  Taker sender_;
  std::vector<Taker> takers_;
};

Frame any_frame(std::mt19937_64& random, std::size_t length) {
  std::array<std::byte, 8> data{};
  for (auto& byte : data) byte = static_cast<std::byte>(random());
  return Frame::of(static_cast<std::uint32_t>(random() % 0x800), std::span(data).first(length));
}

/// Bits of a base data frame on the wire, with the interframe space, by a way that shares nothing with the codec: the
/// frame as a text of 0 and 1, the CRC by long division, a bit behind five equal ones.
std::size_t bits_by_hand(const Frame& frame) {
  std::string bits = "0";
  const auto add = [&bits](unsigned value, int count) {
    while (count-- > 0) bits += (value >> static_cast<unsigned>(count) & 1U) != 0 ? '1' : '0';
  };
  add(frame.identifier.value, 11);
  add(0, 3);
  add(frame.length, 4);
  for (const std::byte byte : frame.payload()) add(std::to_integer<unsigned>(byte), 8);
  const std::string divisor = "1100010110011001";  // x^15 + x^14 + x^10 + x^8 + x^7 + x^4 + x^3 + 1
  std::string rest = bits + std::string(15, '0');
  for (std::size_t i = 0; i + divisor.size() <= rest.size(); ++i) {
    if (rest[i] == '0') continue;
    for (std::size_t j = 0; j < divisor.size(); ++j) rest[i + j] = rest[i + j] == divisor[j] ? '0' : '1';
  }
  bits += rest.substr(rest.size() - 15);
  std::string stuffed;
  for (const char bit : bits) {
    stuffed += bit;
    const auto size = stuffed.size();
    const bool five = size >= 5 && stuffed.find_first_not_of(bit, size - 5) == std::string::npos;
    if (five) stuffed += bit == '0' ? '1' : '0';
  }
  return stuffed.size() + 1 + 2 + 7 + 3;
}

/// Load of the bus against the arithmetic. Throws if they differ by a bit.
void check_load(Report& report, int frames) {
  EightTakers line;
  std::mt19937_64 random(1);
  std::size_t expected = 0;
  const auto before = line.bus().statistics().busy;
  for (int i = 0; i < frames; ++i) {
    const Frame frame = any_frame(random, static_cast<std::size_t>(i % 9));
    expected += bits_by_hand(frame);
    line.pass({&frame, 1});
  }
  const auto measured = static_cast<std::size_t>((line.bus().statistics().busy - before) / 1us);  // at 1 Mbit/s
  if (measured != expected) {
    throw std::runtime_error(fmt::format("the bus was busy for {} bits, {} are right", measured, expected));
  }
  report.add({"bus_load", "bits_off_the_arithmetic", "bit", one(0.0), 0.0});
}

/// A frame through the bus, and its CRC and stuff bits, bit by bit, and eight copies alone, by turns.
void measure_frames(Report& report, int frames) {
  EightTakers line;
  std::mt19937_64 random(2);
  TurnSamples through;
  TurnSamples alone;
  std::vector<double> of_bus;
  std::vector<double> of_floor;
  Rests rests;
  std::array<Frame, kReceivers> copies{};
  std::uint64_t sent = 0;
  for (int done = 0; done < frames; done += static_cast<int>(kFramesPerTurn)) {
    rests.take_when_due(now_ns());
    std::vector<Frame> some;
    for (std::size_t i = 0; i < kFramesPerTurn; ++i) some.push_back(any_frame(random, 8));
    const double begin = now_ns();
    line.pass(some);
    const double passed = now_ns();
    std::size_t bits = 0;
    for (const Frame& frame : some) {
      const canopen::FrameBits content(frame);
      bits += content.size() + content.stuff_bits();
      for (Frame& copy : copies) {
        copy = frame;
        keep(copy);
      }
    }
    keep(bits);
    const double end = now_ns();
    of_bus.push_back((passed - begin - reading_cost_ns()) / kFramesPerTurn);
    of_floor.push_back((end - passed - reading_cost_ns()) / kFramesPerTurn);
    sent += kFramesPerTurn;
    if (of_bus.size() < 20) continue;
    through.add_turn(std::exchange(of_bus, {}));
    alone.add_turn(std::exchange(of_floor, {}));
  }
  if (line.received() != sent) throw std::runtime_error("a frame did not arrive");
  const Baseline floor{"crc_stuff_bits_and_copies", summarize(alone.all()),
                       ratios_by_turn(through.medians(), alone.medians())};
  report.add({"frame_to_8_nodes", "cost", "ns", summarize(through.all()), kFrameAim * floor.figures.p50, floor});
}

/// Front ends of eight drives per SYNC, against the drives with their plants in the same 2 ms.
void measure_front_ends(Report& report, int cycles) {
  CanFrontEnds line;
  TurnSamples drive;
  TurnSamples own;
  TurnSamples all;
  std::vector<double> of_drive;
  std::vector<double> of_own;
  std::vector<double> of_all;
  Rests rests;
  for (int i = 0; i < cycles; ++i) {
    rests.take_when_due(now_ns());
    const auto cost = line.cycle();
    of_drive.push_back(cost.drive);
    of_own.push_back(cost.own_frames);
    of_all.push_back(cost.own_frames + cost.frames_of_others);
    if (of_drive.size() < 100) continue;
    drive.add_turn(std::exchange(of_drive, {}));
    own.add_turn(std::exchange(of_own, {}));
    all.add_turn(std::exchange(of_all, {}));
  }
  line.check();
  const Summary floor = summarize(drive.all());
  const auto against = [&](const TurnSamples& samples) {
    return Baseline{"drive_and_plant", floor, ratios_by_turn(samples.medians(), drive.medians())};
  };
  report.add({"drive_and_plant", "cost_in_2_ms", "ns", floor});
  report.add({"front_end", "cost_per_sync", "ns", summarize(own.all()), kFrontEndAim * floor.p50, against(own)});
  report.add({"front_end_of_8_on_a_bus", "cost_per_sync", "ns", summarize(all.all()), std::nullopt, against(all)});
}

/// Time of an upload of 100 bytes against its frames and delays, in virtual time.
void measure_upload(Report& report) {
  constexpr auto kDelay = 500us;
  constexpr int kAnswers = 16;  // initiate and 15 segments
  slaves::can::Bus bus;
  CanMaster master(bus);
  MsdCanDrive drive({}, CanConnection{DipSwitch{12}, {}, kDelay});
  bus.attach(drive.device());
  bus.advance(20ms);
  const auto begin = bus.now();
  const auto busy = bus.statistics().busy;
  std::array<std::byte, 8> request{std::byte{0x40}, std::byte{0x03}, std::byte{0x20}};
  for (int i = 0; i < kAnswers; ++i) {
    static_cast<void>(master.ask(12, request));
    request = {i % 2 == 0 ? std::byte{0x60} : std::byte{0x70}};
  }
  const double on_the_bus = std::chrono::duration<double>(bus.statistics().busy - busy + kAnswers * kDelay).count();
  const double taken = std::chrono::duration<double>(master.answered_at() - begin).count();
  const double off_percent = 100.0 * std::abs(taken - on_the_bus) / on_the_bus;
  report.add({"upload_of_100_bytes", "time", "us", one(1e6 * taken)});
  report.add({"upload_of_100_bytes", "off_the_arithmetic", "%", one(off_percent), kUploadAimPercent});
}

/// What the MSD has on a bus beside its drive, which stores the values.
class BareNode final : public slaves::cia301::Application {
 public:
  BareNode(slaves::can::Bus& bus, std::uint8_t node) : node_(node) { bus.attach(device_); }

  [[nodiscard]] slaves::SdoResult<void> accept(const slaves::EntryRow& /*row*/, std::uint64_t /*raw*/) override {
    return {};
  }
  void written(const slaves::EntryRow& /*row*/) override {}
  [[nodiscard]] bool power_stage_on() const noexcept override { return false; }
  [[nodiscard]] std::uint8_t node_id(slaves::cia301::Reset /*reset*/) override { return node_; }

 private:
  static const slaves::DictionaryTable& table() {
    static const auto kRows = [] {
      auto rows = slaves::msd::can_rows(slaves::msd::Variant::kMsd);
      for (auto& row : rows) row.slot = slaves::slot::kOwn;
      return rows;
    }();
    static const slaves::DictionaryTable kTable({std::span<const slaves::EntryRow>(kRows)}, 0);
    return kTable;
  }

  std::uint8_t node_;
  slaves::ObjectDictionary dictionary_{table()};
  slaves::cia301::Device device_{dictionary_, *this, {.stores = false}};
};

/// Heap and size of an object on a bus, in KiB, averaged over many.
template <typename Make>
Summary can_state_kib(Make make) {
  constexpr std::size_t kMany = 100;
  slaves::can::Bus bus;
  const auto keep_shared_tables = make(bus, std::uint8_t{1});
  std::vector<decltype(make(bus, std::uint8_t{1}))> many;
  many.reserve(kMany);
  const auto before = heap_bytes();
  for (std::size_t i = 0; i < kMany; ++i) many.push_back(make(bus, static_cast<std::uint8_t>(i + 2)));
  return one(static_cast<double>(heap_bytes() - before) / static_cast<double>(kMany) / 1024.0);
}

struct AttachedDrive {
  AttachedDrive(slaves::can::Bus& bus, std::uint8_t node) : drive({}, CanConnection{DipSwitch{node}, {}, 500us}) {
    bus.attach(drive.device());
  }
  MsdCanDrive drive;
};

void measure_memory(Report& report) {
  report.add({"node_without_drive", "state", "KiB", can_state_kib([](slaves::can::Bus& bus, std::uint8_t node) {
                return std::make_unique<BareNode>(bus, node);
              }),
              kNodeAimKib});
  report.add({"msd", "state", "KiB", can_state_kib([](slaves::can::Bus& bus, std::uint8_t node) {
                return std::make_unique<AttachedDrive>(bus, node);
              }),
              kDriveAimKib});
}

/// A full bus between two clients of the slcan door. A lost frame is an error of the program.
void measure_full_bus(Report& report, double seconds) {
  const auto full = undisturbed("full bus", [&] {
    const SlcanLine line;
    auto carried = fill_bus(line.port(), std::chrono::duration<double>(seconds));
    if (carried.lost != 0 && carried.seconds > seconds + 5.0) throw Disturbed("frames stayed away for seconds");
    return carried;
  });
  report.add({"slcan_full_bus", "frames_lost", "1", one(static_cast<double>(full.lost)), 0.0});
  report.add({"slcan_full_bus", "frames_per_second", "1/s", one(static_cast<double>(full.sent) / full.seconds)});
  report.add({"slcan_full_bus", "load", "%", one(100.0 * full.bits / (1e6 * full.seconds))});
}

/// A command that the door answers by itself, against an echo of the same size, by turns.
void measure_round_trip(Report& report, int count) {
  constexpr int kPerTurn = 200;
  constexpr int kWarmUp = 20;
  const std::string answer = "V1013\r";
  const SlcanLine line;
  const TcpEcho echo(answer);
  TcpClient to_line(line.port());
  TcpClient to_echo(echo.port());
  TurnSamples of_line;
  TurnSamples of_echo;
  const auto turn = [&](TcpClient& client, TurnSamples& samples) {
    std::vector<double> some;
    for (int i = -kWarmUp; i < kPerTurn; ++i) {
      const double begin = now_ns();
      const auto got = client.exchange("V\r", answer.size());
      const double end = now_ns();
      if (got != answer) throw std::runtime_error("another answer than that to V");
      if (i >= 0) some.push_back(end - begin - reading_cost_ns());
    }
    samples.add_turn(some);
  };
  for (int done = 0; done < std::max(count, 2 * kPerTurn); done += kPerTurn) {
    turn(to_echo, of_echo);
    turn(to_line, of_line);
  }
  const Baseline floor{"tcp_echo", summarize(of_echo.all()), ratios_by_turn(of_line.medians(), of_echo.medians())};
  report.add({"tcp_echo", "round_trip", "ns", floor.figures});
  report.add({"slcan_command", "round_trip", "ns", summarize(of_line.all()), kRoundTripAim * floor.figures.p50, floor});
}

void measure_all(const Options& options) {
  Report report("can");
  // Before threads are there: the heap counts those of this one.
  measure_memory(report);
  check_load(report, options.count(kFrames) / 10);
  measure_upload(report);
  claim_cpu(std::max(0, last_cpu() - 1));
  measure_frames(report, options.count(kFrames));
  measure_front_ends(report, options.count(kCycles));
  measure_can_master(report, options.count(kCycles));
  undisturbed("SYNC", [&] { measure_sync(report, std::max(2, options.count(20)), options.duration(2.0, 0.5)); });
  measure_full_bus(report, options.duration(60.0, 20.0));
  undisturbed("round trip", [&] { measure_round_trip(report, options.count(kRoundTrips)); });
  report.note(
      "frame_to_8_nodes: from the sender's queue until eight nodes have it, against CRC, stuff bits and eight copies.\n"
      "front_end: SYNC, RxPDO, TxPDO and two milliseconds of it, against drive and plant in the same 2 ms, eight "
      "drives;\n"
      "of_8_on_a_bus: with the frames of the other seven drives. slcan: a line of eight drives, served in a thread.");
  report.print(options);
}

}  // namespace

int main(int argc, char** argv) {
  return run(argc, argv, "What do a CAN bus, CANopen front ends and the slcan door cost and carry?", measure_all);
}
