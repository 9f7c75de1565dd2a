#include <fmt/format.h>

#include <chrono>
#include <string>

#include "commands/commands.hpp"
#include "commands/control_path.hpp"
#include "commands/tool_options.hpp"
#include "console.hpp"
#include "driveline/motion/drive/drive_objects.hpp"
#include "driveline/rt/stop_signals.hpp"
#include "driveline/runtime/config/line_config.hpp"
#include "line/drive_link.hpp"
#include "line/run_drives.hpp"
#include "terminal.hpp"
#include "text/drive_page.hpp"
#include "text/json_text.hpp"

namespace driveline::cli {
namespace {

using std::chrono::milliseconds;

constexpr std::uint32_t kShortestMs = 50;
constexpr std::uint32_t kLongestMs = 60'000;
constexpr std::uint32_t kUsualMs = 250;

struct DriveOptions {
  runtime::BusOptions bus;
  std::string control;  ///< socket of a run; empty: find it, or access the bus
  SlaveSelection selection;
  std::optional<std::string> interval_ms;
  std::string drive = "0";
  bool once = false;
  bool acknowledge = false;
  bool json = false;
};

Outcome<milliseconds> interval_of(const DriveOptions& options) {
  if (!options.interval_ms) return milliseconds{kUsualMs};
  const auto number = parse_number(*options.interval_ms, kLongestMs, "interval");
  if (!number) return tl::unexpected(number.error());
  if (*number < kShortestMs) {
    return misused(
        fmt::format("interval \"{}\": {} to {} ms is expected", *options.interval_ms, kShortestMs, kLongestMs));
  }
  return milliseconds{*number};
}

/// The drive to show.
struct Place {
  std::size_t slave = 0;
  unsigned drive = 0;
};

Outcome<int> print_once(DriveSource& link, const Place& place, const DriveOptions& options) {
  const auto position = place.slave;
  DriveView view;
  view.position = position;
  view.drive = place.drive;
  if (auto done = link.read(position, view); !done) return tl::unexpected(done.error());
  if (options.acknowledge) {
    if (auto done = link.acknowledge(position); !done) return tl::unexpected(done.error());
    if (auto done = link.read(position, view); !done) return tl::unexpected(done.error());
  }
  print_out("{}", options.json ? json_text(drive_json(view)) : drive_page(view, std::chrono::nanoseconds{0}));
  return 0;
}

/// Redraws the page at every interval until a key or a signal ends it.
class Pages {
 public:
  Pages(DriveSource& link, const Place& place, milliseconds interval) : link_(link), interval_(interval) {
    view_.position = place.slave;
    view_.drive = place.drive;
  }

  void run() {
    while (!rt::stop_requested()) {
      // The page shows the error; the next read may succeed.
      static_cast<void>(link_.read(view_.position, view_));
      terminal_.show(page());
      switch (terminal_.wait_for_key(interval_)) {
        case Key::kQuit:
          return;
        case Key::kNext:
          go_to((view_.position + 1) % link_.size());
          break;
        case Key::kPrevious:
          go_to((view_.position + link_.size() - 1) % link_.size());
          break;
        case Key::kReset:
          acknowledge();
          break;
        case Key::kNone:
          break;
      }
    }
  }

 private:
  void acknowledge() {
    if (!view_.trouble.empty()) return;  // there is no drive to acknowledge
    const auto done = link_.acknowledge(view_.position);
    note_ = done ? std::string() : "\n  " + done.error().text;
  }

  void go_to(std::size_t position) {
    const auto drive = view_.drive;
    view_ = {};
    view_.position = position;
    view_.drive = drive;
    shown_ = {};
    note_ = {};
  }

  [[nodiscard]] std::string page() {
    const std::chrono::nanoseconds now = std::chrono::steady_clock::now().time_since_epoch();
    const auto content = display_content(view_);
    const std::string content_key =
        fmt::format("{} {} {}", static_cast<int>(content.state), content.starting,
                    content.fault ? content.fault->number * 256 + content.fault->location : -1);
    if (content_key != shown_) {
      shown_ = content_key;
      shown_since_ = now;
    }
    const std::string keys = note_ + "\n  n next slave, p previous slave, r acknowledge a fault, q quit";
    if (!view_.values.bits(DriveObject::kStatusWord)) {
      return fmt::format("slave {} of {}\n\n  {}\n{}", view_.position, link_.size(), view_.trouble, keys);
    }
    return drive_page(view_, now - shown_since_) + keys;
  }

  DriveSource& link_;
  milliseconds interval_;
  TerminalPage terminal_;
  DriveView view_;
  std::string shown_;
  std::string note_;  ///< why a fault was not acknowledged
  std::chrono::nanoseconds shown_since_{0};
};

/// The socket of the run to ask; empty: access the bus. A line on a network interface is accessed there, beside its
/// master.
Outcome<std::string> run_to_ask(const DriveOptions& options) {
  const bool of_bus = !options.bus.interface.empty();
  if (!options.control.empty()) {
    if (!of_bus && options.bus.config.empty()) return options.control;
    return misused("--control asks a `run` about its drives; it cannot be combined with --config and --iface");
  }
  if (of_bus) return std::string{};
  if (!options.bus.config.empty()) {
    // Opening the bus reports the errors of the file.
    const auto config = runtime::load_line_config(options.bus.config);
    if (!config || config->interface) return std::string{};
  }
  return running_control(options.bus.config);
}

Outcome<int> show(DriveSource& drives, milliseconds interval, const DriveOptions& options) {
  const auto aliases = drives.aliases();
  const auto position = options.selection.select_one(aliases, false);
  if (!position) return tl::unexpected(position.error());
  if (*position >= drives.size()) return failed("the line has no slaves");
  const auto drive = parse_number(options.drive, motion::kMaxDrives - 1, "drive");
  if (!drive) return tl::unexpected(drive.error());
  const Place place{*position, *drive};
  if (options.once || options.json || options.acknowledge || !TerminalPage::possible())
    return print_once(drives, place, options);
  Pages(drives, place, interval).run();
  return 0;
}

Outcome<int> drive(const DriveOptions& options) {
  if (auto checked = options.selection.check(); !checked) return tl::unexpected(checked.error());
  const auto interval = interval_of(options);
  if (!interval) return tl::unexpected(interval.error());
  const auto control = run_to_ask(options);
  if (!control) return tl::unexpected(control.error());
  rt::catch_stop_signals();
  if (!control->empty()) {
    auto drives = RunDrives::open(*control);
    if (!drives) return tl::unexpected(drives.error());
    return show(**drives, *interval, options);
  }
  auto session = open_session(options.bus);
  if (!session) return tl::unexpected(session.error());
  auto link = DriveLink::open(**session);
  if (!link) return tl::unexpected(link.error());
  return show(**link, *interval, options);
}

}  // namespace

Execute prepare_drive(Arguments& to) {
  auto options = std::make_shared<DriveOptions>();
  add_bus_options(to, options->bus);
  options->selection.add_single(to);
  to.option("--control", &options->control, Value::file("PATH"),
            "Socket of a `run` whose drive is shown; default: socket of the line in --config, or the only socket");
  to.option("--drive", &options->drive, Value::text("NUMBER"), "Drive of the slave, 0 to 7; default: 0");
  to.option("--interval", &options->interval_ms, Value::text("MS"), "Refresh interval, 50 to 60000 ms; default: 250");
  to.flag("--once", options->once, "Print the page once; default without a terminal");
  to.flag("--acknowledge", options->acknowledge, "Acknowledge a fault of the drive first (P 153), then print once");
  add_json_flag(to, options->json);
  return [options] { return drive(*options); };
}

}  // namespace driveline::cli
