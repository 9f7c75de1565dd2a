#include "config/can_bus_reader.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "config/bus_reader.hpp"
#include "config/can_restrictions.hpp"
#include "toml/duration.hpp"

namespace driveline::runtime {
namespace {

/// Longest name of a network interface in Linux (IFNAMSIZ without the end).
constexpr std::size_t kMaxInterfaceName = 15;
constexpr std::int64_t kLastNode = 127;
/// CanBusConfig::master_node while the slaves are read, if the file does not say it.
constexpr std::uint8_t kNodeToChoose = 0;
constexpr double kMaxCanCableM = 10'000.0;
constexpr std::chrono::milliseconds kStandardPeriod{2};
constexpr double kShortestPeriodUs = 250.0;
constexpr double kLongestPeriodUs = 100'000.0;

/// 1006h counts the period of SYNC in microseconds (CiA 301 7.5.2.6).
std::chrono::nanoseconds whole_microseconds(const TomlReader& reader, std::string_view key, double us) {
  const auto period = from_us(us);
  if (period.count() % 1000 != 0) reader.fail(key, "must be a whole number of microseconds, as 1006h has them");
  return period;
}

/// Reads the period of SYNC: [bus] sync_ms, or [line] cycle_us, which is the same for both buses.
std::chrono::nanoseconds read_period(TomlReader& line, TomlReader& bus) {
  std::chrono::nanoseconds period = kStandardPeriod;
  const bool cycle = line.has("cycle_us");
  if (cycle) {
    period = whole_microseconds(line, "cycle_us", line.number("cycle_us", kShortestPeriodUs, kLongestPeriodUs));
  }
  if (!bus.has("sync_ms")) return period;
  const auto ms = bus.number("sync_ms", kShortestPeriodUs / 1000.0, kLongestPeriodUs / 1000.0);
  const auto sync = whole_microseconds(bus, "sync_ms", 1000.0 * ms);
  if (cycle && sync != period) {
    bus.fail("sync_ms", fmt::format("is {} ms, but [line] cycle_us is {}: the cycle of a CAN line is its SYNC, and one "
                                    "period is expected",
                                    ms, period.count() / 1000));
  }
  return sync;
}

void read_interface(TomlReader& reader, LineConfig& config) {
  if (!reader.has("interface")) return;
  auto text = reader.text("interface");
  const bool name = text.find(':') == std::string::npos;
  if (text.empty() || (name && text.size() > kMaxInterfaceName)) {
    reader.fail("interface", fmt::format("must have 1 to {} characters, or name a protocol, as slcan:tcp:HOST:PORT",
                                         kMaxInterfaceName));
  }
  config.interface = std::move(text);
}

void read_bus_of_can(TomlReader& reader, LineConfig& config) {
  auto& can = *config.can;
  static_cast<void>(reader.choice_or("type", 1, {"ethercat", "can"}));
  refuse_ethercat_keys(reader, CanTable::kBus);
  read_interface(reader, config);
  can.bit_rate = static_cast<std::uint32_t>(reader.integer_or("bit_rate", can.bit_rate, 10'000, 1'000'000));
  if (1'000'000'000 % can.bit_rate != 0) {
    reader.fail("bit_rate", fmt::format("is {}, a rate whose bits are whole nanoseconds is expected", can.bit_rate));
  }
  auto& wiring = can.wiring;
  wiring.length_m = reader.number_or("length_m", wiring.length_m, 0.0, kMaxCanCableM);
  const auto ends = reader.choice_or("terminators", 0, {"both", "first", "last", "none"});
  wiring.first_terminated = ends <= 1;
  wiring.last_terminated = ends == 0 || ends == 2;
  can.seed = static_cast<std::uint64_t>(reader.integer_or("seed", 0, 0, INT64_MAX));
  read_max_lost(reader, config);
  reader.finish();
}

void read_can_master(TomlReader reader, CanBusConfig& can) {
  can.master_node =
      reader.has("node") ? static_cast<std::uint8_t>(reader.integer("node", 1, kLastNode)) : kNodeToChoose;
  can.master_heartbeat =
      std::chrono::milliseconds{reader.integer_or("heartbeat_ms", can.master_heartbeat.count(), 0, 65'535)};
  reader.finish();
}

}  // namespace

void read_can_line(TomlReader& root, LineConfig& config) {
  refuse_ethercat_keys(root, CanTable::kRoot);
  config.can.emplace();
  auto line = root.table("line");
  auto bus = root.table("bus");
  read_line_name(line, config);
  config.period = read_period(line, bus);
  line.finish();
  read_bus_of_can(bus, config);
  read_can_master(root.table("master"), *config.can);
}

void choose_master_node(const TomlReader& root, LineConfig& config) {
  auto& node = config.can->master_node;
  if (node != kNodeToChoose) return;
  const auto taken = [&config](std::uint8_t id) {
    return std::any_of(config.slaves.begin(), config.slaves.end(),
                       [id](const auto& slave) { return slave.can.node == id; });
  };
  node = kLastNode;
  while (node > 0 && taken(node)) --node;
  if (node == 0) root.fail("slave", "there are 127, and no node-ID is left for the master");
}

void read_can_faults(TomlReader& root, LineConfig& config) {
  std::vector<std::string> names;
  for (const auto& slave : config.slaves) names.push_back(slave.name);
  for (auto& reader : root.tables("fault")) config.can->faults.push_back(read_can_fault(std::move(reader), names));
}

}  // namespace driveline::runtime
