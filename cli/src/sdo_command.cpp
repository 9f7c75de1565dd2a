#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "commands.hpp"
#include "json_text.hpp"
#include "tool_options.hpp"
#include "typed_value.hpp"

namespace driveline::cli {
namespace {

using ecat_master::Master;

/// An object of a slave, and how its value is to be read or written.
struct ObjectOptions {
  BusOptions bus;
  SlaveSelection selection;
  std::string index;
  std::string subindex;
  std::string type;   ///< empty: raw bytes
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
  const auto data = ecat_master::CoeClient(**mailbox).upload(address->index, address->subindex);
  if (!data) return bus_failure(data.error());
  const auto text = format_value(*data, *type);
  if (!text) return failed(text.error());
  if (options.json) {
    fmt::print("{}", json_text({{"slave", (*mailbox)->slave().position},
                                {"index", address->index},
                                {"subindex", address->subindex},
                                {"bytes", data->size()},
                                {"value", *json_value(*data, *type)}}));
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
  const auto data = parse_value(options.value, *type);
  if (!data) return misused(data.error());
  auto session = Session::open(options.bus);
  if (!session) return tl::unexpected(session.error());
  Master master((*session)->port(), (*session)->clock());
  auto mailbox = open_mailbox(master, options.selection);
  if (!mailbox) return tl::unexpected(mailbox.error());
  auto done = ecat_master::CoeClient(**mailbox).download(address->index, address->subindex, *data);
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
            "uint8 ... int64, float, double, string; default: raw bytes in hex");
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
