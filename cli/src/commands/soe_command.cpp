#include <fmt/format.h>

#include <fstream>
#include <iterator>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "commands/commands.hpp"
#include "console.hpp"
#include "driveline/ecat_master/soe/soe_client.hpp"
#include "driveline/ecat_master/soe/soe_log.hpp"
#include "driveline/ecat_master/soe/soe_value.hpp"
#include "driveline/esi/soe_start_list.hpp"
#include "line/line_view.hpp"
#include "text/json_text.hpp"
#include "text/soe_text.hpp"

namespace driveline::cli {
namespace {

using ecat_master::SoeClient;
using ecat_master::facts::SoeDatum;

/// S-0-0017, the IDNs of all operation data.
constexpr wire::Idn kListOfAll{17};
constexpr std::uint32_t kMaxDrive = 7;

struct SoeOptions {
  runtime::BusOptions bus;
  SlaveSelection selection;
  std::string drive = "0";
  std::string idn;                   ///< unused by `soe list`
  std::optional<std::string> value;  ///< `soe write` only
  bool execute = false;
  bool force = false;
  bool json = false;
};

Outcome<std::uint8_t> parse_drive(const SoeOptions& options) {
  if (auto checked = options.selection.check(); !checked) return tl::unexpected(checked.error());
  const auto drive = parse_number(options.drive, kMaxDrive, "drive");
  if (!drive) return tl::unexpected(drive.error());
  return static_cast<std::uint8_t>(*drive);
}

Outcome<SoeDatum> parse_datum(const SoeOptions& options) {
  const auto drive = parse_drive(options);
  if (!drive) return tl::unexpected(drive.error());
  if (const auto idn = wire::Idn::from_text(options.idn)) return SoeDatum{*drive, *idn};
  const auto number = parse_number(options.idn, 0xFFFF, "IDN");
  if (!number) return misused(fmt::format("IDN \"{}\": S-0-0017, P-0-0017 or a number is expected", options.idn));
  return SoeDatum{*drive, {static_cast<std::uint16_t>(*number)}};
}

/// A slave whose mailbox is open. At the end prints the notifications of its drives.
class SoeSlave {
 public:
  [[nodiscard]] static Outcome<std::unique_ptr<SoeSlave>> open(const SoeOptions& options) {
    auto line = LineView::open(options.bus);
    if (!line) return tl::unexpected(line.error());
    const auto mailbox = (*line)->open_mailbox(options.selection, options.force);
    if (!mailbox) return tl::unexpected(mailbox.error());
    return std::unique_ptr<SoeSlave>(new SoeSlave(std::move(*line), **mailbox));
  }
  SoeSlave(const SoeSlave&) = delete;
  SoeSlave& operator=(const SoeSlave&) = delete;
  ~SoeSlave() {
    for (const auto& record : line_->master().soe_messages().take()) {
      progress("slave {} {}", record.slave, describe_message(record));
    }
  }

  [[nodiscard]] LineView& line() noexcept { return *line_; }
  [[nodiscard]] SoeClient client() noexcept { return SoeClient(mailbox_); }
  /// Sends a read request; repeats it if the answer may have gone to another master.
  template <typename Ask>
  [[nodiscard]] auto ask(Ask&& ask) {
    return line_->ask(mailbox_.slave().position, ask);
  }
  /// A document that starts with the slave and the drive.
  [[nodiscard]] nlohmann::json document(std::uint8_t drive) const {
    return {{"slave", mailbox_.slave().position}, {"drive", drive}};
  }

 private:
  SoeSlave(std::unique_ptr<LineView> line, ecat_master::MailboxClient& mailbox)
      : line_(std::move(line)), mailbox_(mailbox) {}

  std::unique_ptr<LineView> line_;
  ecat_master::MailboxClient& mailbox_;
};

Outcome<int> read_datum(const SoeOptions& options) {
  const auto datum = parse_datum(options);
  if (!datum) return tl::unexpected(datum.error());
  auto slave = SoeSlave::open(options);
  if (!slave) return tl::unexpected(slave.error());
  const auto parameter = (*slave)->ask([&] { return (*slave)->client().parameter(*datum); });
  if (!parameter) return bus_failure(parameter.error());
  if (options.json) {
    auto document = (*slave)->document(datum->drive);
    document.update(soe_parameter_json(datum->idn, *parameter));
    print_out("{}", json_text(document));
  } else {
    print_out("{}", soe_parameter_text(datum->idn, *parameter));
  }
  return 0;
}

Outcome<int> write_datum(const SoeOptions& options) {
  const auto datum = parse_datum(options);
  if (!datum) return tl::unexpected(datum.error());
  if (options.execute == options.value.has_value())
    return misused("give a VALUE, or --execute for a procedure command");
  auto slave = SoeSlave::open(options);
  if (!slave) return tl::unexpected(slave.error());
  auto client = (*slave)->client();
  const auto attribute = (*slave)->ask([&] { return client.attribute(*datum); });
  if (!attribute) return bus_failure(attribute.error());
  if (options.execute && !attribute->command) {
    return failed(fmt::format("{} is not a procedure command", idn_text(datum->idn)));
  }
  const auto value = options.execute ? std::vector<std::byte>{} : parse_soe_value(*options.value, *attribute);
  if (!value) return tl::unexpected(value.error());
  const auto done = options.execute ? client.execute(*datum) : client.write_value(*datum, *value);
  if (!done) return bus_failure(done.error());
  tell_what_ends((*slave)->line().session());
  if (options.json) {
    auto document = (*slave)->document(datum->drive);
    document["idn"] = idn_text(datum->idn);
    print_out("{}", json_text(document));
  }
  return 0;
}

Outcome<int> list_data(const SoeOptions& options) {
  const auto drive = parse_drive(options);
  if (!drive) return tl::unexpected(drive.error());
  auto slave = SoeSlave::open(options);
  if (!slave) return tl::unexpected(slave.error());
  auto client = (*slave)->client();
  const auto idns = (*slave)->ask([&] { return client.idn_list({*drive, kListOfAll}); });
  if (!idns) return bus_failure(idns.error());
  auto document = (*slave)->document(*drive);
  document["idns"] = nlohmann::json::array();
  for (const auto idn : *idns) {
    const auto parameter = (*slave)->ask([&] { return client.parameter({*drive, idn}); });
    if (!parameter && parameter.error().is<ecat_master::facts::SoeRefused>()) {
      progress("left out: {}", describe(parameter.error()));
      continue;
    }
    if (!parameter) return bus_failure(parameter.error());
    if (options.json) {
      document["idns"].push_back(soe_parameter_json(idn, *parameter));
    } else {
      print_out("{}\n", soe_line_text(idn, *parameter));
    }
  }
  if (options.json) print_out("{}", json_text(document));
  return 0;
}

struct ImportOptions {
  std::string file;
  std::optional<std::string> drive;
};

/// The bytes as "0A 00", the number as "S-0-0044", and a comment that stays in its line.
std::string idn_table_text(const esi::SoeStartEntry& entry) {
  auto text = fmt::format("\n[[slave.idn]]{}\ndrive = {}\nnumber = \"{}\"\ndata = \"{}\"\n",
                          entry.comment.empty() ? std::string{} : "  # " + ecat_master::printable(entry.comment),
                          entry.drive, idn_text({entry.idn}), ecat_master::hex_digits(entry.data));
  if (entry.before_op) text += "transition = \"SO\"\n";
  return text;
}

Outcome<int> import_list(const ImportOptions& options) {
  std::optional<std::uint32_t> only;
  if (options.drive) {
    const auto drive = parse_number(*options.drive, kMaxDrive, "drive");
    if (!drive) return tl::unexpected(drive.error());
    only = *drive;
  }
  std::ifstream file(options.file, std::ios::binary);
  if (!file) return misused(fmt::format("{}: cannot be read", options.file));
  const std::string content{std::istreambuf_iterator<char>(file), {}};
  auto list = esi::read_soe_start_list(content);
  if (!list) return misused(fmt::format("{}: {}", options.file, describe(list.error())));
  std::size_t taken = 0;
  std::size_t others = 0;
  for (const auto& entry : list->entries) {
    if (only && entry.drive != *only) {
      ++others;
      progress("left out: {} of drive {}", idn_text({entry.idn}), entry.drive);
      continue;
    }
    ++taken;
    print_out("{}", idn_table_text(entry));
  }
  for (const auto& left : list->left_out)
    progress("left out: {}:{}: {}: {}", options.file, left.line, left.what, left.why);
  progress("{} taken over, {} left out", taken, others + list->left_out.size());
  if (taken == 0) return failed(fmt::format("{}: nothing can be taken over", options.file));
  return 0;
}

std::shared_ptr<SoeOptions> add_soe_options(Arguments& to) {
  auto options = std::make_shared<SoeOptions>();
  add_bus_options(to, options->bus);
  options->selection.add_single(to);
  to.option("--drive", &options->drive, Value::text("NUMBER"), "Drive of the slave, 0 to 7; default: 0");
  add_force_flag(to, options->force);
  add_json_flag(to, options->json);
  return options;
}

constexpr std::string_view kIdnHelp = "Operation datum, e.g. S-0-0100, P-0-0017 or 0x8011";

}  // namespace

Execute prepare_soe_read(Arguments& to) {
  auto options = add_soe_options(to);
  to.required(&options->idn, Value::text("IDN"), kIdnHelp);
  return [options] { return read_datum(*options); };
}

Execute prepare_soe_write(Arguments& to) {
  auto options = add_soe_options(to);
  to.flag("--execute", options->execute, "Execute the procedure command and wait for its end");
  to.required(&options->idn, Value::text("IDN"), kIdnHelp);
  to.positional(&options->value, Value::text("VALUE"), "Value; the elements of a list are separated by commas");
  return [options] { return write_datum(*options); };
}

Execute prepare_soe_import(Arguments& to) {
  auto options = std::make_shared<ImportOptions>();
  to.required(&options->file, Value::file(), "Start-up list in XML, as TwinCAT exports it");
  to.option("--drive", &options->drive, Value::text("NUMBER"), "Only the operation data of this drive, 0 to 7");
  return [options] { return import_list(*options); };
}

Execute prepare_soe_list(Arguments& to) {
  auto options = add_soe_options(to);
  return [options] { return list_data(*options); };
}

}  // namespace driveline::cli
