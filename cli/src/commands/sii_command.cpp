#include <fmt/format.h>
#include <unistd.h>
#include <cstdio>

#include "commands/commands.hpp"
#include "console.hpp"
#include "driveline/ecat_master/sii/sii_writer.hpp"
#include "driveline/esi/esi_file.hpp"
#include "driveline/esi/sii_difference.hpp"
#include "driveline/rt/stop_signals.hpp"
#include "driveline/runtime/files/input_file.hpp"
#include "driveline/runtime/files/output_file.hpp"
#include "line/line_view.hpp"
#include "text/json_text.hpp"
#include "text/pdo_view.hpp"
#include "text/sii_dump.hpp"
#include "text/sii_text.hpp"

namespace driveline::cli {
namespace {

struct SiiOptions {
  runtime::BusOptions bus;
  SlaveSelection selection;
  std::string file;  ///< input or output file, depending on the command
  std::string alias;
  bool verbose = false;
  bool force = false;
  bool json = false;
};

Outcome<std::string> read_binary_file(const std::string& name) {
  auto content = runtime::read_input_file(name);
  if (!content) return tl::unexpected(content.error());
  if (content->empty()) return misused(fmt::format("{}: is empty", name));
  return std::move(*content);
}

std::vector<std::byte> bytes_of(const std::string& text) {
  std::vector<std::byte> bytes;
  for (const char c : text) bytes.push_back(static_cast<std::byte>(c));
  return bytes;
}

std::string text_of(std::span<const std::byte> bytes) {
  std::string text;
  for (const auto byte : bytes) text += static_cast<char>(byte);
  return text;
}

/// A line with one selected slave and the content of its EEPROM.
struct Chosen {
  std::unique_ptr<LineView> line;
  SlaveView view;
};

Outcome<Chosen> choose(const SiiOptions& options, bool explicitly) {
  if (auto checked = options.selection.check(); !checked) return tl::unexpected(checked.error());
  auto line = LineView::open(options.bus);
  if (!line) return tl::unexpected(line.error());
  const auto slave = (*line)->select_one(options.selection, explicitly);
  if (!slave) return tl::unexpected(slave.error());
  const std::size_t position = slave->position;
  auto views = (*line)->read({&position, 1});
  return Chosen{std::move(*line), std::move(views.front())};
}

tl::unexpected<Failure> trouble(const SlaveView& view) {
  return failed(view.trouble);
}

std::string describe_image(const esi::SiiImage& sii) {
  std::string text = fmt::format("EEPROM: {} bytes, checksum {}\nAlias: {}\n", sii.eeprom_bytes(),
                                 sii.checksum_valid() ? "valid" : "WRONG", sii.config.station_alias);
  const auto channels = pdos_from_sii(sii);
  return text + identity_text(sii) + mailbox_and_general_text(sii) + to_text(channels) + fmmu_and_clock_text(sii);
}

Outcome<int> read_image(const SiiOptions& options) {
  const bool binary = !options.verbose && !options.json;
  if (binary && options.file.empty() && isatty(STDOUT_FILENO) != 0) {
    return misused("an EEPROM image is binary: give --output FILE, redirect the output, or use -v");
  }
  auto chosen = choose(options, false);
  if (!chosen) return tl::unexpected(chosen.error());
  const auto& view = chosen->view;
  if (view.image.empty()) return trouble(view);
  if (!options.file.empty()) {
    if (auto done = runtime::write_file(options.file, text_of(view.image)); !done) return tl::unexpected(done.error());
  } else if (binary) {
    std::fwrite(view.image.data(), 1, view.image.size(), stdout);
  }
  if (!binary && !view.sii) {
    // An image that cannot be decoded can still be dumped.
    if (options.verbose) print_out("{}", sii_dump(view.image));
    return trouble(view);
  }
  if (options.json) {
    auto document = to_json(*view.sii);
    document["position"] = view.slave.ref.position;
    document["bytes"] = view.image.size();
    print_out("{}", json_text(document));
  } else if (options.verbose) {
    print_out("{}\n{}", describe_image(*view.sii), sii_dump(view.image));
  }
  if (!view.trouble.empty()) progress("{}", view.trouble);
  return 0;
}

/// Refuses an image that must not be written without --force.
Outcome<void> check_image(const esi::SiiImage& image, const SlaveView& view, const std::string& file) {
  if (!image.checksum_valid()) {
    return failed(
        fmt::format("{}: the checksum of the configuration area is wrong: the slave would not start with this image; "
                    "--force writes it anyway",
                    file));
  }
  const auto state = view.slave.al.status.state;
  if (state != wire::AlState::kInit && state != wire::AlState::kPreOp) {
    return failed(
        fmt::format("slave {} is in {}: EEPROMs are written in INIT or PREOP, `driveline states INIT` takes the "
                    "line there; --force writes it anyway",
                    view.slave.ref.position, wire::to_text(state)));
  }
  if (!view.sii) return {};  // the slave has no usable content that could be lost
  if (view.sii->vendor_id != image.vendor_id || view.sii->product_code != image.product_code) {
    return failed(
        fmt::format("{}: is for vendor 0x{:08X}, product 0x{:08X}, slave {} is vendor 0x{:08X}, product 0x{:08X}; "
                    "--force writes it anyway",
                    file, image.vendor_id, image.product_code, view.slave.ref.position, view.sii->vendor_id,
                    view.sii->product_code));
  }
  return {};
}

/// Saves the previous content if it could not be restored: this is then the only copy.
std::string save_previous(const ecat_master::SiiWriteFailure& failure, std::size_t position) {
  const auto file = fmt::format("sii-slave{}-before.bin", position);
  const auto saved = runtime::write_file(file, text_of(failure.previous));
  return saved ? fmt::format("; its previous content is in {}", file) : "; " + runtime::describe(saved.error());
}

/// Reports the progress of a write in steps of ten per cent, and stops it on a signal.
ecat_master::SiiProgress make_progress(std::size_t position) {
  return [position, told = std::size_t{0}](std::size_t done, std::size_t total) mutable {
    const std::size_t percent = total == 0 ? 100 : 100 * done / total;
    if (percent >= told + 10) {
      told = percent;
      progress("slave {}: {} of {} words written", position, done, total);
    }
    return !rt::stop_requested();
  };
}

Outcome<int> finish_write(const tl::expected<ecat_master::SiiWriteReport, ecat_master::SiiWriteFailure>& written,
                          const SiiOptions& options, const Chosen& chosen) {
  const std::size_t position = chosen.view.slave.ref.position;
  if (!written) {
    auto text = ecat_master::describe(written.error());
    if (!written.error().left.empty()) text += save_previous(written.error(), position);
    return failed(text);
  }
  tell_what_ends(chosen.line->session());
  if (options.json) {
    print_out("{}", json_text({{"slave", position},
                               {"words_changed", written->words_changed},
                               {"words_unchanged", written->words_unchanged}}));
  } else {
    print_out("slave {}: {} words changed, {} unchanged, all read back; in effect after the next power-on\n", position,
              written->words_changed, written->words_unchanged);
  }
  return 0;
}

Outcome<int> write_image(const SiiOptions& options) {
  const auto content = read_binary_file(options.file);
  if (!content) return tl::unexpected(content.error());
  const auto bytes = bytes_of(*content);
  const auto image = esi::decode_sii(bytes);
  if (!image) return misused(fmt::format("{}: {}", options.file, esi::to_text(image.error())));
  auto chosen = choose(options, true);
  if (!chosen) return tl::unexpected(chosen.error());
  if (!options.force) {
    if (auto checked = check_image(*image, chosen->view, options.file); !checked)
      return tl::unexpected(checked.error());
  }
  rt::catch_stop_signals();
  const auto slave = chosen->view.slave.ref;
  return finish_write(ecat_master::write_sii(chosen->line->bus(), slave, bytes, make_progress(slave.position)), options,
                      *chosen);
}

Outcome<int> set_alias(const SiiOptions& options) {
  const auto alias = parse_number(options.alias, 0xFFFF, "alias");
  if (!alias) return tl::unexpected(alias.error());
  auto chosen = choose(options, true);
  if (!chosen) return tl::unexpected(chosen.error());
  const auto slave = chosen->view.slave.ref;
  if (auto free = chosen->line->must_not_be_used(slave.position, options.force, "write its EEPROM"); !free) {
    return tl::unexpected(free.error());
  }
  for (const auto& other : chosen->line->slaves()) {
    if (*alias != 0 && other.alias == *alias && other.ref.position != slave.position) {
      return failed(fmt::format("slave {} already has the alias address {}", other.ref.position, *alias));
    }
  }
  return finish_write(ecat_master::write_alias(chosen->line->bus(), slave, static_cast<std::uint16_t>(*alias)), options,
                      *chosen);
}

Outcome<int> compare_image(const SiiOptions& options) {
  const auto text = read_binary_file(options.file);
  if (!text) return tl::unexpected(text.error());
  const auto file = esi::read_esi(*text, options.file);
  if (!file) return misused(esi::to_text(file.error()));
  auto chosen = choose(options, false);
  if (!chosen) return tl::unexpected(chosen.error());
  const auto& view = chosen->view;
  if (!view.sii) return trouble(view);
  const auto& sii = *view.sii;
  const auto* device = file->find_device(sii.vendor_id, sii.product_code, sii.revision);
  if (device == nullptr) {
    return failed(fmt::format("{}: has no device of vendor 0x{:08X}, product 0x{:08X}, revision 0x{:08X}", options.file,
                              sii.vendor_id, sii.product_code, sii.revision));
  }
  const auto differences = esi::compare_sii(sii, esi::make_sii(*device));
  if (options.json) {
    auto rows = nlohmann::json::array();
    for (const auto& difference : differences) {
      rows.push_back({{"what", difference.what}, {"found", difference.found}, {"planned", difference.planned}});
    }
    print_out("{}", json_text({{"slave", view.slave.ref.position}, {"differences", rows}}));
  } else {
    for (const auto& difference : differences) {
      print_out("{}: {}, in the file {}\n", difference.what, difference.found, difference.planned);
    }
    if (differences.empty()) print_out("slave {}: matches {}\n", view.slave.ref.position, options.file);
  }
  if (differences.empty()) return 0;
  return failed(fmt::format("slave {}: {} difference{} from {}", view.slave.ref.position, differences.size(),
                            differences.size() == 1 ? "" : "s", options.file));
}

std::shared_ptr<SiiOptions> add_common(Arguments& to) {
  auto options = std::make_shared<SiiOptions>();
  add_bus_options(to, options->bus);
  options->selection.add_single(to);
  add_json_flag(to, options->json);
  return options;
}

}  // namespace

Execute prepare_sii_read(Arguments& to) {
  auto options = add_common(to);
  to.option("-o,--output", &options->file, Value::file(), "Write the image to this file, not to stdout");
  to.flag("-v,--verbose", options->verbose, "Print the decoded image, and its bytes by category");
  return [options] { return read_image(*options); };
}

Execute prepare_sii_write(Arguments& to) {
  auto options = add_common(to);
  to.flag("-f,--force", options->force, "Write even if checksum or identity do not match");
  to.required(&options->file, Value::file(), "EEPROM image");
  return [options] { return write_image(*options); };
}

Execute prepare_sii_compare(Arguments& to) {
  auto options = add_common(to);
  to.required(&options->file, Value::file(), "ESI file (XML)");
  return [options] { return compare_image(*options); };
}

Execute prepare_sii_alias(Arguments& to) {
  auto options = add_common(to);
  add_force_flag(to, options->force);
  to.required(&options->alias, Value::text("ALIAS"), "New alias address, 0: none");
  return [options] { return set_alias(*options); };
}

}  // namespace driveline::cli
