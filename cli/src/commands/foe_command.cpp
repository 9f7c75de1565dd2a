#include <fmt/format.h>
#include <unistd.h>

#include <array>
#include <cstdio>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "commands/commands.hpp"
#include "console.hpp"
#include "driveline/ecat_master/configuration/configurator.hpp"
#include "driveline/ecat_master/discovery/discovery.hpp"
#include "driveline/ecat_master/foe/foe_client.hpp"
#include "driveline/ecat_master/state_machine.hpp"
#include "driveline/rt/stop_signals.hpp"
#include "driveline/runtime/files/input_file.hpp"
#include "driveline/runtime/files/output_file.hpp"
#include "line/line_view.hpp"
#include "line/mailbox_registers.hpp"
#include "progress_bar.hpp"
#include "text/json_text.hpp"

namespace driveline::cli {
namespace {

using ecat_master::FileTransfer;
using ecat_master::FoeClient;

struct FoeOptions {
  runtime::BusOptions bus;
  SlaveSelection selection;
  std::string source;  ///< file on the slave when reading, on this machine when writing
  std::string target;  ///< the opposite; empty: not given
  std::string password;
  bool boot = false;
  bool force = false;
  bool json = false;
};

/// A slave whose mailbox is open. If this command took it to BOOT, leave() takes it back to INIT.
class FileSlave {
 public:
  explicit FileSlave(std::unique_ptr<LineView> line) : line_(std::move(line)) {}
  FileSlave(const FileSlave&) = delete;
  FileSlave& operator=(const FileSlave&) = delete;

  [[nodiscard]] Outcome<void> open(const FoeOptions& options);
  /// Takes the slave from BOOT to INIT, which restarts it.
  [[nodiscard]] Outcome<void> leave();
  /// Waits for the end of the transfer; a signal aborts it.
  void wait(const std::shared_ptr<FileTransfer>& transfer);

  [[nodiscard]] LineView& line() noexcept { return *line_; }
  [[nodiscard]] FoeClient client() { return {line_->master().mailboxes(), slave_.position}; }
  [[nodiscard]] std::size_t position() const noexcept { return slave_.position; }

 private:
  [[nodiscard]] Outcome<void> enter_boot(bool force);
  [[nodiscard]] Outcome<void> use_boot();

  std::unique_ptr<LineView> line_;
  ecat_master::SlaveRef slave_;
  std::unique_ptr<ecat_master::MailboxClient> mailbox_;
  bool booted_ = false;
};

Outcome<void> FileSlave::open(const FoeOptions& options) {
  const auto slave = line_->select_one(options.selection, false);
  if (!slave) return tl::unexpected(slave.error());
  slave_ = *slave;
  const auto state = line_->slaves()[slave_.position].al.status.state;
  if (options.boot && state != wire::AlState::kBootstrap) return enter_boot(options.force);
  if (state == wire::AlState::kBootstrap) return use_boot();
  return line_->open_mailbox(options.selection, options.force).map([](auto*) {});
}

Outcome<void> FileSlave::enter_boot(bool force) {
  if (auto free = line_->must_not_be_used(slave_.position, force, "take it to BOOT"); !free) return free;
  const auto found = ecat_master::inspect(line_->bus(), std::array{slave_});
  if (!found) return bus_failure(found.error());
  auto mailbox = ecat_master::enter_bootstrap(line_->master().mailboxes(), found->front());
  if (!mailbox) return bus_failure(mailbox.error());
  mailbox_ = std::move(*mailbox);
  booted_ = true;
  return {};
}

/// Uses the mailbox as configured by the program that took the slave to BOOT. The slave drops a message with the
/// counter of the previous one, which is unknown here: a file without a name is requested until any answer arrives.
Outcome<void> FileSlave::use_boot() {
  constexpr int kRequests = 2;
  const auto window = read_mailbox_window(line_->bus(), slave_);
  if (!window) return tl::unexpected(window.error());
  if (!*window) return failed(fmt::format("slave {} has no mailbox", slave_.position));
  mailbox_ = std::make_unique<ecat_master::MailboxClient>(line_->master().mailboxes(), slave_, **window);
  ecat_master::FileSettings settings;
  settings.timeout = std::chrono::milliseconds{100};
  for (int attempt = 0; attempt < kRequests; ++attempt) {
    const auto answer = client().read({}, settings);
    if (answer || !answer.error().error.is<ecat_master::facts::MailboxTimeout>()) break;
  }
  return {};
}

Outcome<void> FileSlave::leave() {
  if (!booted_) return {};
  const auto done =
      ecat_master::change_state(line_->bus(), std::array{slave_}, wire::AlState::kInit, ecat_master::kOpTimeout);
  if (!done) return bus_failure(done.error());
  return {};
}

void FileSlave::wait(const std::shared_ptr<FileTransfer>& transfer) {
  auto& engine = line_->master().mailboxes();
  ProgressBar bar;
  while (!transfer->done()) {
    if (rt::stop_requested()) engine.close(slave_.position);
    engine.drive();
    bar.show(transfer->transferred(), transfer->size());
  }
}

/// Checks all options before anything is opened.
Outcome<std::uint32_t> check(const FoeOptions& options) {
  if (auto checked = options.selection.check(); !checked) return tl::unexpected(checked.error());
  if (options.boot && !options.selection.chosen()) {
    return misused("BOOT is for single slaves: give -p N or -a ALIAS");
  }
  return options.password.empty() ? Outcome<std::uint32_t>{0} : parse_number(options.password, 0xFFFFFFFF, "password");
}

/// Opens the line, carries out the transfer that `start` begins, and leaves BOOT again.
template <typename Start>
Outcome<std::shared_ptr<FileTransfer>> transfer_file(const FoeOptions& options, Start&& start) {
  auto line = LineView::open(options.bus);
  if (!line) return tl::unexpected(line.error());
  FileSlave slave(std::move(*line));
  if (auto opened = slave.open(options); !opened) return tl::unexpected(opened.error());
  rt::catch_stop_signals();
  const std::shared_ptr<FileTransfer> transfer = start(slave.client());
  slave.wait(transfer);
  const auto left = slave.leave();
  if (const auto result = ecat_master::result_of(*transfer); !result) return failed(describe(result.error()));
  if (!left) return tl::unexpected(left.error());
  if (transfer->size() > 0) tell_what_ends(slave.line().session());
  return transfer;
}

Outcome<int> finish(const FoeOptions& options, std::string_view name, std::size_t bytes) {
  if (options.json) print_out("{}", json_text({{"name", name}, {"bytes", bytes}}));
  return 0;
}

Outcome<int> read_file(const FoeOptions& options) {
  const auto password = check(options);
  if (!password) return tl::unexpected(password.error());
  if (options.target.empty() && (options.json || isatty(STDOUT_FILENO) != 0)) {
    return misused("the file may be binary: give --output FILE, or redirect the output");
  }
  const auto transfer = transfer_file(options, [&](FoeClient client) {
    return client.start_read({options.source, *password});
  });
  if (!transfer) return tl::unexpected(transfer.error());
  const auto& content = *(*transfer)->result();
  std::string text;
  text.reserve(content.size());
  for (const auto byte : content) text += static_cast<char>(byte);
  if (options.target.empty()) {
    std::fwrite(text.data(), 1, text.size(), stdout);
  } else if (auto done = runtime::write_file(options.target, text); !done) {
    return tl::unexpected(done.error());
  }
  return finish(options, options.source, content.size());
}

Outcome<int> write_file(const FoeOptions& options) {
  const auto password = check(options);
  if (!password) return tl::unexpected(password.error());
  const auto text = runtime::read_input_file(options.source);
  if (!text) return tl::unexpected(text.error());
  const auto bytes = std::as_bytes(std::span(*text));
  const auto name = options.target.empty() ? std::filesystem::path(options.source).filename().string() : options.target;
  const auto transfer = transfer_file(options, [&](FoeClient client) {
    return client.start_write({name, *password}, {bytes.begin(), bytes.end()});
  });
  if (!transfer) return tl::unexpected(transfer.error());
  return finish(options, name, bytes.size());
}

std::shared_ptr<FoeOptions> add_foe_options(Arguments& to) {
  auto options = std::make_shared<FoeOptions>();
  add_bus_options(to, options->bus);
  options->selection.add_single(to);
  to.option("--password", &options->password, Value::text("NUMBER"), "Password that the slave asks for, 32 bits");
  to.flag("--boot", options->boot, "Take the slave to BOOT for the transfer, then to INIT, which restarts it");
  add_force_flag(to, options->force);
  add_json_flag(to, options->json);
  return options;
}

}  // namespace

Execute prepare_foe_read(Arguments& to) {
  auto options = add_foe_options(to);
  to.option("-o,--output", &options->target, Value::file(), "Write it to this file, not to stdout");
  to.required(&options->source, Value::text("NAME"), "Name of the file on the slave");
  return [options] { return read_file(*options); };
}

Execute prepare_foe_write(Arguments& to) {
  auto options = add_foe_options(to);
  to.option("-o,--output", &options->target, Value::text("NAME"),
            "Name of the file on the slave; default: name of FILE without its folder");
  to.required(&options->source, Value::file(), "File whose content is written");
  return [options] { return write_file(*options); };
}

}  // namespace driveline::cli
