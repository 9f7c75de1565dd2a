#include "commands/can_options.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>

#include "console.hpp"

namespace driveline::cli {
namespace {

constexpr auto kToldEvery = std::chrono::seconds{2};
constexpr auto kScanTimeout = std::chrono::milliseconds{50};
constexpr std::uint32_t kLongestTimeout = 60'000;  ///< ms
constexpr std::array<std::uint32_t, 9> kBitRates = {10'000,  20'000,  50'000,  100'000,  125'000,
                                                    250'000, 500'000, 800'000, 1'000'000};

/// A node-ID; empty: not one.
std::optional<std::uint8_t> parse_node(std::string_view text) {
  const auto number = parse_number(text, canopen::kMaxNodeId, "node");
  if (!number || *number == 0) return std::nullopt;
  return static_cast<std::uint8_t>(*number);
}

}  // namespace

void CanOptions::add(Arguments& to) {
  to.option("-n,--node", &nodes, Value::text("NODE"), "CAN bus: nodes, 1 to 127, e.g. 3, 1,5 or 1-8");
  to.option("--timeout", &timeout, Value::text("MS"), "CAN bus: how long each answer is waited for");
  add_bit_rate(to);
}

void CanOptions::add_single(Arguments& to) {
  to.option("-n,--node", &nodes, Value::text("NODE"), "CAN bus: the node, 1 to 127");
  to.option("--timeout", &timeout, Value::text("MS"), "CAN bus: how long each answer is waited for; default: 500");
  add_bit_rate(to);
}

void CanOptions::add_bit_rate(Arguments& to) {
  to.option("--bit-rate", &bit_rate, Value::text("RATE"),
            "CAN bus: its bit rate in bit/s; default: that of the description, or 1000000");
}

Outcome<std::vector<std::uint8_t>> CanOptions::selected() const {
  std::array<bool, canopen::kMaxNodeId + 1U> wanted{};
  std::string_view rest = nodes ? std::string_view(*nodes) : std::string_view();
  bool more = nodes.has_value();
  while (more) {
    const auto comma = std::min(rest.find(','), rest.size());
    const auto part = rest.substr(0, comma);
    const auto dash = part.find('-');
    const auto first = parse_node(part.substr(0, dash));
    const auto last = dash == std::string_view::npos ? first : parse_node(part.substr(dash + 1));
    if (!first || !last || *first > *last) {
      return misused(fmt::format("--node \"{}\": node-IDs from 1 to 127 are expected, e.g. 3, 1,5 or 1-8", *nodes));
    }
    std::fill(wanted.begin() + *first, wanted.begin() + *last + 1, true);
    more = comma < rest.size();
    if (more) rest.remove_prefix(comma + 1);
  }
  std::vector<std::uint8_t> list;
  for (std::uint8_t node = 1; node <= canopen::kMaxNodeId; ++node) {
    if (wanted.at(node)) list.push_back(node);
  }
  return list;
}

Outcome<std::uint8_t> CanOptions::select_one(const CanBus& bus) const {
  const auto list = selected();
  if (!list) return tl::unexpected(list.error());
  if (list->size() > 1) return misused(fmt::format("{} nodes are selected, one is expected", list->size()));
  if (list->size() == 1) return list->front();
  if (bus.described().size() == 1) return bus.described().front().node;
  return misused("the bus may have several nodes: give -n NODE");
}

Outcome<std::chrono::nanoseconds> CanOptions::answer_timeout(std::chrono::nanoseconds otherwise) const {
  if (!timeout) return otherwise;
  const auto number = parse_number(*timeout, kLongestTimeout, "--timeout");
  if (!number) return tl::unexpected(number.error());
  if (*number == 0) return misused("--timeout 0: 1 to 60000 ms are expected");
  return std::chrono::milliseconds{*number};
}

Outcome<std::optional<std::uint32_t>> CanOptions::rate() const {
  if (!bit_rate) return std::optional<std::uint32_t>();
  const auto number = parse_number(*bit_rate, kBitRates.back(), "--bit-rate");
  if (!number || std::find(kBitRates.begin(), kBitRates.end(), *number) == kBitRates.end()) {
    return misused(fmt::format("--bit-rate {}: one of {} bit/s is expected", *bit_rate, fmt::join(kBitRates, ", ")));
  }
  return std::optional(*number);
}

Outcome<void> CanOptions::check() const {
  if (const auto list = selected(); !list) return tl::unexpected(list.error());
  if (const auto number = rate(); !number) return tl::unexpected(number.error());
  if (const auto time = answer_timeout({}); !time) return tl::unexpected(time.error());
  return {};
}

Outcome<bool> works_on_can(const runtime::BusOptions& bus, const CanOptions& can,
                           std::initializer_list<OtherOption> ethercat_only) {
  if (!selects_can(bus.config, bus.interface)) {
    for (const auto& [given, name] :
         {OtherOption{can.nodes.has_value(), "-n"}, OtherOption{can.timeout.has_value(), "--timeout"},
          OtherOption{can.bit_rate.has_value(), "--bit-rate"}}) {
      if (given)
        return misused(fmt::format("{} is for CAN buses; slaves of an EtherCAT line are selected by -p or -a", name));
    }
    return false;
  }
  for (const auto& [given, name] : ethercat_only) {
    if (given)
      return misused(fmt::format("{} is for EtherCAT lines; nodes of a CAN bus are selected by -n NODE", name));
  }
  if (!bus.interface2.empty()) return misused("--iface2 is for EtherCAT lines: a CAN bus has no second end");
  if (auto checked = can.check(); !checked) return tl::unexpected(checked.error());
  return true;
}

Outcome<std::unique_ptr<CanBus>> open_can_bus(const std::string& config, const std::string& interface,
                                              const CanOptions& can) {
  const auto rate = can.rate();
  if (!rate) return tl::unexpected(rate.error());
  CanBusOptions options;
  options.config = config;
  options.interface = interface;
  options.bit_rate = *rate;
  return CanBus::open(options);
}

void CanProgress::show(std::size_t done, std::size_t total) {
  if (clock_.now() - told_ < kToldEvery) return;
  told_ = clock_.now();
  progress("{}: {}{}", what_, done, total == 0 ? std::string() : fmt::format(" of {}", total));
}

Outcome<std::vector<std::uint8_t>> nodes_of(CanBus& bus, const CanOptions& can) {
  auto list = can.selected();
  if (!list || !list->empty()) return list;
  for (const auto& node : bus.described()) list->push_back(node.node);
  std::sort(list->begin(), list->end());
  if (!list->empty()) return list;
  const auto found = scan_bus(bus, can, {});
  if (!found) return tl::unexpected(found.error());
  for (const auto& node : *found) list->push_back(node.node);
  if (list->empty()) return failed("no node was found on the bus");
  return list;
}

Outcome<std::vector<canopen::FoundNode>> scan_bus(CanBus& bus, const CanOptions& can, std::vector<std::uint8_t> nodes) {
  const auto timeout = can.answer_timeout(kScanTimeout);
  if (!timeout) return tl::unexpected(timeout.error());
  CanProgress progress("scan");
  canopen::Scan scan(bus.link(), {std::move(nodes), *timeout, bus.bit_rate()});
  auto found = scan.run([&](std::size_t done, std::size_t total) { progress.show(done, total); });
  if (!found) return can_failure(found.error());
  return std::move(*found);
}

}  // namespace driveline::cli
