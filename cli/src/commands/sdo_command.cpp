#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "commands/can_tools.hpp"
#include "commands/commands.hpp"
#include "console.hpp"
#include "line/line_view.hpp"
#include "text/json_text.hpp"
#include "text/value_json.hpp"

namespace driveline::cli {
namespace {

/// Options that select an object of a slave and describe how its value is read or written.
struct ObjectOptions {
  runtime::BusOptions bus;
  CanOptions can;
  SlaveSelection selection;
  std::string index;
  std::string subindex;
  std::string type;   ///< empty: as in the slave's dictionary, or raw bytes if it has no type
  std::string value;  ///< download only
  bool force = false;
  bool complete = false;
  bool block = false;
  bool json = false;
};

struct ObjectAddress {
  std::uint16_t index = 0;
  std::uint8_t subindex = 0;
};

/// Adds a hint to the error: manuals write indices in hexadecimal, but "6041" is parsed as decimal.
tl::unexpected<Failure> object_failure(const ecat_master::Error& error, const ObjectOptions& options) {
  const auto* abort = error.as<ecat_master::facts::SdoAbort>();
  const bool decimal = options.index.size() == 4 && options.index.find_first_not_of("0123456789") == std::string::npos;
  if (abort == nullptr || abort->code != wire::SdoAbort::kObjectDoesNotExist || !decimal) return bus_failure(error);
  return failed(fmt::format("{}; {} is a decimal number, 0x{} or {}h a hexadecimal one", ecat_master::describe(error),
                            options.index, options.index, options.index));
}

Outcome<ObjectAddress> parse_address(const ObjectOptions& options) {
  if (auto checked = options.selection.check(); !checked) return tl::unexpected(checked.error());
  const auto index = parse_number(options.index, 0xFFFF, "index");
  if (!index) return tl::unexpected(index.error());
  const auto subindex = parse_number(options.subindex, 0xFF, "sub-index");
  if (!subindex) return tl::unexpected(subindex.error());
  if (options.complete && *subindex > 1) {
    return misused(fmt::format("sub-index {}: --complete begins at 0 or 1", *subindex));
  }
  return ObjectAddress{static_cast<std::uint16_t>(*index), static_cast<std::uint8_t>(*subindex)};
}

/// The common part of upload and download: a slave whose mailbox is open, and the object.
struct Dialogue {
  std::unique_ptr<LineView> line;
  ecat_master::MailboxClient* mailbox = nullptr;
  ObjectAddress address;
  runtime::ValueType type = runtime::ValueType::kRaw;  ///< requested type

  template <typename Ask>
  [[nodiscard]] auto ask(Ask&& ask) const {
    return line->ask(mailbox->slave().position, ask);
  }
  [[nodiscard]] nlohmann::json to_json(std::size_t bytes) const {
    return {{"slave", mailbox->slave().position},
            {"index", address.index},
            {"subindex", address.subindex},
            {"bytes", bytes}};
  }
};

/// The type on the command line, else the one in the slave's dictionary.
runtime::ValueType type_of(ecat_master::CoeClient& coe, const Dialogue& dialogue, const ObjectOptions& options) {
  if (!options.type.empty() || options.complete) return dialogue.type;
  const auto entry =
      dialogue.ask([&] { return coe.entry_description(dialogue.address.index, dialogue.address.subindex); });
  return entry ? runtime::value_type_of(entry->data_type).value_or(runtime::ValueType::kRaw) : runtime::ValueType::kRaw;
}

/// `writes`: a value is given, and is checked as far as possible before anything is opened.
Outcome<Dialogue> begin(const ObjectOptions& options, bool writes) {
  Dialogue dialogue;
  const auto address = parse_address(options);
  if (!address) return tl::unexpected(address.error());
  dialogue.address = *address;
  const auto type = runtime::parse_type(options.type);
  if (!type) return tl::unexpected(type.error());
  dialogue.type = *type;
  if (writes && !options.type.empty()) {
    if (auto value = runtime::parse_value(options.value, *type); !value) return tl::unexpected(value.error());
  }
  auto line = LineView::open(options.bus);
  if (!line) return tl::unexpected(line.error());
  dialogue.line = std::move(*line);
  const auto mailbox = dialogue.line->open_mailbox(options.selection, options.force);
  if (!mailbox) return tl::unexpected(mailbox.error());
  dialogue.mailbox = *mailbox;
  return dialogue;
}

/// Whether the object is on a CAN bus.
Outcome<bool> object_is_on_can(const ObjectOptions& options) {
  auto on_can = works_on_can(options.bus, options.can,
                             {{options.selection.positions.has_value(), "-p"},
                              {options.selection.alias.has_value(), "-a"},
                              {options.complete, "--complete"},
                              {options.force, "--force"}});
  if (on_can && !*on_can && options.block) return misused("--block is for CAN buses");
  return on_can;
}

CanObjectOptions can_object(const ObjectOptions& options) {
  return {options.index, options.subindex, options.type, options.value, options.block, options.json};
}

Outcome<int> upload(const ObjectOptions& options) {
  const auto on_can = object_is_on_can(options);
  if (!on_can) return tl::unexpected(on_can.error());
  if (*on_can) return upload_can(options.bus, options.can, can_object(options));
  const auto dialogue = begin(options, false);
  if (!dialogue) return tl::unexpected(dialogue.error());
  const auto& address = dialogue->address;
  ecat_master::CoeClient coe(*dialogue->mailbox);
  const auto data = dialogue->ask([&] { return coe.upload(address.index, address.subindex, options.complete); });
  if (!data) return object_failure(data.error(), options);
  auto shown = type_of(coe, *dialogue, options);
  // A wrong type in the slave's dictionary must not hide the value.
  if (options.type.empty() && runtime::type_bytes(shown) != 0 && runtime::type_bytes(shown) != data->size())
    shown = runtime::ValueType::kRaw;
  const auto text = runtime::format_value(*data, shown);
  if (!text) return failed(text.error().reason);
  if (options.json) {
    auto document = dialogue->to_json(data->size());
    document["value"] = *json_value(*data, shown);
    print_out("{}", json_text(document));
  } else {
    print_out("{}\n", *text);
  }
  return 0;
}

Outcome<int> download(const ObjectOptions& options) {
  const auto on_can = object_is_on_can(options);
  if (!on_can) return tl::unexpected(on_can.error());
  if (*on_can) return download_can(options.bus, options.can, can_object(options));
  const auto dialogue = begin(options, true);
  if (!dialogue) return tl::unexpected(dialogue.error());
  const auto& address = dialogue->address;
  ecat_master::CoeClient coe(*dialogue->mailbox);
  const auto data = runtime::parse_value(options.value, type_of(coe, *dialogue, options));
  if (!data) return tl::unexpected(data.error());
  auto done = coe.download(address.index, address.subindex, *data, options.complete);
  if (!done && done.error().is<ecat_master::facts::MailboxTimeout>() &&
      dialogue->line->shared(dialogue->mailbox->slave().position)) {
    // A retry might write twice.
    return failed(
        fmt::format("{}; the master that drives the slave may have received the answer: `upload` shows whether the "
                    "value was written",
                    ecat_master::describe(done.error())));
  }
  if (!done) return object_failure(done.error(), options);
  tell_what_ends(dialogue->line->session());
  if (options.json) print_out("{}", json_text(dialogue->to_json(data->size())));
  return 0;
}

std::shared_ptr<ObjectOptions> add_object_options(Arguments& to) {
  auto options = std::make_shared<ObjectOptions>();
  add_bus_options(to, options->bus);
  options->selection.add_single(to);
  options->can.add_single(to);
  to.option("-t,--type", &options->type, Value::choice("TYPE", runtime::type_names()),
            "uint8 ... int64, float, double, string, raw ...; default: the type in the slave's dictionary");
  to.flag("--block", options->block, "CAN bus: as a block transfer; nodes need not have it");
  to.flag("--complete", options->complete, "The whole object, from SUBINDEX 0 or 1 on, as bytes");
  add_force_flag(to, options->force);
  add_json_flag(to, options->json);
  to.required(&options->index, Value::text("INDEX"), "Index, e.g. 0x6041 or 6041h");
  to.required(&options->subindex, Value::text("SUBINDEX"), "Sub-index");
  return options;
}

}  // namespace

Execute prepare_upload(Arguments& to) {
  auto options = add_object_options(to);
  return [options] { return upload(*options); };
}

Execute prepare_download(Arguments& to) {
  auto options = add_object_options(to);
  to.required(&options->value, Value::text("VALUE"), "Value");
  return [options] { return download(*options); };
}

}  // namespace driveline::cli
