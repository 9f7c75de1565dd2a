#include <fmt/format.h>

#include <algorithm>

#include "can/node_facts.hpp"
#include "commands/can_tools.hpp"
#include "console.hpp"
#include "driveline/esi/hex.hpp"
#include "driveline/motion/cia402/object_name.hpp"
#include "driveline/runtime/config/typed_value.hpp"
#include "driveline/runtime/files/input_file.hpp"
#include "text/json_text.hpp"
#include "text/object_text.hpp"
#include "text/value_json.hpp"

namespace driveline::cli {
namespace {

using canopen::ClientErrorKind;
using canopen::SdoAbort;
using canopen::SdoObject;
using runtime::ValueType;
using std::chrono::nanoseconds;

constexpr nanoseconds kObjectTimeout = std::chrono::milliseconds{500};

/// What upload and download have in common: a node, and the object.
struct CanDialogue {
  std::unique_ptr<CanBus> bus;
  std::optional<canopen::SdoClient> client;
  SdoObject object;
  std::optional<ValueType> type;  ///< requested; empty: as the device is described

  [[nodiscard]] nlohmann::json to_json(std::size_t bytes) const {
    return {{"node", client->node()}, {"index", object.index}, {"subindex", object.subindex}, {"bytes", bytes}};
  }
};

Outcome<SdoObject> parse_object(const CanObjectOptions& options) {
  const auto index = parse_number(options.index, 0xFFFF, "index");
  if (!index) return tl::unexpected(index.error());
  const auto subindex = parse_number(options.subindex, 0xFF, "sub-index");
  if (!subindex) return tl::unexpected(subindex.error());
  return SdoObject{static_cast<std::uint16_t>(*index), static_cast<std::uint8_t>(*subindex)};
}

Outcome<CanDialogue> begin_dialogue(const runtime::BusOptions& bus, const CanOptions& can,
                                    const CanObjectOptions& options) {
  CanDialogue dialogue;
  const auto object = parse_object(options);
  if (!object) return tl::unexpected(object.error());
  dialogue.object = *object;
  if (!options.type.empty()) {
    const auto type = runtime::parse_type(options.type);
    if (!type) return tl::unexpected(type.error());
    dialogue.type = *type;
  }
  canopen::SdoOptions settings;
  const auto timeout = can.answer_timeout(kObjectTimeout);
  if (!timeout) return tl::unexpected(timeout.error());
  settings.answer_timeout = *timeout;
  settings.block = options.block;
  auto opened = open_can_bus(bus.config, bus.interface, can);
  if (!opened) return tl::unexpected(opened.error());
  dialogue.bus = std::move(*opened);
  const auto node = can.select_one(*dialogue.bus);
  if (!node) return tl::unexpected(node.error());
  dialogue.client.emplace(dialogue.bus->link(), *node, settings);
  return dialogue;
}

/// The type on the command line, else the one in the description of the device, else raw bytes.
ValueType object_type(CanDialogue& dialogue) {
  if (dialogue.type) return *dialogue.type;
  auto settings = dialogue.client->options();
  const bool block = std::exchange(settings.block, false);
  dialogue.client->set_options(settings);
  NodeFacts facts;
  if (const auto vendor = dialogue.client->upload_number({0x1018, 1})) facts.vendor_id = *vendor;
  if (const auto product = dialogue.client->upload_number({0x1018, 2})) facts.product_code = *product;
  settings.block = block;
  dialogue.client->set_options(settings);
  const auto description = known_description(facts);
  const auto* const entry = description ? find_entry(*description, dialogue.object) : nullptr;
  if (entry == nullptr) return ValueType::kRaw;
  return runtime::value_type_of(static_cast<std::uint16_t>(entry->type)).value_or(ValueType::kRaw);
}

/// Adds a hint: manuals write indices in hexadecimal, but "6041" is parsed as decimal.
tl::unexpected<Failure> object_failure_on_can(const canopen::ClientError& error, const CanObjectOptions& options) {
  const bool decimal = options.index.size() == 4 && options.index.find_first_not_of("0123456789") == std::string::npos;
  const bool missing = error.kind == ClientErrorKind::kAborted && error.code == SdoAbort::kObjectDoesNotExist;
  const bool no_block =
      options.block && error.kind == ClientErrorKind::kAborted && error.code == SdoAbort::kInvalidCommand;
  if (no_block) return failed(canopen::describe(error) + "; without --block the transfer is segmented");
  if (!missing || !decimal) return can_failure(error);
  return failed(fmt::format("{}; {} is a decimal number, 0x{} or {}h a hexadecimal one", canopen::describe(error),
                            options.index, options.index, options.index));
}

/// Read and write rights of an entry of a description, in the bits of CoE: they are the same in all states.
ecat_master::EntryDescription entry_of(const esi::EdsFile& description, std::uint16_t index,
                                       const esi::ObjectEntry& entry, std::uint8_t node) {
  namespace access = wire::entry_access;
  ecat_master::EntryDescription row;
  row.index = index;
  row.subindex = entry.subindex;
  row.data_type = static_cast<std::uint16_t>(entry.type);
  row.bit_length = entry.bit_length;
  if (entry.readable) row.access |= access::kReadPreOp | access::kReadSafeOp | access::kReadOp;
  if (entry.writable) row.access |= access::kWritePreOp | access::kWriteSafeOp | access::kWriteOp;
  if (entry.rx_mappable) row.access |= access::kRxMappable;
  if (entry.tx_mappable) row.access |= access::kTxMappable;
  const auto initial = description.default_hex({index, entry.subindex}, node);
  if (!initial.empty()) row.default_value = esi::parse_hex(initial);
  if (!entry.minimum_hex.empty()) row.minimum = esi::parse_hex(entry.minimum_hex);
  if (!entry.maximum_hex.empty()) row.maximum = esi::parse_hex(entry.maximum_hex);
  row.name = entry.name;
  return row;
}

std::vector<DictionaryObject> described_objects(const esi::EdsFile& description, std::uint8_t node,
                                                std::optional<std::uint16_t> only, bool quiet) {
  std::vector<DictionaryObject> objects;
  for (const auto& object : description.device.objects) {
    if (only && object.index != *only) continue;
    DictionaryObject row;
    row.object.index = object.index;
    row.object.object_code = static_cast<std::uint8_t>(object.code);
    row.object.name = object.name;
    if (!quiet) {
      for (const auto& entry : object.entries) {
        row.entries.push_back(entry_of(description, object.index, entry, node));
      }
    }
    objects.push_back(std::move(row));
  }
  return objects;
}

/// Indices of the communication profile and of CiA 402 that are worth asking for.
std::vector<std::uint16_t> usual_indices() {
  struct Range {
    std::uint16_t first;
    std::uint16_t last;
  };
  std::vector<std::uint16_t> indices;
  for (const auto& [first, last] :
       {Range{0x1000, 0x1029}, Range{0x1200, 0x1200}, Range{0x1400, 0x1403}, Range{0x1600, 0x1603},
        Range{0x1800, 0x1803}, Range{0x1A00, 0x1A03}, Range{0x6007, 0x6007}, Range{0x603F, 0x60FF},
        Range{0x6402, 0x6410}, Range{0x6502, 0x6505}, Range{0x67FF, 0x67FF}}) {
    for (std::uint32_t index = first; index <= last; ++index) indices.push_back(static_cast<std::uint16_t>(index));
  }
  return indices;
}

/// Asks a node of unknown kind for sub-index 0 of objects; those that do not exist are left out.
Outcome<std::vector<DictionaryObject>> answering_objects(canopen::SdoClient& client,
                                                         std::span<const std::uint16_t> indices) {
  namespace access = wire::entry_access;
  CanProgress told(fmt::format("node {}: objects asked for", client.node()));
  std::vector<DictionaryObject> objects;
  std::size_t done = 0;
  for (const auto index : indices) {
    told.show(done++, indices.size());
    const auto data = client.upload({index, 0});
    if (!data && data.error().kind != ClientErrorKind::kAborted) return can_failure(data.error());
    if (!data && data.error().code == SdoAbort::kObjectDoesNotExist) continue;
    DictionaryObject row;
    row.object.index = index;
    row.object.name = motion::cia402::object_name(index, 0);
    if (data) {
      ecat_master::EntryDescription entry;
      entry.index = index;
      entry.bit_length = static_cast<std::uint16_t>(std::min<std::size_t>(8 * data->size(), 0xFFFF));
      entry.access = access::kReadPreOp | access::kReadSafeOp | access::kReadOp;
      entry.name = row.object.name;
      row.entries.push_back(std::move(entry));
    } else {
      row.troubles.push_back(canopen::describe(data.error()));
    }
    objects.push_back(std::move(row));
  }
  return objects;
}

Outcome<std::optional<esi::EdsFile>> read_data_sheet(const std::string& file) {
  if (file.empty()) return std::optional<esi::EdsFile>();
  const auto text = runtime::read_input_file(file);
  if (!text) return tl::unexpected(text.error());
  auto sheet = esi::read_eds(*text, file);
  if (!sheet) return misused(describe(sheet.error()));
  return std::optional(std::move(*sheet));
}

Outcome<std::vector<DictionaryObject>> objects_of(CanBus& bus, std::uint8_t node,
                                                  const std::optional<esi::EdsFile>& sheet,
                                                  std::optional<std::uint16_t> only, bool quiet, nanoseconds timeout) {
  canopen::SdoOptions settings;
  settings.answer_timeout = timeout;
  canopen::SdoClient client(bus.link(), node, settings);
  if (sheet) return described_objects(*sheet, node, only, quiet);
  const auto facts = read_node_facts(client, false);
  if (!facts.trouble.empty()) return failed(facts.trouble);
  if (const auto known = known_description(facts)) return described_objects(*known, node, only, quiet);
  progress("node {}: its kind is unknown: these are the usual objects that answer; --eds FILE shows all", node);
  const auto indices = only ? std::vector<std::uint16_t>{*only} : usual_indices();
  return answering_objects(client, indices);
}

}  // namespace

Outcome<int> upload_can(const runtime::BusOptions& bus, const CanOptions& can, const CanObjectOptions& options) {
  auto dialogue = begin_dialogue(bus, can, options);
  if (!dialogue) return tl::unexpected(dialogue.error());
  const auto data = dialogue->client->upload(dialogue->object);
  if (!data) return object_failure_on_can(data.error(), options);
  auto shown = object_type(*dialogue);
  // A wrong type in a description must not hide the value.
  if (!dialogue->type && runtime::type_bytes(shown) != 0 && runtime::type_bytes(shown) != data->size()) {
    shown = ValueType::kRaw;
  }
  const auto text = runtime::format_value(*data, shown);
  if (!text) return failed(text.error().reason);
  if (!options.json) {
    print_out("{}\n", *text);
    return 0;
  }
  auto document = dialogue->to_json(data->size());
  document["value"] = *json_value(*data, shown);
  print_out("{}", json_text(document));
  return 0;
}

Outcome<int> download_can(const runtime::BusOptions& bus, const CanOptions& can, const CanObjectOptions& options) {
  if (!options.type.empty()) {
    const auto type = runtime::parse_type(options.type);
    if (!type) return tl::unexpected(type.error());
    if (const auto value = runtime::parse_value(options.value, *type); !value) return tl::unexpected(value.error());
  }
  auto dialogue = begin_dialogue(bus, can, options);
  if (!dialogue) return tl::unexpected(dialogue.error());
  const auto data = runtime::parse_value(options.value, object_type(*dialogue));
  if (!data) return tl::unexpected(data.error());
  if (const auto done = dialogue->client->download(dialogue->object, *data); !done) {
    return object_failure_on_can(done.error(), options);
  }
  dialogue->bus->tell_what_ends();
  if (options.json) print_out("{}", json_text(dialogue->to_json(data->size())));
  return 0;
}

Outcome<int> list_can_objects(const runtime::BusOptions& bus_options, const CanOptions& can,
                              const CanDictionaryOptions& options) {
  std::optional<std::uint16_t> only;
  if (!options.index.empty()) {
    const auto index = parse_number(options.index, 0xFFFF, "index");
    if (!index) return tl::unexpected(index.error());
    only = static_cast<std::uint16_t>(*index);
  }
  const auto timeout = can.answer_timeout(kObjectTimeout);
  if (!timeout) return tl::unexpected(timeout.error());
  const auto sheet = read_data_sheet(options.eds);
  if (!sheet) return tl::unexpected(sheet.error());
  const auto bus = open_can_bus(bus_options.config, bus_options.interface, can);
  if (!bus) return tl::unexpected(bus.error());
  const auto nodes = nodes_of(**bus, can);
  if (!nodes) return tl::unexpected(nodes.error());
  auto list = nlohmann::json::array();
  for (const auto node : *nodes) {
    const auto objects = objects_of(**bus, node, *sheet, only, options.quiet, *timeout);
    if (!objects) return tl::unexpected(objects.error());
    if (only && objects->empty()) return failed(fmt::format("node {}: there is no object 0x{:04X}", node, *only));
    if (options.json) {
      list.push_back({{"node", node}, {"objects", to_json(*objects)}});
      continue;
    }
    if (nodes->size() > 1) print_out("=== node {} ===\n", node);
    print_out("{}", to_text(*objects, options.verbose));
  }
  if (options.json) print_out("{}", json_text({{"nodes", list}}));
  return 0;
}

}  // namespace driveline::cli
