#include "config/slave_plan_reader.hpp"

#include <fmt/format.h>

#include <array>
#include <charconv>
#include <cmath>

#include "driveline/motion/axis/startup_sdos.hpp"
#include "driveline/motion/drive/drive_objects.hpp"
#include "driveline/runtime/config/typed_value.hpp"

namespace driveline::runtime {
namespace {

using ecat_master::IdentityRule;

/// Parses a number, decimal or hexadecimal with 0x.
std::optional<std::uint64_t> parse_number(std::string_view text, std::uint64_t maximum) {
  int base = 10;
  if (text.starts_with("0x") || text.starts_with("0X")) {
    base = 16;
    text.remove_prefix(2);
  }
  std::uint64_t value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value, base);
  if (error != std::errc{} || end != text.data() + text.size() || value > maximum) return std::nullopt;
  return value;
}

std::string_view trimmed(std::string_view text) {
  while (text.starts_with(' ')) text.remove_prefix(1);
  while (text.ends_with(' ')) text.remove_suffix(1);
  return text;
}

IdentityRule read_rule(TomlReader& reader, std::string_view key) {
  if (!reader.has(key)) return {};
  if (!reader.is_text(key)) return IdentityRule::equal(static_cast<std::uint32_t>(reader.integer(key, 0, 0xFFFFFFFF)));
  const auto text = reader.text(key);
  auto number = trimmed(text);
  if (number == "any") return {};
  const bool at_least = number.starts_with(">=");
  if (at_least) number = trimmed(number.substr(2));
  if (!at_least && number.starts_with('=')) number = trimmed(number.substr(1));
  const auto value = parse_number(number, 0xFFFFFFFF);
  if (!value) reader.fail(key, fmt::format("is \"{}\", expected a number, \">= number\" or \"any\"", text));
  const auto raw = static_cast<std::uint32_t>(*value);
  return at_least ? IdentityRule::at_least(raw) : IdentityRule::equal(raw);
}

std::optional<std::uint16_t> read_name_number(TomlReader& reader, std::string_view key) {
  if (!reader.has(key)) return std::nullopt;
  return static_cast<std::uint16_t>(reader.integer(key, 1, 0xFFFF));
}

/// Reads a watchdog time as increments of 100 us, the unit after power-on: divider 2498 (ETG.1000.4 6.3).
std::optional<std::uint16_t> read_watchdog(TomlReader& reader, std::string_view key) {
  constexpr double kIncrementsPerMs = 10.0;
  constexpr double kLongestMs = 6553.5;
  if (!reader.has(key)) return std::nullopt;
  return static_cast<std::uint16_t>(std::lround(reader.number(key, 0.0, kLongestMs) * kIncrementsPerMs));
}

ecat_master::WatchdogPlan read_watchdogs(TomlReader reader) {
  constexpr std::uint16_t kDivider = 2498;
  ecat_master::WatchdogPlan plan;
  plan.process_data = read_watchdog(reader, "process_data_ms");
  plan.pdi = read_watchdog(reader, "pdi_ms");
  if (plan.process_data || plan.pdi) plan.divider = kDivider;
  reader.finish();
  return plan;
}

ecat_master::StateTimeouts read_timeouts(TomlReader reader, ecat_master::MailboxTimeouts& mailbox) {
  ecat_master::StateTimeouts timeouts;
  auto read = [&reader](std::string_view key, auto& limit, std::int64_t shortest_ms = 1) {
    constexpr std::int64_t kLongestMs = 600'000;
    if (reader.has(key)) limit = std::chrono::milliseconds{reader.integer(key, shortest_ms, kLongestMs)};
  };
  read("preop_ms", timeouts.to_pre_op);
  read("safeop_ms", timeouts.to_safe_op);
  read("op_ms", timeouts.to_op);
  read("back_to_init_ms", timeouts.back_to_init);
  read("back_to_safeop_ms", timeouts.back_to_safe_op);
  read("mailbox_request_ms", mailbox.request);
  read("mailbox_response_ms", mailbox.response);
  read("mailbox_repeat_ms", mailbox.repeat, 0);
  reader.finish();
  return timeouts;
}

/// Reads the time for SAFEOP and OP that applies where [slave.timeouts] has none.
void read_state_timeout(TomlReader& slave, ecat_master::StateTimeouts& timeouts) {
  constexpr std::int64_t kLongestMs = 600'000;
  if (!slave.has("state_timeout_ms")) return;
  const std::chrono::milliseconds limit{slave.integer("state_timeout_ms", 1, kLongestMs)};
  if (!timeouts.to_safe_op) timeouts.to_safe_op = limit;
  if (!timeouts.to_op) timeouts.to_op = limit;
}

motion::WriteNeed read_need(TomlReader& reader, std::string_view key) {
  using motion::WriteNeed;
  constexpr std::array kNeeds{WriteNeed::kMandatory, WriteNeed::kOptional, WriteNeed::kOmitted};
  return kNeeds.at(reader.choice_or(key, 1, {"mandatory", "optional", "omit"}));
}

void read_startup(TomlReader reader, SlavePlanConfig& config) {
  config.needs.sync_objects = read_need(reader, "sync_objects");
  config.needs.pdo_assignment = read_need(reader, "pdo_assignment");
  config.needs.pdo_mapping = read_need(reader, "pdo_mapping");
  config.interpolation_time = read_need(reader, "interpolation_time");
  auto& retries = config.safe_op_retries;
  constexpr std::int64_t kMostRetries = 100;
  retries.count = static_cast<unsigned>(reader.integer_or("safeop_retries", retries.count, 0, kMostRetries));
  reader.finish();
}

/// Reads bytes in wire order: "0A 00".
std::vector<std::byte> read_bytes(TomlReader& reader, std::string_view key) {
  const auto text = reader.text(key);
  std::vector<std::byte> bytes;
  std::string_view rest = trimmed(text);
  while (!rest.empty()) {
    const auto digits = rest.substr(0, 2);
    const auto byte = digits.size() == 2 ? parse_number("0x" + std::string(digits), 0xFF) : std::nullopt;
    if (!byte) reader.fail(key, fmt::format("is \"{}\", expected bytes in hexadecimal like \"0A 00\"", text));
    bytes.push_back(static_cast<std::byte>(*byte));
    rest = trimmed(rest.substr(2));
  }
  return bytes;
}

void read_pdo(TomlReader reader, motion::PdoConfiguration& configuration) {
  motion::PdoMapping pdo;
  pdo.index = static_cast<std::uint16_t>(reader.integer("index", 0x1600, 0x1BFF));
  const bool input_range = pdo.index >= 0x1A00;
  const bool input = reader.choice_or("direction", input_range ? 1 : 0, {"out", "in"}) == 1;
  if (reader.has("sync_manager")) pdo.sync_manager = static_cast<std::uint8_t>(reader.integer("sync_manager", 0, 15));
  for (const auto& entry : reader.texts_or("entries", {})) pdo.objects.push_back(parse_pdo_entry(reader, entry));
  if (pdo.objects.size() > 255) reader.fail("entries", "are more than 255");
  reader.finish();
  (input ? configuration.inputs : configuration.outputs).push_back(std::move(pdo));
}

/// The drive must be one of those that the description of the slave counts.
void check_drive(const TomlReader& reader, const esi::DeviceDescription* device, std::uint8_t drive) {
  if (device == nullptr) return;
  if (!device->mailbox.soe) reader.fail("drive", "the slave has no drives: its description has no SoE mailbox");
  const auto drives = device->mailbox.soe_channels;
  if (drives == 0 || drive < drives) return;
  reader.fail("drive", drives == 1 ? std::string("the slave has one drive, 0 is expected")
                                   : fmt::format("the slave has {} drives, 0 to {} is expected", drives, drives - 1));
}

/// A number, a text, a list of them, or bytes in wire order.
void read_value(TomlReader& reader, ecat_master::StartupIdn& idn) {
  if (reader.has("data") && reader.has("value")) {
    reader.fail("data", "is set together with value: only one of them is expected");
  }
  if (reader.has("data")) {
    idn.value = read_bytes(reader, "data");
  } else if (reader.is_list("value")) {
    idn.value = reader.scalar_texts("value");
  } else {
    idn.value = reader.scalar_text("value");
  }
}

void read_hot_connect(TomlReader& slave, SlavePlanConfig& config) {
  if (slave.is_text("hot_connect")) {
    config.hot_connect = true;
    config.hot_head = slave.text("hot_connect");
    if (config.alias || config.device_id) {
      slave.fail("hot_connect",
                 fmt::format("names the head of its group, \"{}\", which is identified by its own alias or "
                             "device_id: remove the key from this slave",
                             config.hot_head));
    }
    return;
  }
  config.hot_connect = slave.boolean_or("hot_connect", false);
  if (config.hot_connect && !config.alias && !config.device_id) {
    slave.fail("hot_connect", "needs alias or device_id to identify the slave wherever it is plugged in");
  }
}

}  // namespace

motion::StartupSdo read_startup_sdo(TomlReader reader) {
  motion::StartupSdo sdo;
  sdo.index = static_cast<std::uint16_t>(reader.integer("index", 0x1000, 0xFFFF));
  sdo.subindex = static_cast<std::uint8_t>(reader.integer_or("subindex", 0, 0, 255));
  sdo.complete = reader.boolean_or("complete", false);
  if (sdo.complete && sdo.subindex > 1) reader.fail("subindex", "must be 0 or 1 with complete access");
  const bool before_op = reader.choice_or("before", 0, {"safeop", "op"}) == 1;
  sdo.in = before_op ? motion::StartupState::kSafeOperational : motion::StartupState::kPreOperational;
  if (reader.boolean_or("optional", false)) sdo.need = motion::WriteNeed::kOptional;
  const auto type = parse_type(reader.text_or("type", ""));
  if (!type) reader.fail("type", type.error().reason);
  const auto text =
      reader.is_text("value") ? reader.text("value") : std::to_string(reader.integer("value", INT64_MIN, INT64_MAX));
  auto data = parse_value(text, *type);
  if (!data) reader.fail("value", data.error().reason);
  sdo.data = std::move(*data);
  reader.finish();
  return sdo;
}

ecat_master::StartupIdn read_startup_idn(TomlReader reader, const esi::DeviceDescription* device) {
  constexpr std::int64_t kMaxDrive = 7;
  ecat_master::StartupIdn idn;
  idn.at.drive = static_cast<std::uint8_t>(reader.integer_or("drive", 0, 0, kMaxDrive));
  check_drive(reader, device, idn.at.drive);
  const auto text = reader.text("number");
  const auto number = wire::Idn::from_text(text);
  if (!number) reader.fail("number", fmt::format("is \"{}\", expected an IDN like \"S-0-0044\" or \"P-0-3030\"", text));
  idn.at.idn = *number;
  const bool to_op = reader.choice_or("transition", 0, {"PS", "SO"}) == 1;
  idn.in = to_op ? motion::StartupState::kSafeOperational : motion::StartupState::kPreOperational;
  idn.read_back = reader.boolean_or("read_back", true);
  idn.place = reader.place("number");
  read_value(reader, idn);
  reader.finish();
  return idn;
}

motion::MappedObject parse_pdo_entry(const TomlReader& reader, std::string_view text) {
  const auto first = text.find(':');
  const auto second = first == std::string_view::npos ? first : text.find(':', first + 1);
  if (second != std::string_view::npos) {
    const auto index = parse_number(text.substr(0, first), 0xFFFF);
    const auto subindex = parse_number(text.substr(first + 1, second - first - 1), 0xFF);
    const auto bits = parse_number(text.substr(second + 1), 0xFF);
    if (index && subindex && bits && *bits > 0) {
      return {static_cast<std::uint16_t>(*index), static_cast<std::uint8_t>(*subindex),
              static_cast<std::uint8_t>(*bits)};
    }
  }
  reader.fail("entries", fmt::format("\"{}\" is not \"index:sub-index:bits\", e.g. \"0x6040:0:16\"", text));
}

SlavePlanConfig read_slave_plan(TomlReader& slave, const esi::DeviceDescription* device) {
  SlavePlanConfig config;
  config.revision = read_rule(slave, "revision");
  config.serial = read_rule(slave, "serial");
  config.alias = read_name_number(slave, "alias");
  config.device_id = read_name_number(slave, "device_id");
  if (config.alias && config.device_id)
    slave.fail("device_id", "is set together with alias: only one of them is expected");
  if (slave.has("lrw")) config.lrw = slave.boolean_or("lrw", true);
  if (slave.has("eeprom_to_application")) {
    config.eeprom_to_application = slave.boolean_or("eeprom_to_application", true);
  }
  read_hot_connect(slave, config);
  config.watchdog = read_watchdogs(slave.table("watchdog"));
  config.timeouts = read_timeouts(slave.table("timeouts"), config.mailbox_timeouts);
  read_state_timeout(slave, config.timeouts);
  read_startup(slave.table("startup"), config);
  for (auto& sdo : slave.tables("sdo")) config.sdos.push_back(read_startup_sdo(std::move(sdo)));
  for (auto& idn : slave.tables("idn")) config.idns.push_back(read_startup_idn(std::move(idn), device));
  for (auto& pdo : slave.tables("pdo")) {
    if (!config.pdos) config.pdos.emplace();
    read_pdo(std::move(pdo), *config.pdos);
  }
  return config;
}

void SlavePlanConfig::apply(ecat_master::SlavePlan& plan) const {
  plan.revision = revision;
  plan.serial = serial;
  plan.alias = alias;
  plan.device_id = device_id;
  plan.hot_connect = hot_connect;
  plan.behind = behind;
  plan.lrw = lrw;
  plan.eeprom_to_application = eeprom_to_application;
  plan.watchdog = watchdog;
  plan.timeouts = timeouts;
  plan.mailbox_timeouts = mailbox_timeouts;
  plan.needs = needs;
  plan.safe_op_retries = safe_op_retries;
  for (auto& sdo : plan.startup_sdos) {
    if (motion::object_of_first_drive(sdo.index) == motion::kInterpolationTime) sdo.need = interpolation_time;
  }
  plan.startup_sdos.insert(plan.startup_sdos.end(), sdos.begin(), sdos.end());
  plan.startup_idns.insert(plan.startup_idns.end(), idns.begin(), idns.end());
  if (pdos) plan.pdos = *pdos;
}

}  // namespace driveline::runtime
