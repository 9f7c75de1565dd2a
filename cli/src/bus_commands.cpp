#include <fmt/format.h>
#include <charconv>
#include <nlohmann/json.hpp>

#include "commands.hpp"
#include "driveline/ecat_master/master.hpp"
#include "json_text.hpp"
#include "typed_value.hpp"

namespace driveline::cli {
namespace {

using ecat_master::Master;

Outcome<void> scan(Master& master) {
  if (auto done = master.scan(); !done) return failed(ecat_master::describe(done.error()));
  return {};
}

/// A slave in PREOP, ready for SDO transfers.
Outcome<ecat_master::MailboxClient*> open_mailbox(Master& master, std::size_t slave) {
  if (auto done = scan(master); !done) return tl::unexpected(done.error());
  if (slave >= master.slaves().size()) {
    return failed(fmt::format("there is no slave {}, the line has {}", slave, master.slaves().size()));
  }
  if (auto done = master.enter_pre_op(); !done) return failed(ecat_master::describe(done.error()));
  auto* mailbox = master.mailbox(slave);
  if (mailbox == nullptr) return failed(fmt::format("slave {} has no mailbox", slave));
  return mailbox;
}

/// A number as people write indices: 0x6041, 6041h or decimal.
Outcome<std::uint32_t> parse_number(std::string text, std::uint32_t maximum, std::string_view what) {
  int base = 10;
  std::string digits = text;
  if (digits.size() > 2 && (digits.rfind("0x", 0) == 0 || digits.rfind("0X", 0) == 0)) {
    base = 16;
    digits = digits.substr(2);
  } else if (digits.size() > 1 && (digits.back() == 'h' || digits.back() == 'H')) {
    base = 16;
    digits.pop_back();
  }
  std::uint32_t value = 0;
  const auto* end = digits.data() + digits.size();
  const auto result = std::from_chars(digits.data(), end, value, base);
  if (result.ec != std::errc{} || result.ptr != end || value > maximum) {
    return misused(
        fmt::format("{} \"{}\": a number up to 0x{:X} is expected, e.g. 0x6041, 6041h or 24641", what, text, maximum));
  }
  return value;
}

struct ObjectAddress {
  std::uint16_t index = 0;
  std::uint8_t subindex = 0;
};

Outcome<ObjectAddress> parse_address(const ObjectOptions& options) {
  const auto index = parse_number(options.index, 0xFFFF, "index");
  if (!index) return tl::unexpected(index.error());
  const auto subindex = parse_number(options.subindex, 0xFF, "sub-index");
  if (!subindex) return tl::unexpected(subindex.error());
  return ObjectAddress{static_cast<std::uint16_t>(*index), static_cast<std::uint8_t>(*subindex)};
}

nlohmann::json to_json(const ecat_master::SlaveInfo& info) {
  const auto& device = info.description;
  return {{"position", info.ref.position},
          {"station_address", info.ref.station},
          {"alias", info.alias},
          {"vendor_id", device.vendor_id},
          {"product_code", device.product_code},
          {"revision", device.revision},
          {"serial_number", device.serial_number},
          {"name", device.name}};
}

}  // namespace

Outcome<int> list_slaves(const BusOptions& bus, bool json) {
  auto session = Session::open(bus);
  if (!session) return tl::unexpected(session.error());
  Master master((*session)->port(), (*session)->clock());
  if (auto done = scan(master); !done) return tl::unexpected(done.error());
  if (json) {
    auto slaves = nlohmann::json::array();
    for (const auto& slave : master.slaves()) slaves.push_back(to_json(slave.info));
    fmt::print("{}", json_text({{"slaves", slaves}}));
    return 0;
  }
  fmt::print("{:>4} {:>8} {:>6}  {:>10} {:>10} {:>10} {:>10}  {}\n", "pos", "address", "alias", "vendor", "product",
             "revision", "serial", "name");
  for (const auto& slave : master.slaves()) {
    const auto& device = slave.info.description;
    fmt::print("{:>4}   0x{:04X} {:>6}  0x{:08X} 0x{:08X} 0x{:08X} {:>10}  {}\n", slave.info.ref.position,
               slave.info.ref.station, slave.info.alias, device.vendor_id, device.product_code, device.revision,
               device.serial_number, device.name);
  }
  return 0;
}

Outcome<int> states(const BusOptions& bus, const std::string& wanted, bool json) {
  using wire::AlState;
  std::optional<AlState> target;
  for (const auto state : {AlState::kInit, AlState::kPreOp, AlState::kSafeOp, AlState::kOp}) {
    if (wanted == wire::to_text(state)) target = state;
  }
  if (!wanted.empty() && !target)
    return misused(fmt::format("state \"{}\": INIT, PREOP or SAFEOP is expected", wanted));
  if (target == AlState::kOp) return misused("OP lives on cyclic process data, which end with this command: use `run`");
  auto session = Session::open(bus);
  if (!session) return tl::unexpected(session.error());
  Master master((*session)->port(), (*session)->clock());
  // Looking is not touching: without a wanted state no slave is reset.
  const auto reports_before =
      wanted.empty() ? master.peek_states() : ecat_master::Result<std::vector<ecat_master::AlReport>>{};
  if (!reports_before) return failed(ecat_master::describe(reports_before.error()));
  auto reports = *reports_before;
  if (target) {
    if (auto done = scan(master); !done) return tl::unexpected(done.error());
    ecat_master::Result<void> done{};
    if (*target == AlState::kPreOp) done = master.enter_pre_op();
    if (*target == AlState::kSafeOp) {
      done = master.configure((*session)->has_config() ? make_slave_plans((*session)->config())
                                                       : std::vector<ecat_master::SlavePlan>{});
    }
    if (!done) return failed(ecat_master::describe(done.error()));
    const auto after = master.al_status();
    if (!after) return failed(ecat_master::describe(after.error()));
    reports = *after;
  }
  auto rows = nlohmann::json::array();
  for (std::size_t i = 0; i < reports.size(); ++i) {
    const auto& [status, code] = reports[i];
    if (json) {
      rows.push_back({{"position", i},
                      {"state", wire::to_text(status.state)},
                      {"error", status.error},
                      {"al_status_code", static_cast<unsigned>(code)}});
    } else {
      fmt::print("{:>4}  {}{}\n", i, wire::to_text(status.state),
                 status.error ? fmt::format(" + ERROR, AL status code 0x{:04X} ({})", static_cast<unsigned>(code),
                                            wire::to_text(code))
                              : std::string());
    }
  }
  if (json) fmt::print("{}", json_text({{"slaves", rows}}));
  return 0;
}

Outcome<int> upload(const BusOptions& bus, const ObjectOptions& options) {
  const auto address = parse_address(options);
  if (!address) return tl::unexpected(address.error());
  const auto type = parse_type(options.type);
  if (!type) return misused(type.error());
  auto session = Session::open(bus);
  if (!session) return tl::unexpected(session.error());
  Master master((*session)->port(), (*session)->clock());
  auto mailbox = open_mailbox(master, options.slave);
  if (!mailbox) return tl::unexpected(mailbox.error());
  const auto data = ecat_master::CoeClient(**mailbox).upload(address->index, address->subindex);
  if (!data) return failed(ecat_master::describe(data.error()));
  const auto text = format_value(*data, *type);
  if (!text) return failed(text.error());
  if (options.json) {
    fmt::print("{}", json_text({{"slave", options.slave},
                                {"index", address->index},
                                {"subindex", address->subindex},
                                {"bytes", data->size()},
                                {"value", *json_value(*data, *type)}}));
  } else {
    fmt::print("{}\n", *text);
  }
  return 0;
}

Outcome<int> download(const BusOptions& bus, const ObjectOptions& options) {
  const auto address = parse_address(options);
  if (!address) return tl::unexpected(address.error());
  const auto type = parse_type(options.type);
  if (!type) return misused(type.error());
  const auto data = parse_value(options.value, *type);
  if (!data) return misused(data.error());
  auto session = Session::open(bus);
  if (!session) return tl::unexpected(session.error());
  Master master((*session)->port(), (*session)->clock());
  auto mailbox = open_mailbox(master, options.slave);
  if (!mailbox) return tl::unexpected(mailbox.error());
  auto done = ecat_master::CoeClient(**mailbox).download(address->index, address->subindex, *data);
  if (!done) return failed(ecat_master::describe(done.error()));
  if (options.json) {
    fmt::print("{}", json_text({{"slave", options.slave},
                                {"index", address->index},
                                {"subindex", address->subindex},
                                {"bytes", data->size()}}));
  }
  return 0;
}

}  // namespace driveline::cli
