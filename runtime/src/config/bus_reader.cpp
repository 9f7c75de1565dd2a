#include "config/bus_reader.hpp"

#include <fmt/format.h>
#include <array>
#include <cmath>

#include "driveline/ecat_master/cyclic/acyclic_channel.hpp"
#include "driveline/rt/cycle_timer.hpp"
#include "toml/duration.hpp"

namespace driveline::runtime {
namespace {

/// Reads the time by which frames are handed to the kernel before they leave.
void read_launch_ahead(TomlReader& reader, LineConfig& config) {
  if (!reader.has("launch_ahead_us")) return;
  const double longest = static_cast<double>(rt::CycleTimer::max_wake_ahead(config.period).count()) / 1000.0;
  config.launch_ahead = from_us(reader.number("launch_ahead_us", 1.0, longest));
  if (config.port == port::PortChoice::kXdp)
    reader.fail("launch_ahead_us", "needs a packet socket: set port = \"raw\" or \"auto\"");
  if (config.interface2)
    reader.fail("launch_ahead_us", "cannot be used with interface2: both ends of a ring send at the same time");
}

}  // namespace

void read_max_lost(TomlReader& reader, LineConfig& config) {
  constexpr std::int64_t kMaxCycles = 10'000;
  const bool in_cycles = reader.has("max_lost_cycles");
  if (!reader.has("max_lost_ms")) {
    config.max_lost_cycles =
        static_cast<std::uint32_t>(reader.integer_or("max_lost_cycles", config.max_lost_cycles, 1, kMaxCycles));
    return;
  }
  if (in_cycles)
    reader.fail("max_lost_ms", "is set together with max_lost_cycles: both are the same limit, only one is expected");
  const double cycle_ms = std::chrono::duration<double, std::milli>(config.period).count();
  config.max_lost_ms = reader.number("max_lost_ms", cycle_ms, static_cast<double>(kMaxCycles) * cycle_ms);
  // Rounded down to whole cycles, so that it is never longer than the file says.
  config.max_lost_cycles = static_cast<std::uint32_t>(std::llround(*config.max_lost_ms * 1e6) / config.period.count());
}

void read_line_name(TomlReader& reader, LineConfig& config) {
  config.name = reader.text_or("name", config.name);
  if (config.name.empty() || config.name.size() > kMaxNameLength) reader.fail("name", kNameLengthText);
}

void read_line(TomlReader reader, LineConfig& config) {
  read_line_name(reader, config);
  config.period = from_us(reader.number_or("cycle_us", 125.0, 125.0, 100000.0));
  // MSD manual 9.1: the cycle time is a multiple of 125 us.
  if (config.period.count() % 125000 != 0)
    reader.fail("cycle_us", "must be a multiple of 125, the drives' process data cycle");
  reader.finish();
}

void read_bus(TomlReader reader, DeviceFiles& files, LineConfig& config) {
  static_cast<void>(reader.choice_or("type", 0, {"ethercat", "can"}));
  if (reader.has("esi")) config.esi_library = files.read_library(reader, "esi");
  if (reader.has("interface")) config.interface = reader.text("interface");
  if (reader.has("interface2")) config.interface2 = reader.text("interface2");
  if (config.interface2 && !config.interface) reader.fail("interface2", "needs interface, the other end of the ring");
  if (config.interface2 && *config.interface2 == *config.interface) {
    reader.fail("interface2",
                fmt::format("is \"{}\", the same as interface: a ring needs two interfaces", *config.interface2));
  }
  const auto port = reader.choice_or("port", 0, {"auto", "raw", "xdp"});
  config.port = std::array{port::PortChoice::kAuto, port::PortChoice::kRaw, port::PortChoice::kXdp}.at(port);
  read_launch_ahead(reader, config);
  read_max_lost(reader, config);
  if (reader.has("acyclic_bytes")) {
    config.acyclic_bytes =
        static_cast<std::size_t>(reader.integer("acyclic_bytes", 60, ecat_master::AcyclicChannel::kMaxBytes));
  }
  reader.finish();
}

void read_realtime(TomlReader reader, LineConfig& config) {
  auto& realtime = config.realtime;
  if (reader.has("policy")) {
    const bool enforce = reader.choice_or("policy", 0, {"enforce", "degrade"}) == 0;
    config.policy = enforce ? rt::RealtimePolicy::kEnforce : rt::RealtimePolicy::kDegrade;
  }
  realtime.priority = static_cast<int>(reader.integer_or("priority", 80, 1, 99));
  if (reader.has("cpu")) realtime.cpu = static_cast<int>(reader.integer("cpu", 0, 1023));
  if (reader.has("simulation_cpu")) config.simulation_cpu = static_cast<int>(reader.integer("simulation_cpu", 0, 1023));
  realtime.lock_memory = reader.boolean_or("lock_memory", true);
  constexpr std::int64_t kLongestLatencyUs = 1'000'000;
  const auto latency_us = reader.integer_or("cpu_latency_us", 0, -1, kLongestLatencyUs);
  realtime.cpu_latency = latency_us < 0 ? std::nullopt : std::optional(std::chrono::microseconds{latency_us});
  using Receive = ecat_master::ReceiveStrategy;
  const auto receive = reader.choice_or("receive", 0, {"spin", "sleep", "block"});
  config.receive = std::array{Receive::kSpin, Receive::kSleep, Receive::kBlock}.at(receive);
  const double longest = static_cast<double>(rt::CycleTimer::max_wake_ahead(config.period).count()) / 1000.0;
  if (reader.is_text("wake_ahead_us")) {
    const auto word = reader.text("wake_ahead_us");
    if (word != "auto")
      reader.fail("wake_ahead_us", fmt::format("is \"{}\", \"auto\" or 0 to {:g} is expected", word, longest));
  } else if (reader.has("wake_ahead_us")) {
    config.wake_ahead = from_us(reader.number("wake_ahead_us", 0.0, longest));
  }
  reader.finish();
}

}  // namespace driveline::runtime
