#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "can/frame_printer.hpp"
#include "can/node_facts.hpp"
#include "commands/can_tools.hpp"
#include "console.hpp"
#include "driveline/motion/cia402/object_name.hpp"
#include "text/json_text.hpp"

namespace driveline::cli {
namespace {

using canopen::ClientErrorKind;
using canopen::SdoObject;

constexpr std::uint16_t kMappingDistance = 0x200;  ///< from 1400h to 1600h, and from 1800h to 1A00h
constexpr unsigned kMostPdos = 512;                ///< of a direction (CiA 301 7.5.2.35)
constexpr std::uint32_t kMostEntries = 64;         ///< of a PDO, of a bit each

/// An object in a PDO.
struct MappedObject {
  std::uint16_t index = 0;
  std::uint8_t subindex = 0;
  std::uint8_t bits = 0;
  std::string name;  ///< empty: unknown
};

/// A PDO of a node as its objects tell it.
struct CanPdo {
  std::uint16_t index = 0;  ///< of the communication object
  unsigned number = 0;      ///< from 1
  bool transmit = false;
  canopen::CobId cob_id;
  std::optional<std::uint32_t> type;     ///< transmission type
  std::optional<std::uint32_t> inhibit;  ///< in 100 us
  std::optional<std::uint32_t> timer;    ///< event timer, ms
  std::vector<MappedObject> entries;
};

/// Reads the PDOs of a node.
class PdoReader {
 public:
  PdoReader(canopen::SdoClient& client, const std::optional<esi::EdsFile>& description)
      : client_(&client), description_(&description) {}

  [[nodiscard]] canopen::ClientResult<std::vector<CanPdo>> read() {
    std::vector<CanPdo> pdos;
    for (const bool transmit : {false, true}) {
      for (unsigned i = 0; i < kMostPdos; ++i) {
        auto pdo = read_one(transmit, i);
        if (!pdo) return tl::unexpected(pdo.error());
        if (!*pdo) break;
        pdos.push_back(std::move(**pdo));
      }
    }
    return pdos;
  }

 private:
  /// A number; empty: the node does not have it.
  [[nodiscard]] canopen::ClientResult<std::optional<std::uint32_t>> number(SdoObject object) {
    const auto value = client_->upload_number(object);
    if (value) return std::optional(*value);
    if (value.error().kind != ClientErrorKind::kAborted) return tl::unexpected(value.error());
    return std::optional<std::uint32_t>();
  }

  /// Empty: there is no such PDO.
  [[nodiscard]] canopen::ClientResult<std::optional<CanPdo>> read_one(bool transmit, unsigned place) {
    CanPdo pdo;
    pdo.index = static_cast<std::uint16_t>((transmit ? 0x1800U : 0x1400U) + place);
    pdo.number = place + 1;
    pdo.transmit = transmit;
    const auto cob_id = number({pdo.index, 1});
    if (!cob_id) return tl::unexpected(cob_id.error());
    if (!*cob_id) return std::optional<CanPdo>();
    pdo.cob_id.raw = **cob_id;
    for (const auto& [subindex, target] :
         {std::pair{std::uint8_t{2}, &pdo.type}, std::pair{std::uint8_t{3}, &pdo.inhibit},
          std::pair{std::uint8_t{5}, &pdo.timer}}) {
      const auto value = number({pdo.index, subindex});
      if (!value) return tl::unexpected(value.error());
      *target = *value;
    }
    const auto mapping = static_cast<std::uint16_t>(pdo.index + kMappingDistance);
    const auto count = number({mapping, 0});
    if (!count) return tl::unexpected(count.error());
    for (std::uint32_t i = 1; i <= std::min(count->value_or(0), kMostEntries); ++i) {
      const auto entry = number({mapping, static_cast<std::uint8_t>(i)});
      if (!entry) return tl::unexpected(entry.error());
      if (*entry) pdo.entries.push_back(mapped(**entry));
    }
    return std::optional(std::move(pdo));
  }

  /// An entry of a mapping: index, sub-index and bits (CiA 301 7.5.2.36).
  [[nodiscard]] MappedObject mapped(std::uint32_t raw) const {
    MappedObject entry{static_cast<std::uint16_t>(raw >> 16U),
                       static_cast<std::uint8_t>(raw >> 8U),
                       static_cast<std::uint8_t>(raw),
                       {}};
    if (*description_) {
      const auto* const known = find_entry(**description_, {entry.index, entry.subindex});
      if (known != nullptr) entry.name = known->name;
    }
    if (entry.name.empty()) entry.name = motion::cia402::object_name(entry.index, entry.subindex);
    return entry;
  }

  canopen::SdoClient* client_;
  const std::optional<esi::EdsFile>* description_;
};

std::string pdos_text(const std::vector<CanPdo>& pdos) {
  std::string text;
  for (const auto& pdo : pdos) {
    text += fmt::format("{}PDO {} 0x{:04x}, identifier {}{}, type {}", pdo.transmit ? 'T' : 'R', pdo.number, pdo.index,
                        identifier_words(pdo.cob_id.identifier()), pdo.cob_id.invalid() ? " (off)" : "",
                        pdo.type ? std::to_string(*pdo.type) : "unknown");
    if (pdo.inhibit.value_or(0) != 0) text += fmt::format(", inhibit time {:.1f} ms", *pdo.inhibit / 10.0);
    if (pdo.timer.value_or(0) != 0) text += fmt::format(", event timer {} ms", *pdo.timer);
    text += "\n";
    for (const auto& entry : pdo.entries) {
      text += fmt::format("  PDO entry 0x{:04x}:{:02x}, {:2} bit, \"{}\"\n", entry.index, entry.subindex, entry.bits,
                          entry.name);
    }
  }
  return text;
}

nlohmann::json optional_json(const std::optional<std::uint32_t>& value) {
  return value ? nlohmann::json(*value) : nlohmann::json();
}

nlohmann::json pdos_json(const std::vector<CanPdo>& pdos) {
  auto rows = nlohmann::json::array();
  for (const auto& pdo : pdos) {
    auto entries = nlohmann::json::array();
    for (const auto& entry : pdo.entries) {
      entries.push_back(
          {{"index", entry.index}, {"subindex", entry.subindex}, {"bits", entry.bits}, {"name", entry.name}});
    }
    rows.push_back({{"index", pdo.index},
                    {"direction", pdo.transmit ? "inputs" : "outputs"},
                    {"cob_id", pdo.cob_id.raw},
                    {"identifier", pdo.cob_id.identifier().value},
                    {"enable", !pdo.cob_id.invalid()},
                    {"transmission_type", optional_json(pdo.type)},
                    {"inhibit_time_100us", optional_json(pdo.inhibit)},
                    {"event_timer_ms", optional_json(pdo.timer)},
                    {"entries", entries}});
  }
  return rows;
}

}  // namespace

Outcome<int> list_can_pdos(const runtime::BusOptions& bus_options, const CanOptions& can, bool as_json) {
  canopen::SdoOptions settings;
  const auto timeout = can.answer_timeout(settings.answer_timeout);
  if (!timeout) return tl::unexpected(timeout.error());
  settings.answer_timeout = *timeout;
  const auto bus = open_can_bus(bus_options.config, bus_options.interface, can);
  if (!bus) return tl::unexpected(bus.error());
  const auto nodes = nodes_of(**bus, can);
  if (!nodes) return tl::unexpected(nodes.error());
  CanProgress told("nodes asked");
  auto list = nlohmann::json::array();
  std::size_t asked = 0;
  for (const auto node : *nodes) {
    told.show(asked++, nodes->size());
    canopen::SdoClient client((*bus)->link(), node, settings);
    const auto facts = read_node_facts(client, false);
    if (!facts.trouble.empty()) return failed(facts.trouble);
    const auto description = known_description(facts);
    const auto pdos = PdoReader(client, description).read();
    if (!pdos) return can_failure(pdos.error());
    if (as_json) {
      list.push_back({{"node", node}, {"pdos", pdos_json(*pdos)}});
      continue;
    }
    if (nodes->size() > 1) print_out("=== node {} ===\n", node);
    print_out("{}", pdos_text(*pdos));
  }
  if (as_json) print_out("{}", json_text({{"nodes", list}}));
  return 0;
}

}  // namespace driveline::cli
