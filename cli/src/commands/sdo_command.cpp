#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "commands/commands.hpp"
#include "commands/tool_options.hpp"
#include "text/json_text.hpp"
#include "text/typed_value.hpp"

namespace driveline::cli {
namespace {

using ecat_master::Master;

/// An object of a slave, and how its value is to be read or written.
struct ObjectOptions {
  BusOptions bus;
  SlaveSelection selection;
  std::string index;
  std::string subindex;
  std::string type;   ///< empty: as the slave's dictionary says, raw bytes when it says nothing
  std::string value;  ///< download only
  bool json = false;
};

struct ObjectAddress {
  std::uint16_t index = 0;
  std::uint8_t subindex = 0;
};

Outcome<ObjectAddress> parse_address(const ObjectOptions& options) {
  if (auto checked = options.selection.check(); !checked) return tl::unexpected(checked.error());
  const auto index = parse_number(options.index, 0xFFFF, "index");
  if (!index) return tl::unexpected(index.error());
  const auto subindex = parse_number(options.subindex, 0xFF, "sub-index");
  if (!subindex) return tl::unexpected(subindex.error());
  return ObjectAddress{static_cast<std::uint16_t>(*index), static_cast<std::uint8_t>(*subindex)};
}

/// A slave in PREOP, ready for SDO transfers.
Outcome<ecat_master::MailboxClient*> open_mailbox(Master& master, const SlaveSelection& selection) {
  if (auto done = master.scan(); !done) return bus_failure(done.error());
  std::vector<std::uint16_t> aliases;
  for (const auto& slave : master.slaves()) aliases.push_back(slave.info.alias);
  const auto slave = selection.select_one(aliases, false);
  if (!slave) return tl::unexpected(slave.error());
  if (auto done = master.enter_pre_op(); !done) return bus_failure(done.error());
  auto* mailbox = master.mailbox(*slave);
  if (mailbox == nullptr) return failed(fmt::format("slave {} has no mailbox", *slave));
  return mailbox;
}

/// The type that was asked for, or what the slave says about the entry.
ValueType type_of(ecat_master::CoeClient& coe, const ObjectAddress& at, const ObjectOptions& options, ValueType asked) {
  if (!options.type.empty()) return asked;
  const auto entry = coe.entry_description(at.index, at.subindex);
  return entry ? value_type_of(entry->data_type).value_or(ValueType::kRaw) : ValueType::kRaw;
}

Outcome<int> upload(const ObjectOptions& options) {
  const auto address = parse_address(options);
  if (!address) return tl::unexpected(address.error());
  const auto type = parse_type(options.type);
  if (!type) return misused(type.error());
  auto session = Session::open(options.bus);
  if (!session) return tl::unexpected(session.error());
  Master master((*session)->port(), (*session)->clock());
  auto mailbox = open_mailbox(master, options.selection);
  if (!mailbox) return tl::unexpected(mailbox.error());
  ecat_master::CoeClient coe(**mailbox);
  const auto data = coe.upload(address->index, address->subindex);
  if (!data) return bus_failure(data.error());
  auto shown = type_of(coe, *address, options, *type);
  // What a slave says about its types is no reason to hide the value.
  if (options.type.empty() && type_bytes(shown) != 0 && type_bytes(shown) != data->size()) shown = ValueType::kRaw;
  const auto text = format_value(*data, shown);
  if (!text) return failed(text.error());
  if (options.json) {
    fmt::print("{}", json_text({{"slave", (*mailbox)->slave().position},
                                {"index", address->index},
                                {"subindex", address->subindex},
                                {"bytes", data->size()},
                                {"value", *json_value(*data, shown)}}));
  } else {
    fmt::print("{}\n", *text);
  }
  return 0;
}

Outcome<int> download(const ObjectOptions& options) {
  const auto address = parse_address(options);
  if (!address) return tl::unexpected(address.error());
  const auto type = parse_type(options.type);
  if (!type) return misused(type.error());
  if (!options.type.empty()) {  // what can be found wrong before anything is opened
    if (auto value = parse_value(options.value, *type); !value) return misused(value.error());
  }
  auto session = Session::open(options.bus);
  if (!session) return tl::unexpected(session.error());
  Master master((*session)->port(), (*session)->clock());
  auto mailbox = open_mailbox(master, options.selection);
  if (!mailbox) return tl::unexpected(mailbox.error());
  ecat_master::CoeClient coe(**mailbox);
  const auto data = parse_value(options.value, type_of(coe, *address, options, *type));
  if (!data) return misused(data.error());
  auto done = coe.download(address->index, address->subindex, *data);
  if (!done) return bus_failure(done.error());
  if (options.json) {
    fmt::print("{}", json_text({{"slave", (*mailbox)->slave().position},
                                {"index", address->index},
                                {"subindex", address->subindex},
                                {"bytes", data->size()}}));
  }
  return 0;
}

std::shared_ptr<ObjectOptions> add_object_options(Arguments& to) {
  auto options = std::make_shared<ObjectOptions>();
  add_bus_options(to, options->bus);
  options->selection.add_single(to);
  to.option("-t,--type", &options->type, Value::choice("TYPE", type_names()),
            "uint8 ... int64, float, double, string, raw ...; default: what the slave's dictionary says");
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
