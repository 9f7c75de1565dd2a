#include <gmock/gmock.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <atomic>
#include <cmath>
#include <cstdio>
#include <nlohmann/json.hpp>
#include <numbers>
#include <stdexcept>
#include <string>
#include <thread>

#include "driveline/bridge/dds_publisher.hpp"
#include "driveline/snapshot/drain_thread.hpp"
#include "support/dds_domain.hpp"
#include "support/must.hpp"

// The publisher in this process, another DDS implementation (Cyclone DDS, `cyclone_subscriber`) in its own process.
namespace driveline::bridge {
namespace {

using namespace std::chrono_literals;
using nlohmann::json;
using snapshot::AxisSample;
using snapshot::AxisState;
using snapshot::LineSample;
using test::test_domain;

constexpr std::uint16_t kAxes = 8;
constexpr std::int64_t kCycleNs = 125'000;

/// Amplitude of each axis in rad; the phase distinguishes the axes.
double amplitude_rad(std::uint16_t axis) {
  return 0.5 + axis;
}

/// A drive on a sine, following with a constant lag of 1 mrad.
AxisSample moving_axis(std::uint64_t cycle, std::uint16_t axis) {
  const double phase = 2.0 * std::numbers::pi * static_cast<double>(cycle) / 800.0 + 0.3 * axis;
  const double position = amplitude_rad(axis) * std::sin(phase);
  const double velocity = amplitude_rad(axis) * std::cos(phase) * 2.0 * std::numbers::pi / (800.0 * kCycleNs * 1e-9);
  return {.cycle = cycle,
          .time_ns = static_cast<std::int64_t>(cycle) * kCycleNs,
          .axis = axis,
          .control_word = 0x000F,
          .status_word = 0x1637,
          .mode = 8,
          .state = AxisState::kOperationEnabled,
          .plcopen_state = snapshot::SampledPlcopenState::kContinuousMotion,
          .homed = snapshot::AxisHomed::kYes,
          .error_code = 0x8611,
          .digital_inputs = 0x8000'0000 + axis,
          .target_position = position,
          .actual_position = position - 0.001,
          .target_velocity = velocity,
          .actual_velocity = velocity,
          .target_torque = 0.25 * axis,
          .actual_torque = -0.25 * axis,
          .following_error = 0.001,
          .drive_following_error = 0.25 * axis,
          .demand_position = position + 0.0625,
          .demand_velocity = velocity + 0.125,
          .demand_torque = 0.75 * axis};
}

LineSample moving_line(std::uint64_t cycle) {
  LineSample line;
  line.cycle = cycle;
  line.time_ns = static_cast<std::int64_t>(cycle) * kCycleNs;
  line.dc_difference_ns = -42;
  line.axes = kAxes;
  line.frame_received = true;
  line.dc_locked = true;
  return line;
}

DdsConfig line_config(std::uint32_t domain) {
  DdsConfig config;
  config.domain_id = domain;
  config.line_name = "synthetic \"line\"";
  for (std::uint16_t axis = 0; axis < kAxes; ++axis) {
    config.axes.push_back({.name = "axis" + std::to_string(axis)});
  }
  config.axes[7].kind = AxisKind::kLinear;
  config.status_period = 20ms;
  config.ros2 = true;
  config.cycle_period = std::chrono::nanoseconds{kCycleNs};
  return config;
}

struct ProcessResult {
  int exit_status = -1;
  std::string output;
};

ProcessResult run(const std::string& command) {
  ProcessResult result;
  FILE* pipe = popen(command.c_str(), "r");  // the command contains no foreign text
  if (pipe == nullptr) {
    return result;
  }
  std::array<char, 4096> buffer{};
  for (std::size_t count = 0; (count = fread(buffer.data(), 1, buffer.size(), pipe)) != 0;) {
    result.output.append(buffer.data(), count);
  }
  const int status = pclose(pipe);
  result.exit_status = WIFEXITED(status) ? WEXITSTATUS(status) : -1;
  return result;
}

ProcessResult run_subscriber(std::uint32_t domain, int min_samples, int timeout_s) {
  // `timeout` is for a subscriber that ignores its own limit.
  return run("timeout -k 5 " + std::to_string(timeout_s + 20) + " " CYCLONE_SUBSCRIBER " " + std::to_string(domain) +
             " " + std::to_string(min_samples) + " " + std::to_string(timeout_s));
}

/// Replaces the real-time cycle: fills the rings until it is stopped.
class SyntheticLine {
 public:
  explicit SyntheticLine(std::uint32_t domain) {
    auto publisher = DdsPublisher::create(line_config(domain));
    if (!publisher) {
      throw std::runtime_error(describe(publisher.error()));
    }
    publisher_ = *std::move(publisher);
    publisher_->set_line_status({.state = snapshot::LineState::kOp,
                                 .cycle_period = std::chrono::nanoseconds{kCycleNs},
                                 .cycles = 123'456,
                                 .missed_periods = 1,
                                 .wkc_errors = 2,
                                 .lost_frames = 3,
                                 .wake_latency = {.p50 = 4us, .p99 = 9us, .max = 31us},
                                 .cycle_cost = {.p50 = 12us, .p99 = 15us, .max = 60us},
                                 .faults = {"axis3: following error", "a \"quoted\" fault"}});
    publisher_->event({.number = 41, .wall_time_ns = 1'700'000'000'000'000'123, .text = "slave 3 (z): back in OP"});
    publisher_->event({.number = 42, .severity = DdsEventSeverity::kFailure, .text = std::string(600, 'x')});
    drain_ = std::make_unique<snapshot::DrainThread>(lines_, axes_,
                                                     std::vector<snapshot::SampleConsumer*>{publisher_.get()});
    if (auto started = drain_->start(); !started) {
      throw std::runtime_error(describe(started.error()));
    }
    cycle_thread_ = std::thread{[this] { cycle(); }};
  }
  ~SyntheticLine() {
    running_ = false;
    cycle_thread_.join();
    drain_->stop();
  }
  SyntheticLine(const SyntheticLine&) = delete;
  SyntheticLine& operator=(const SyntheticLine&) = delete;

  std::uint64_t published() const { return publisher_->counters().published; }

 private:
  void cycle() {
    for (std::uint64_t cycle = 0; running_; ++cycle) {
      lines_.try_push(moving_line(cycle));
      for (std::uint16_t axis = 0; axis < kAxes; ++axis) {
        axes_.try_push(moving_axis(cycle, axis));
      }
      std::this_thread::sleep_for(std::chrono::nanoseconds{kCycleNs});
    }
  }

  rt::SpscRing<LineSample> lines_{16'384};
  rt::SpscRing<AxisSample> axes_{131'072};
  std::unique_ptr<DdsPublisher> publisher_;
  std::unique_ptr<snapshot::DrainThread> drain_;
  std::atomic<bool> running_{true};
  std::thread cycle_thread_;
};

void expect_moving_axis(const json& axis, std::uint16_t index, int min_samples) {
  SCOPED_TRACE(axis.dump());
  EXPECT_EQ(axis["axis"], index);
  EXPECT_EQ(axis["name"], "axis" + std::to_string(index));
  EXPECT_EQ(axis["kind"], index == 7 ? "linear" : "rotary");
  EXPECT_GE(axis["samples"], min_samples);
  EXPECT_EQ(axis["backward"], 0) << "samples of an axis come in the order of the cycles";
  EXPECT_LT(axis["actual_position_min"], axis["actual_position_max"]);
  EXPECT_GE(axis["actual_position_min"], -amplitude_rad(index) - 0.001);
  EXPECT_LE(axis["actual_position_max"], amplitude_rad(index) - 0.001);
  EXPECT_EQ(axis["following_error_max"], 0.001);

  // The last sample must be bit-identical to the one of the line in that cycle.
  const json& last = axis["last"];
  const std::uint64_t cycle = last["cycle"];
  EXPECT_EQ(cycle % 8, 0U);
  const AxisSample sent = moving_axis(cycle, index);
  EXPECT_EQ(last["time_ns"], sent.time_ns);
  EXPECT_EQ(last["control_word"], 0x000F);
  EXPECT_EQ(last["status_word"], 0x1637);
  EXPECT_EQ(last["mode"], 8);
  EXPECT_EQ(last["state"], "OPERATION_ENABLED");
  EXPECT_EQ(last["target_position"], sent.target_position);
  EXPECT_EQ(last["actual_position"], sent.actual_position);
  EXPECT_EQ(last["target_velocity"], sent.target_velocity);
  EXPECT_EQ(last["actual_velocity"], sent.actual_velocity);
  EXPECT_EQ(last["target_torque"], sent.target_torque);
  EXPECT_EQ(last["actual_torque"], sent.actual_torque);
  EXPECT_EQ(last["following_error"], sent.following_error);
}

void expect_line_in_op(const json& status, std::uint64_t published) {
  SCOPED_TRACE(status.dump());
  EXPECT_EQ(status["name"], "synthetic \"line\"");
  EXPECT_EQ(status["state"], "OP");
  EXPECT_EQ(status["axes"], kAxes);
  EXPECT_EQ(status["cycle_period_ns"], kCycleNs);
  EXPECT_GT(status["cycle"], 0);
  EXPECT_EQ(status["time_ns"], status["cycle"].get<std::int64_t>() * kCycleNs);
  EXPECT_EQ(status["dc_locked"], true);
  EXPECT_EQ(status["dc_difference_ns"], -42);
  EXPECT_EQ(status["cycles"], 123'456);
  EXPECT_EQ(status["missed_periods"], 1);
  EXPECT_EQ(status["wkc_errors"], 2);
  EXPECT_EQ(status["lost_frames"], 3);
  EXPECT_EQ(status["wake_latency_ns"], json({{"p50", 4000}, {"p99", 9000}, {"max", 31'000}}));
  EXPECT_EQ(status["cycle_cost_ns"], json({{"p50", 12'000}, {"p99", 15'000}, {"max", 60'000}}));
  EXPECT_GT(status["telemetry"]["published"], 0);
  EXPECT_LE(status["telemetry"]["published"], published);
  EXPECT_EQ(status["telemetry"]["dropped"], 0);
  EXPECT_EQ(status["faults"], json({"axis3: following error", "a \"quoted\" fault"}));
}

TEST(DdsInterop, CycloneReadsBothTopicsWithEveryValue) {
  constexpr int kMinSamples = 50;
  const std::uint32_t domain = test_domain();
  SyntheticLine line{domain};
  const ProcessResult subscriber = run_subscriber(domain, kMinSamples, 60);
  ASSERT_EQ(subscriber.exit_status, 0) << subscriber.output;
  const json got = json::parse(subscriber.output);
  EXPECT_EQ(got["complete"], true);
  EXPECT_EQ(got["unknown_axes"], 0);
  EXPECT_GE(got["line_statuses"], kMinSamples);
  ASSERT_EQ(got["axes"].size(), kAxes);
  for (std::uint16_t axis = 0; axis < kAxes; ++axis) {
    expect_moving_axis(got["axes"][axis], axis, kMinSamples);
  }
  expect_line_in_op(got["line_status"], line.published());
}

/// A row of the subscriber's document: index of the cycle, axis, words, mode, state, values.
json row_of(const AxisSample& sample, std::size_t cycle_index) {
  return {cycle_index,
          sample.axis,
          sample.control_word,
          sample.status_word,
          sample.mode,
          static_cast<int>(sample.state),
          sample.target_position,
          sample.actual_position,
          sample.target_velocity,
          sample.actual_velocity,
          sample.target_torque,
          sample.actual_torque,
          sample.following_error,
          sample.drive_following_error,
          sample.demand_position,
          sample.demand_velocity,
          sample.demand_torque,
          sample.digital_inputs,
          static_cast<int>(sample.plcopen_state)};
}

TEST(DdsInterop, CycloneReadsBatchesOfEveryCycleAndEvents) {
  constexpr int kBatches = 50;
  const std::uint32_t domain = test_domain();
  const SyntheticLine line{domain};
  const auto before = std::chrono::system_clock::now().time_since_epoch();
  const ProcessResult subscriber =
      run("timeout -k 5 80 " CYCLONE_BATCHES " " + std::to_string(domain) + " " + std::to_string(kBatches) + " 60");
  ASSERT_EQ(subscriber.exit_status, 0) << subscriber.output;
  const json got = json::parse(subscriber.output);
  EXPECT_GE(got["batches"], kBatches);
  const json& last = got["last"];
  EXPECT_EQ(last["cycle_period_ns"], kCycleNs);
  EXPECT_EQ(last["axes"], kAxes);
  ASSERT_EQ(last["cycles"].size(), 8U) << "a millisecond";
  ASSERT_EQ(last["samples"].size(), 8U * kAxes);
  const std::uint64_t first = last["cycles"][0][0];
  EXPECT_EQ(first % 8, 0U);
  for (std::size_t i = 0; i < 8; ++i) {
    const json& time = last["cycles"][i];
    EXPECT_EQ(time[0], first + i);
    EXPECT_EQ(time[1], static_cast<std::int64_t>(first + i) * kCycleNs);
    for (std::uint16_t axis = 0; axis < kAxes; ++axis) {
      EXPECT_EQ(last["samples"][i * kAxes + axis], row_of(moving_axis(first + i, axis), i)) << i << " " << axis;
    }
  }
  // The times that start with 0 here are on the monotonic clock in a run: 0 is the start of the machine.
  const auto up = std::chrono::steady_clock::now().time_since_epoch();
  const std::int64_t wall = last["cycles"][0][2].get<std::int64_t>() - last["cycles"][0][1].get<std::int64_t>();
  EXPECT_NEAR(static_cast<double>(wall), static_cast<double>(std::chrono::nanoseconds{before - up}.count()), 60e9);
  ASSERT_EQ(got["events"].size(), 2U) << "also for who comes late";
  EXPECT_EQ(got["events"][0], json({{"number", 41},
                                    {"wall_time_ns", 1'700'000'000'000'000'123},
                                    {"severity", "NOTICE"},
                                    {"text", "slave 3 (z): back in OP"}}));
  EXPECT_EQ(got["events"][1]["severity"], "FAILURE");
  EXPECT_EQ(got["events"][1]["text"], std::string(511, 'x'));
}

/// All of its times differ.
snapshot::TimeDistribution times_of(std::int64_t base) {
  return {.count = static_cast<std::uint64_t>(base),
          .p50_ns = base + 1,
          .p90_ns = base + 2,
          .p99_ns = base + 3,
          .p999_ns = base + 4,
          .max_ns = base + 5};
}

json to_json(const snapshot::TimeDistribution& times) {
  return {{"count", times.count},   {"p50_ns", times.p50_ns},   {"p90_ns", times.p90_ns},
          {"p99_ns", times.p99_ns}, {"p999_ns", times.p999_ns}, {"max_ns", times.max_ns}};
}

snapshot::CycleInterval interval_of(std::int64_t base) {
  return {.duration_ns = base + 100,
          .cycles = static_cast<std::uint64_t>(base) + 101,
          .missed_periods = static_cast<std::uint64_t>(base) + 102,
          .wkc_errors = static_cast<std::uint64_t>(base) + 103,
          .lost_frames = static_cast<std::uint64_t>(base) + 104,
          .wake_latency = times_of(base + 10),
          .cost = times_of(base + 20),
          .jitter = times_of(base + 30),
          .round_trip = times_of(base + 40),
          .dc_difference = times_of(base + 50)};
}

json to_json(const snapshot::CycleInterval& interval) {
  return {{"duration_ns", interval.duration_ns},        {"cycles", interval.cycles},
          {"missed_periods", interval.missed_periods},  {"wkc_errors", interval.wkc_errors},
          {"lost_frames", interval.lost_frames},        {"wake_latency", to_json(interval.wake_latency)},
          {"cycle_cost", to_json(interval.cost)},       {"jitter", to_json(interval.jitter)},
          {"round_trip", to_json(interval.round_trip)}, {"dc_difference", to_json(interval.dc_difference)}};
}

snapshot::FeedSlave slave_in_trouble() {
  snapshot::FeedSlave slave;
  slave.name.set("a \"quoted\" name");
  slave.device.set(std::string(63, 'd'));
  slave.al_text.set("sync manager watchdog");
  slave.vendor_id = 0xFFFF'0001;
  slave.product_code = 0xFFFF'0002;
  slave.revision = 0xFFFF'0003;
  slave.serial_number = 0xFFFF'0004;
  slave.station = 0x1002;
  slave.alias = 0xF00D;
  slave.al_status_code = 0x001B;
  slave.al_state = 4;
  slave.al_error = 1;
  slave.answers = 1;
  slave.hot_connect = 1;
  slave.processing_unit_errors = 254;
  slave.pdi_errors = 253;
  slave.clock = 2;
  slave.parent = 0;
  slave.parent_port = 3;
  slave.entry_port = 1;
  slave.depth = 1;
  slave.read_at_ns = 1'700'000'000'000'000'123;
  slave.clock_delay_ns = 640;
  slave.clock_difference_ns = 33;
  slave.sync0_cycle_ns = 250'000;
  for (std::uint8_t port = 0; port < 4; ++port) {
    const auto base = static_cast<std::uint8_t>(10 * port);
    slave.port[port] = {static_cast<std::uint8_t>(port % 2),
                        static_cast<std::uint8_t>(port / 2),
                        static_cast<std::uint8_t>(base + 1),
                        static_cast<std::uint8_t>(base + 2),
                        static_cast<std::uint8_t>(base + 3),
                        static_cast<std::uint8_t>(base + 4),
                        {}};
  }
  return slave;
}

json ports_in_trouble() {
  json ports;
  for (int port = 0; port < 4; ++port) {
    ports.push_back({{"link", port % 2 != 0},
                     {"open", port / 2 != 0},
                     {"invalid_frames", 10 * port + 1},
                     {"receive_errors", 10 * port + 2},
                     {"forwarded_errors", 10 * port + 3},
                     {"lost_links", 10 * port + 4}});
  }
  return ports;
}

json expected_slave_in_trouble() {
  return {{"position", 1},
          {"name", "a \"quoted\" name"},
          {"device", std::string(63, 'd')},
          {"vendor_id", 0xFFFF'0001},
          {"product_code", 0xFFFF'0002},
          {"revision", 0xFFFF'0003},
          {"serial_number", 0xFFFF'0004},
          {"station_address", 0x1002},
          {"alias", 0xF00D},
          {"hot_connect", true},
          {"answers", true},
          {"wall_time_ns", 1'700'000'000'000'000'123},
          {"state", "SAFE_OP"},
          {"error", true},
          {"al_status_code", 0x001B},
          {"al_status_text", "sync manager watchdog"},
          {"ports", ports_in_trouble()},
          {"processing_unit_errors", 254},
          {"pdi_errors", 253},
          {"dc_clock", true},
          {"dc_reference", true},
          {"dc_delay_ns", 640},
          {"dc_difference_max_ns", 33},
          {"dc_sync0_cycle_ns", 250'000}};
}

ProcessResult run_line_subscriber(std::uint32_t domain, int statistics, int timeout_s) {
  return run("timeout -k 5 " + std::to_string(timeout_s + 20) + " " CYCLONE_LINE " " + std::to_string(domain) + " " +
             std::to_string(statistics) + " " + std::to_string(timeout_s));
}

TEST(DdsInterop, CycloneReadsWhatChangesNowAndThenWithEveryField) {
  const std::uint32_t domain = test_domain();
  DdsConfig config = line_config(domain);
  config.slaves = 2;
  const auto publisher = must(DdsPublisher::create(config));
  snapshot::FeedCondition condition;
  condition.slaves = {{}, slave_in_trouble()};
  condition.slaves[0].parent = snapshot::kFeedParentMaster;
  condition.slaves[0].read_at_ns = 1;
  condition.head.ring_slave = 1;
  condition.head.ring_port = 2;
  condition.head.silent_ports = 2;
  condition.head.silent[0] = 3;
  condition.head.silent[1] = 5;
  condition.owners.resize(kAxes);
  condition.owners[7].name.set("control socket (process 123, user 1000)");
  (*publisher)->set_condition(condition);
  const auto sample = moving_axis(40, 7);
  (*publisher)->axes({&sample, 1});
  snapshot::LineStatus status;
  status.cycle_period = 125us;
  status.statistics = {.number = 17,
                       .time_ns = 123,
                       .cycle = 456,
                       .wall_time_ns = 789,
                       .dc_difference_ns = -42,
                       .dc_locked = 1,
                       .last = interval_of(1000),
                       .total = interval_of(2000)};
  (*publisher)->set_line_status(status);
  (*publisher)->pass_done({});

  // The subscriber starts late.
  const ProcessResult subscriber = run_line_subscriber(domain, 1, 60);
  ASSERT_EQ(subscriber.exit_status, 0) << subscriber.output;
  const json got = json::parse(subscriber.output);
  EXPECT_EQ(got["slave_messages"], 2);
  ASSERT_EQ(got["slaves"].size(), 2U);
  EXPECT_EQ(got["slaves"][0]["position"], 0);
  EXPECT_EQ(got["slaves"][0]["state"], "UNKNOWN");
  EXPECT_EQ(got["slaves"][1], expected_slave_in_trouble());
  ASSERT_EQ(got["axes"].size(), 1U) << "of the others nothing is known";
  auto axis = got["axes"][0];
  EXPECT_GT(axis["wall_time_ns"], sample.time_ns);
  axis.erase("wall_time_ns");
  EXPECT_EQ(axis, json({{"axis", 7},
                        {"name", "axis7"},
                        {"kind", "LINEAR"},
                        {"cycle", 40},
                        {"time_ns", sample.time_ns},
                        {"state", "OPERATION_ENABLED"},
                        {"plcopen_state", "CONTINUOUS_MOTION"},
                        {"mode", 8},
                        {"error_code", 0x8611},
                        {"owner", "control socket (process 123, user 1000)"},
                        {"homed", "YES"},
                        {"digital_inputs_mapped", true},
                        {"digital_inputs", 0x8000'0007}}));
  EXPECT_EQ(got["topology"], json({{"slaves", 2},
                                   {"nodes", {{0, -1, 0, 0, 0}, {1, 0, 3, 1, 1}}},
                                   {"ring_end", {{1, 2}}},
                                   {"silent_ports", {{0, 3}, {1, 1}}}}));
  EXPECT_EQ(got["statistics"], json({{"number", 17},
                                     {"cycle", 456},
                                     {"time_ns", 123},
                                     {"wall_time_ns", 789},
                                     {"cycle_period_ns", 125'000},
                                     {"dc_locked", true},
                                     {"dc_difference_ns", -42},
                                     {"last", to_json(interval_of(1000))},
                                     {"total", to_json(interval_of(2000))}}));
}

TEST(DdsInterop, CycloneReadsJointStatesAsARos2NodeDoes) {
  const std::uint32_t domain = test_domain();
  const SyntheticLine line{domain};
  const ProcessResult subscriber = run("timeout -k 5 80 " CYCLONE_JOINTS " " + std::to_string(domain) + " 5 60");
  ASSERT_EQ(subscriber.exit_status, 0) << subscriber.output;
  const json got = json::parse(subscriber.output);
  EXPECT_EQ(got["user_data"], "typehash=RIHS01_a13ee3a330e346c9d87b5aa18d24e11690752bd33a0350f11c5882bc9179260e;");
  EXPECT_EQ(got["frame_id"], "");
  EXPECT_LT(got["nanosec"], 1'000'000'000);
  ASSERT_EQ(got["name"].size(), kAxes);
  // The positions identify the cycle: all axes must match the same one, a multiple of 80.
  bool found = false;
  for (std::uint64_t cycle = 0; cycle < 800 && !found; cycle += 80) {
    found = true;
    for (std::uint16_t axis = 0; axis < kAxes; ++axis) {
      const AxisSample sent = moving_axis(cycle, axis);
      EXPECT_EQ(got["name"][axis], "axis" + std::to_string(axis));
      EXPECT_EQ(got["effort"][axis], sent.actual_torque);
      // The sine of a later period differs in its last bits.
      found = found && std::abs(got["position"][axis].get<double>() - sent.actual_position) < 1e-6 &&
              std::abs(got["velocity"][axis].get<double>() - sent.actual_velocity) < 1e-3;
    }
  }
  EXPECT_TRUE(found) << subscriber.output;
}

TEST(DdsInterop, CycloneReadsDiagnosticsAsARos2NodeDoes) {
  const std::uint32_t domain = test_domain();
  const SyntheticLine line{domain};
  const ProcessResult subscriber = run("timeout -k 5 80 " CYCLONE_DIAGNOSTICS " " + std::to_string(domain) + " 1 60");
  ASSERT_EQ(subscriber.exit_status, 0) << subscriber.output;
  const json got = json::parse(subscriber.output);
  EXPECT_EQ(got["user_data"], "typehash=RIHS01_5a8a36efb05fb25070fa0fb3810290c0e6cd4862b54a8fb975a1ee8dc55a333e;");
  EXPECT_EQ(got["frame_id"], "");
  EXPECT_GT(got["sec"], 1'700'000'000);
  ASSERT_EQ(got["status"].size(), 1U + kAxes);
  EXPECT_EQ(got["status"][0]["level"], 1);
  EXPECT_EQ(got["status"][0]["name"], "driveline synthetic \"line\": line");
  EXPECT_EQ(got["status"][0]["message"], "OP; a \"quoted\" fault");
  EXPECT_EQ(got["status"][0]["hardware_id"], "synthetic \"line\"");
  EXPECT_EQ(got["status"][0]["values"]["cycles"], "123456");
  EXPECT_EQ(got["status"][8]["message"], "ContinuousMotion, operation enabled");
  EXPECT_EQ(got["status"][8]["values"]["owner"], "");
}

TEST(DdsInterop, LateCycloneSubscriberGetsTheLastStatusOfASilentLine) {
  const std::uint32_t domain = test_domain();
  DdsConfig config = line_config(domain);
  config.axes.clear();
  config.status_period = 1h;
  const auto publisher = must(DdsPublisher::create(config));
  (*publisher)->set_line_status({.state = snapshot::LineState::kSafeOp, .cycles = 7});
  (*publisher)->pass_done({});

  const ProcessResult subscriber = run_subscriber(domain, 1, 60);
  ASSERT_EQ(subscriber.exit_status, 0) << subscriber.output;
  const json got = json::parse(subscriber.output);
  EXPECT_EQ(got["line_statuses"], 1);
  EXPECT_EQ(got["line_status"]["state"], "SAFE_OP");
  EXPECT_EQ(got["line_status"]["cycles"], 7);
  EXPECT_TRUE(got["axes"].empty());
}

TEST(DdsInterop, SubscriberReportsWhatIsMissing) {
  const ProcessResult subscriber = run_subscriber(test_domain(), 1, 1);  // there is no publisher
  EXPECT_EQ(subscriber.exit_status, 1);
  const json got = json::parse(subscriber.output);
  EXPECT_EQ(got["complete"], false);
  EXPECT_TRUE(got["line_status"].is_null());
}

}  // namespace
}  // namespace driveline::bridge
