#include <fmt/format.h>

#include "commands/commands.hpp"
#include "console.hpp"
#include "line/line_view.hpp"
#include "text/json_text.hpp"
#include "text/register_name.hpp"
#include "text/value_json.hpp"

namespace driveline::cli {
namespace {

/// Most bytes of an access, which uses one datagram.
constexpr std::uint32_t kMaxBytes = 1024;

struct RegOptions {
  runtime::BusOptions bus;
  SlaveSelection selection;
  std::string address;
  std::optional<std::string> size;  ///< read only
  std::string type;
  std::string value;   ///< write only
  bool force = false;  ///< write only
  bool json = false;
};

/// Register, slaves and type of an access.
struct Access {
  RegisterAddress at;
  runtime::ValueType type = runtime::ValueType::kRaw;
  std::size_t bytes = 0;
};

runtime::ValueType unsigned_type(std::size_t bytes) {
  switch (bytes) {
    case 1:
      return runtime::ValueType::kUint8;
    case 2:
      return runtime::ValueType::kUint16;
    case 4:
      return runtime::ValueType::kUint32;
    case 8:
      return runtime::ValueType::kUint64;
    default:
      return runtime::ValueType::kRaw;
  }
}

/// The size is the given one, else that of the type, else that of the register.
Outcome<Access> parse_access(const RegOptions& options) {
  if (auto checked = options.selection.check(); !checked) return tl::unexpected(checked.error());
  const auto at = find_register(options.address);
  if (!at) return tl::unexpected(at.error());
  const auto type = runtime::parse_type(options.type);
  if (!type) return tl::unexpected(type.error());
  Access access{*at, *type, at->bytes};
  if (runtime::type_bytes(*type) != 0) access.bytes = runtime::type_bytes(*type);
  if (options.size) {
    const auto size = parse_number(*options.size, kMaxBytes, "size");
    if (!size) return tl::unexpected(size.error());
    if (*size == 0) return misused("size \"0\": 1 to 1024 bytes are expected");
    if (runtime::type_bytes(*type) != 0 && *size != runtime::type_bytes(*type)) {
      return misused(fmt::format("size {}: {} has {} bytes", *size, options.type, runtime::type_bytes(*type)));
    }
    access.bytes = *size;
  } else if (options.type.empty()) {
    access.type = unsigned_type(access.bytes);
  }
  return access;
}

std::string name_of(const RegisterAddress& at) {
  return at.row == nullptr ? fmt::format("address 0x{:04X}", at.address)
                           : fmt::format("register 0x{:04X} ({})", at.address, at.row->name);
}

/// Distinguishes a slave that does not answer from a slave that refuses the access.
tl::unexpected<Failure> access_failure(const ecat_master::Error& error, const RegisterAddress& at, bool write) {
  if (!error.is<ecat_master::facts::WorkingCounter>()) return bus_failure(error);
  const bool refused = write && at.row != nullptr && at.row->ecat == wire::RegisterAccess::kRead;
  return failed(fmt::format("slave {}: does not allow the master to {} {}{}", error.slave, write ? "write" : "read",
                            name_of(at), refused ? ", which is read-only" : ""));
}

Outcome<int> read_register(const RegOptions& options) {
  const auto access = parse_access(options);
  if (!access) return tl::unexpected(access.error());
  if (access->bytes == 0) {
    return misused(fmt::format("{}: the size is unknown: give SIZE or --type", name_of(access->at)));
  }
  auto line = LineView::open(options.bus);
  if (!line) return tl::unexpected(line.error());
  const auto positions = (*line)->select(options.selection);
  if (!positions) return tl::unexpected(positions.error());
  auto rows = nlohmann::json::array();
  std::string text;
  for (const auto position : *positions) {
    std::vector<std::byte> data(access->bytes);
    auto done = (*line)->bus().read((*line)->slaves()[position].ref, access->at.address, data);
    if (!done) return access_failure(done.error(), access->at, false);
    const auto value = runtime::format_value(data, access->type);
    if (!value) return failed(value.error().reason);
    if (positions->size() > 1) text += fmt::format("{:>4}  ", position);
    text += *value + "\n";
    rows.push_back({{"position", position}, {"value", *json_value(data, access->type)}});
  }
  if (options.json) {
    nlohmann::json document = {{"address", access->at.address}, {"bytes", access->bytes}, {"slaves", rows}};
    document["name"] = access->at.row == nullptr ? nlohmann::json() : nlohmann::json(access->at.row->name);
    text = json_text(document);
  }
  print_out("{}", text);
  return 0;
}

Outcome<int> write_register(const RegOptions& options) {
  const auto access = parse_access(options);
  if (!access) return tl::unexpected(access.error());
  const auto data = runtime::parse_value(options.value, access->type);
  if (!data) return tl::unexpected(data.error());
  if (data->empty()) return misused("value \"\": bytes are expected");
  auto line = LineView::open(options.bus);
  if (!line) return tl::unexpected(line.error());
  const auto slave = (*line)->select_one(options.selection, true);
  if (!slave) return tl::unexpected(slave.error());
  if (auto free = (*line)->must_not_be_used(slave->position, options.force, "change its registers"); !free) {
    return tl::unexpected(free.error());
  }
  auto done = (*line)->bus().write(*slave, access->at.address, *data);
  if (!done) return access_failure(done.error(), access->at, true);
  tell_what_ends((*line)->session());
  if (options.json) {
    print_out("{}", json_text({{"slave", slave->position}, {"address", access->at.address}, {"bytes", data->size()}}));
  }
  return 0;
}

std::shared_ptr<RegOptions> add_common(Arguments& to, bool write) {
  auto options = std::make_shared<RegOptions>();
  add_bus_options(to, options->bus);
  if (write) {
    options->selection.add_single(to);
  } else {
    options->selection.add(to);
  }
  to.option("-t,--type", &options->type, Value::choice("TYPE", runtime::type_names()),
            "Type of the value; default: unsigned, with the size of the register");
  add_json_flag(to, options->json);
  to.required(&options->address, Value::text("REGISTER"), "Address, e.g. 0x0130, or name, e.g. al_status or fmmu[1]");
  return options;
}

}  // namespace

Execute prepare_reg_read(Arguments& to) {
  auto options = add_common(to, false);
  to.positional(&options->size, Value::text("SIZE"), "Number of bytes; default: size of the register or the type");
  return [options] { return read_register(*options); };
}

Execute prepare_reg_write(Arguments& to) {
  auto options = add_common(to, true);
  add_force_flag(to, options->force);
  to.required(&options->value, Value::text("VALUE"), "Value");
  return [options] { return write_register(*options); };
}

Execute prepare_reg_list(Arguments&) {
  return []() -> Outcome<int> {
    print_out("{}", register_table());
    return 0;
  };
}

}  // namespace driveline::cli
