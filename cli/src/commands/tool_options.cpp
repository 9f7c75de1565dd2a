#include "commands/tool_options.hpp"

#include <fmt/format.h>
#include <algorithm>
#include <charconv>
#include <cmath>

#include "can/can_bus.hpp"
#include "console.hpp"

namespace driveline::cli {
namespace {

constexpr std::uint32_t kMaxPosition = 65535;

struct Range {
  std::size_t first = 0;
  std::size_t last = 0;
};

/// Parses "0,2-4" into ranges.
Outcome<std::vector<Range>> parse_positions(std::string_view text) {
  std::vector<Range> ranges;
  std::string_view rest = text;
  for (;;) {
    const auto comma = std::min(rest.find(','), rest.size());
    const auto part = rest.substr(0, comma);
    const auto dash = part.find('-');
    const auto first = parse_number(part.substr(0, dash), kMaxPosition, "position");
    const auto last =
        dash == std::string_view::npos ? first : parse_number(part.substr(dash + 1), kMaxPosition, "position");
    if (!first || !last || *first > *last) {
      return misused(fmt::format("positions \"{}\": e.g. 3, 0,2 or 1-4 is expected", text));
    }
    ranges.push_back({*first, *last});
    if (comma == rest.size()) return ranges;
    rest.remove_prefix(comma + 1);
  }
}

}  // namespace

Outcome<void> check_bus_options(const runtime::BusOptions& bus) {
  if (selects_can(bus.config, bus.interface)) {
    return misused(
        fmt::format("{} is a CAN bus, and this command is for lines of EtherCAT; scan, slaves, states, sdos, "
                    "pdos, upload, download, nmt, emcy and can work on CAN buses",
                    bus.interface.empty() ? bus.config : bus.interface));
  }
  if (bus.config.empty() && bus.interface.empty()) {
    return misused(
        "no bus is selected: give --config FILE for the line described there, or --iface NAME for a network interface");
  }
  if (!bus.interface2.empty() && bus.interface2 == bus.interface)
    return misused(fmt::format("--iface2 {}: is also the first interface; a ring has two ends", bus.interface2));
  return {};
}

Outcome<void> check_run_bus(const runtime::BusOptions& bus) {
  if (!bus.config.empty() && runtime::describes_can_line(bus.config)) {
    if (bus.interface2.empty()) return {};
    return misused("--iface2 is the second interface of a ring, and a CAN bus is none");
  }
  if (!names_can_interface(bus.interface)) return check_bus_options(bus);
  if (bus.config.empty()) {
    return misused(
        fmt::format("--iface {0} is a CAN bus, and a CAN line needs its description: --config FILE; "
                    "`driveline scan --iface {0} --write FILE` makes one",
                    bus.interface));
  }
  return misused(
      fmt::format("--iface {} is a CAN bus, and {} describes a line of EtherCAT: [bus] type = \"can\" is "
                  "expected there",
                  bus.interface, bus.config));
}

Outcome<std::unique_ptr<runtime::Session>> open_session(const runtime::BusOptions& bus) {
  if (auto checked = check_bus_options(bus); !checked) return tl::unexpected(checked.error());
  auto session = runtime::Session::open(bus);
  if (!session) return tl::unexpected(session.error());
  for (const auto& note : (*session)->config().notes) progress("{}", note);
  return std::move(*session);
}

void tell_what_ends(const runtime::Session& session) {
  if (session.config().interface) return;
  progress(
      "the line is simulated in this process and ends with it: every command starts a new one according to its "
      "description; `driveline simulate` serves one that persists");
}

void add_bus_options(Arguments& to, runtime::BusOptions& bus) {
  to.option("--config", &bus.config, Value::file(), "Line description (TOML)");
  to.option("--iface", &bus.interface, Value::interface(),
            "Network interface; replaces the simulated line of the file");
  to.option("--iface2", &bus.interface2, Value::interface(), "Network interface at the other end of a ring");
}

void add_json_flag(Arguments& to, bool& json) {
  to.flag("--json", json, "Print one JSON document");
}

void add_force_flag(Arguments& to, bool& force) {
  to.flag("--force", force, "Proceed even if a master drives the line; this disturbs it");
}

Outcome<std::uint32_t> parse_number(std::string_view text, std::uint32_t maximum, std::string_view what) {
  int base = 10;
  std::string_view digits = text;
  if (digits.starts_with("0x") || digits.starts_with("0X")) {
    base = 16;
    digits.remove_prefix(2);
  } else if (digits.ends_with('h') || digits.ends_with('H')) {
    base = 16;
    digits.remove_suffix(1);
  }
  std::uint32_t value = 0;
  const auto* end = digits.data() + digits.size();
  const auto result = std::from_chars(digits.data(), end, value, base);
  if (result.ec != std::errc{} || result.ptr != end || value > maximum) {
    return misused(fmt::format("{} \"{}\": a number up to {} is expected, as 0x{:X}, {:X}h or {}", what, text, maximum,
                               maximum, maximum, maximum));
  }
  return value;
}

void SlaveSelection::add(Arguments& to) {
  to.option("-p,--position", &positions, Value::text("N"),
            "Positions of slaves, 0 is the first, e.g. 3, 0,2 or 1-4; default: all");
  to.option("-a,--alias", &alias, Value::text("ALIAS"), "Slaves with this alias address");
}

void SlaveSelection::add_single(Arguments& to) {
  to.option("-p,--position", &positions, Value::text("N"), "Position of the slave, 0 is the first");
  to.option("-a,--alias", &alias, Value::text("ALIAS"), "Slave with this alias address");
}

Outcome<void> SlaveSelection::check() const {
  if (positions) {
    if (auto ranges = parse_positions(*positions); !ranges) return tl::unexpected(ranges.error());
  }
  if (alias) {
    if (auto number = parse_number(*alias, 0xFFFF, "alias"); !number) return tl::unexpected(number.error());
  }
  return {};
}

Outcome<std::vector<std::size_t>> SlaveSelection::select(std::span<const std::uint16_t> aliases) const {
  std::vector<bool> wanted(aliases.size(), true);
  if (positions) {
    const auto ranges = parse_positions(*positions);
    if (!ranges) return tl::unexpected(ranges.error());
    std::fill(wanted.begin(), wanted.end(), false);
    for (const auto& range : *ranges) {
      if (range.last >= aliases.size()) {
        return failed(fmt::format("there is no slave {}, the line has {}", range.last, aliases.size()));
      }
      std::fill(wanted.begin() + static_cast<std::ptrdiff_t>(range.first),
                wanted.begin() + static_cast<std::ptrdiff_t>(range.last) + 1, true);
    }
  }
  std::uint32_t number = 0;
  if (alias) {
    const auto parsed = parse_number(*alias, 0xFFFF, "alias");
    if (!parsed) return tl::unexpected(parsed.error());
    number = *parsed;
  }
  std::vector<std::size_t> selected;
  for (std::size_t i = 0; i < aliases.size(); ++i) {
    if (wanted[i] && (!alias || aliases[i] == number)) selected.push_back(i);
  }
  if (selected.empty()) return failed(fmt::format("no slave has the alias address {}", alias.value_or("")));
  return selected;
}

Outcome<std::size_t> SlaveSelection::select_one(std::span<const std::uint16_t> aliases, bool explicitly) const {
  if (!positions && !alias) {
    if (explicitly && aliases.size() > 1) {
      return misused(fmt::format("the line has {} slaves: give -p N or -a ALIAS", aliases.size()));
    }
    return std::size_t{0};
  }
  const auto selected = select(aliases);
  if (!selected) return tl::unexpected(selected.error());
  if (selected->size() > 1) return misused(fmt::format("{} slaves are selected, one is expected", selected->size()));
  return selected->front();
}

}  // namespace driveline::cli
