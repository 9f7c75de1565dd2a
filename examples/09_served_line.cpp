// A simulated line with a custom device: a water tank with a valve and a level sensor, which line descriptions select
// by model = "tank". A family defines its keys and its simulation; a single registration makes it available in any
// line.
//   09_served_line tank.toml            the line in this process, on virtual time: a task controls the level
//   09_served_line tank.toml eth1       serves the line on a network interface, to any EtherCAT master, until Ctrl-C

#include <algorithm>
#include <bit>
#include <chrono>
#include <cmath>
#include <csignal>
#include <cstdio>
#include <thread>

#include "driveline/esi/sii.hpp"
#include "driveline/port/raw_socket_port.hpp"
#include "driveline/runtime/line.hpp"
#include "driveline/runtime/served/line_server.hpp"

using namespace driveline;
using namespace std::chrono_literals;

namespace {

constexpr std::uint32_t kVendor = 0xE000'0001;  // not assigned by the ETG
constexpr std::uint32_t kProduct = 1;
constexpr std::uint16_t kOutputs = 0x1000;  // physical addresses of the process data
constexpr std::uint16_t kInputs = 0x1100;

volatile std::sig_atomic_t interrupted = 0;

/// The content of the device's EEPROM: two process data objects, no mailbox.
esi::DeviceDescription description(const runtime::DevicePlace& place) {
  using Use = esi::SyncManager::Use;
  esi::DeviceDescription device;
  device.vendor_id = kVendor;
  device.product_code = kProduct;
  device.serial_number = place.serial_number;
  device.name = "Tank";
  device.type = "TANK";
  device.fmmus = {esi::FmmuUse::kOutputs, esi::FmmuUse::kInputs};
  device.sync_managers = {
      {.use = Use::kOutputs, .start_address = kOutputs, .default_size = 2, .control = 0x64, .enable = true},
      {.use = Use::kInputs, .start_address = kInputs, .default_size = 4, .control = 0x20, .enable = true}};
  device.rx_pdos = {{.index = 0x1600,
                     .name = "Outputs",
                     .fixed = true,
                     .sync_manager = 0,
                     .entries = {{0x7000, 1, 16, "Valve", esi::DataType::kUnsigned16}}}};
  device.tx_pdos = {{.index = 0x1A00,
                     .name = "Inputs",
                     .fixed = true,
                     .sync_manager = 1,
                     .entries = {{0x6000, 1, 32, "Level", esi::DataType::kReal32}}}};
  device.eeprom_config_data_hex = "040D0000000000000000";
  return device;
}

slaves::DeviceProfile make_profile(const esi::DeviceDescription& device) {
  using Use = slaves::SyncManagerLayout::Use;
  slaves::DeviceProfile profile;
  profile.sii_image = esi::encode_sii(esi::make_sii(device));
  profile.sync_managers = {{.use = Use::kOutputs, .start_address = kOutputs, .default_length = 2},
                           {.use = Use::kInputs, .start_address = kInputs, .default_length = 4}};
  return profile;
}

/// Water flows in through the valve, and out through a hole.
class Tank final : public slaves::Device {
 public:
  Tank(const runtime::DevicePlace& place, double area_m2, double level_m)
      : profile_(make_profile(description(place))), area_(area_m2), level_(level_m) {}

  [[nodiscard]] const slaves::DeviceProfile& profile() const noexcept override { return profile_; }
  [[nodiscard]] std::size_t process_data_size(std::size_t sync_manager) const noexcept override {
    return sync_manager == 0 ? 2 : 4;
  }
  [[nodiscard]] wire::AlStatusCode transition(wire::AlState, wire::AlState) noexcept override {
    return wire::AlStatusCode::kNoError;
  }
  /// Closes the valve for any reason, because there is no master.
  void fall_back(wire::AlState, wire::AlState, wire::AlStatusCode) noexcept override { valve_ = 0.0; }
  void write_outputs(std::size_t, std::span<const std::byte> data) noexcept override {
    valve_ = std::min<double>(bytes::load_le<std::uint16_t>(data), 1000.0) / 1000.0;
  }
  void read_inputs(std::size_t, std::span<std::byte> data) noexcept override {
    bytes::store_le(data, std::bit_cast<std::uint32_t>(static_cast<float>(level_)));
  }
  /// Starts without outputs; no water flowed while the supply was off.
  void restart() override {
    valve_ = 0.0;
    last_.reset();
  }
  void mailbox_request(std::span<const std::byte>) override {}
  [[nodiscard]] std::size_t mailbox_reply(std::span<std::byte>) override { return 0; }
  void advance(std::chrono::nanoseconds now) noexcept override {
    const double passed_s = std::chrono::duration<double>(now - last_.value_or(now)).count();
    last_ = now;
    const double in = 0.004 * valve_;
    const double out = 0.0004 * std::sqrt(2.0 * 9.81 * level_);
    level_ = std::clamp(level_ + (in - out) / area_ * passed_s, 0.0, 2.0);
  }
  [[nodiscard]] std::chrono::nanoseconds process_data_period() const noexcept override { return 1ms; }

 private:
  slaves::DeviceProfile profile_;
  double area_;         // m^2
  double level_;        // m
  double valve_ = 0.0;  // 0 to 1
  std::optional<std::chrono::nanoseconds> last_;
};

/// The tank of a [[slave]], as configured in the line description.
class TankDevice final : public runtime::SlaveDevice {
 public:
  TankDevice(double area_m2, double level_m) : area_(area_m2), level_(level_m) {}
  [[nodiscard]] runtime::DeviceIdentity identity() const noexcept override { return {kVendor, kProduct}; }
  [[nodiscard]] std::unique_ptr<slaves::Device> simulate(const runtime::DevicePlace& place) const override {
    return std::make_unique<Tank>(place, area_, level_);
  }
  [[nodiscard]] std::string why_no_axis() const override { return "is a tank, an axis needs a drive"; }

 private:
  double area_;
  double level_;
};

class TankFamily final : public runtime::DeviceFamily {
 public:
  [[nodiscard]] std::string_view key() const noexcept override { return "tank"; }
  [[nodiscard]] std::vector<std::string_view> own_keys() const override { return {"area_m2", "level_m"}; }
  [[nodiscard]] std::shared_ptr<const runtime::SlaveDevice> read(const runtime::DeviceTable& table) const override {
    return std::make_shared<TankDevice>(table.keys.number("area_m2", 1e-3, 10.0),
                                        table.keys.number_or("level_m", 0.0, 0.0, 2.0));
  }
};

/// A PI controller: opens the valve in proportion to the missing level and its integral.
class KeepsLevel final : public runtime::Task {
 public:
  runtime::Result<void> prepare(const runtime::TaskSetup& setup) override {
    const auto valve = setup.process_data.entry<std::uint16_t>("tank.valve");
    const auto level = setup.process_data.entry<float>("tank.level");
    if (!valve || !level)
      return runtime::fail(runtime::ErrorKind::kSetting, describe(!valve ? valve.error() : level.error()));
    valve_ = *valve;
    level_ = *level;
    return {};
  }
  void update(const motion::TaskCycle& now) noexcept override {
    seen = level_.get(now.inputs);
    const double missing = kWanted - seen;
    sum_ = std::clamp(sum_ + missing * std::chrono::duration<double>(now.elapsed).count(), -2.0, 2.0);
    valve_.set(now.outputs, static_cast<std::uint16_t>(std::clamp(4000.0 * missing + 500.0 * sum_, 0.0, 1000.0)));
  }

  static constexpr double kWanted = 0.5;  // m
  double seen = 0.0;

 private:
  motion::PdoEntry<std::uint16_t> valve_;
  motion::PdoEntry<float> level_;
  double sum_ = 0.0;
};

int fail(const std::string& sentence) {
  std::fprintf(stderr, "09_served_line: %s\n", sentence.c_str());
  return 1;
}

int run_here(const char* file, const runtime::DeviceRegistry& devices) {
  runtime::Line::Options options;
  options.virtual_time = true;
  options.devices = devices;
  const auto line = runtime::Line::from_file(file, options);
  if (!line) return fail(runtime::describe(line.error()));
  KeepsLevel keeps;
  if (auto added = (*line)->add(keeps, {.name = "level", .timing = {.divider = 10}, .drives = {}}); !added)
    return fail(runtime::describe(added.error()));
  const auto report = (*line)->run({.duration_s = 60.0, .force = false});
  if (!report) return fail(runtime::describe(report.error()));
  std::printf("the level is %.3f m after a minute, %.3f m are wanted\n", keeps.seen, KeepsLevel::kWanted);
  return report->failure() == nullptr ? 0 : fail(runtime::describe(*report->failure()));
}

int serve(const char* file, const char* interface, const runtime::DeviceRegistry& devices) {
  const auto config = runtime::load_line_config(file, devices);
  if (!config) return fail(runtime::describe(config.error()));
  rt::MonotonicClock clock;
  port::RawSocketConfig socket;
  socket.interface = interface;
  socket.arrival_times = true;
  const auto port = port::RawSocketPort::open(socket, clock);
  if (!port) return fail(port::describe(port.error()));
  const auto line = runtime::make_simulated_line(*config, clock, false);
  runtime::LineServer server(*line, **port, clock);
  auto realtime = config->realtime;
  realtime.policy = rt::RealtimePolicy::kDegrade;
  rt::RealtimeThread thread;
  if (const auto started = thread.start(realtime, server); !started) return fail(rt::describe(started.error()));
  std::fprintf(stderr, "%zu slaves on %s; Ctrl-C ends\n", line->size(), interface);
  while (interrupted == 0) std::this_thread::sleep_for(20ms);
  thread.request_stop();
  thread.join();
  std::printf("%llu frames served\n", static_cast<unsigned long long>(server.frames()));
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc < 2 || argc > 3) {
    std::fputs("usage: 09_served_line FILE [INTERFACE]\n", stderr);
    return 2;
  }
  for (const int number : {SIGINT, SIGTERM}) std::signal(number, [](int) { interrupted = 1; });
  runtime::DeviceRegistry devices;
  if (auto added = devices.add(std::make_shared<TankFamily>()); !added) return fail(runtime::describe(added.error()));
  return argc == 2 ? run_here(argv[1], devices) : serve(argv[1], argv[2], devices);
}
