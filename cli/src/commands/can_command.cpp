#include <fmt/format.h>

#include <limits>

#include "axes/quantity.hpp"
#include "can/bus_figures.hpp"
#include "can/frame_printer.hpp"
#include "commands/can_options.hpp"
#include "commands/commands.hpp"
#include "console.hpp"
#include "driveline/canopen_wire/candump.hpp"
#include "text/json_text.hpp"

namespace driveline::cli {
namespace {

using std::chrono::nanoseconds;

constexpr nanoseconds kForEver = nanoseconds::max();
constexpr nanoseconds kStatTime = std::chrono::seconds{5};
constexpr nanoseconds kSendPatience = std::chrono::seconds{1};

/// The options of `can dump`, `can send` and `can stat`.
struct TrafficOptions {
  std::string config;
  std::string interface;
  CanOptions can;
  std::optional<std::string> count;
  std::optional<std::string> duration;
  std::string log;
  std::string pcap;
  std::vector<std::string> frames;
  bool listen_only = false;
  bool json = false;
};

/// --duration or --wait; `otherwise` when it is not given.
Outcome<nanoseconds> time_of(const std::optional<std::string>& text, std::string_view name, nanoseconds otherwise) {
  if (!text) return otherwise;
  return parse_time(*text, name);
}

Outcome<std::unique_ptr<CanBus>> open_traffic(const TrafficOptions& options, bool real_time) {
  const auto rate = options.can.rate();
  if (!rate) return tl::unexpected(rate.error());
  if (!options.interface.empty() && !names_can_interface(options.interface)) {
    return misused(
        fmt::format("--iface {}: a CAN bus is expected, such as can0, slcan:tcp:HOST:PORT or "
                    "socketcand:HOST:PORT/can0",
                    options.interface));
  }
  CanBusOptions bus;
  bus.config = options.config;
  bus.interface = options.interface;
  bus.bit_rate = *rate;
  bus.real_time = real_time;
  bus.listen_only = options.listen_only;
  bus.error_frames = true;
  bus.log = options.log;
  bus.pcap = options.pcap;
  return CanBus::open(bus);
}

/// When a time that begins now is over.
nanoseconds end_of(const canopen::BusLink& link, nanoseconds time) {
  return time == kForEver ? kForEver : link.now() + time;
}

/// Shows frames until `end`, until there were `count` of them, or until a signal. Failure: the bus is gone.
Outcome<void> show_frames(CanBus& bus, FramePrinter& printer, nanoseconds end, std::uint64_t count) {
  auto& link = bus.link();
  while (printer.count() < count && link.now() < end && !link.stopped()) {
    // What has arrived is printed before it is waited for more.
    auto received = link.receive(link.now());
    if (!received) {
      if (finish_output() != 0) return {};
      received = link.receive(end);
    }
    if (received) {
      printer.print(*received);
    } else if (link.down()) {
      return can_failure({canopen::ClientErrorKind::kDown});
    }
  }
  return {};
}

Outcome<int> dump(const TrafficOptions& options) {
  const auto duration = time_of(options.duration, "--duration", kForEver);
  if (!duration) return tl::unexpected(duration.error());
  std::uint64_t count = std::numeric_limits<std::uint64_t>::max();
  if (options.count) {
    const auto number = parse_number(*options.count, std::numeric_limits<std::uint32_t>::max(), "--count");
    if (!number) return tl::unexpected(number.error());
    count = *number;
  }
  const auto bus = open_traffic(options, true);
  if (!bus) return tl::unexpected(bus.error());
  auto& link = (*bus)->link();
  const auto start = link.now();
  FramePrinter printer(start, options.json);
  const auto shown = show_frames(**bus, printer, end_of(link, *duration), count);
  const auto time = link.now() - start;
  const auto written = (*bus)->finish_captures();
  const auto adapter = link.port().statistics();
  progress("{} frames in {:.3f} s, bus load {:.1f} %; {} error frames, {} lost", printer.count(),
           std::chrono::duration<double>(time).count(),
           time.count() > 0 ? 100.0 * static_cast<double>(printer.bits()) /
                                  (std::chrono::duration<double>(time).count() * (*bus)->bit_rate())
                            : 0.0,
           adapter.error_frames, adapter.lost);
  if (!shown) return tl::unexpected(shown.error());
  if (!written) return tl::unexpected(written.error());
  return 0;
}

Outcome<std::vector<canopen::Frame>> parse_frames(const std::vector<std::string>& texts) {
  std::vector<canopen::Frame> frames;
  for (const auto& text : texts) {
    const auto frame = canopen::candump::parse_frame(text);
    if (!frame) {
      return misused(
          fmt::format("\"{}\" is no frame: an identifier of 3 or 8 hexadecimal digits, # and up to 8 bytes or "
                      "R are expected, as 601#4000100000000000, 123#R4 or 000#0103",
                      text));
    }
    frames.push_back(*frame);
  }
  return frames;
}

Outcome<int> send(const TrafficOptions& options) {
  const auto frames = parse_frames(options.frames);
  if (!frames) return tl::unexpected(frames.error());
  const auto wait = time_of(options.duration, "--wait", nanoseconds{0});
  if (!wait) return tl::unexpected(wait.error());
  const auto bus = open_traffic(options, false);
  if (!bus) return tl::unexpected(bus.error());
  auto& link = (*bus)->link();
  FramePrinter printer(link.now(), options.json);
  for (const auto& frame : *frames) {
    if (const auto sent = link.send(frame, kSendPatience); !sent) return can_failure(sent.error());
  }
  if (const auto shown = show_frames(**bus, printer, end_of(link, *wait), std::numeric_limits<std::uint64_t>::max());
      !shown) {
    return tl::unexpected(shown.error());
  }
  if (*wait == nanoseconds{0}) (*bus)->let_frames_leave(frames->size());
  (*bus)->tell_what_ends();
  return 0;
}

Outcome<int> stat(const TrafficOptions& options) {
  const auto duration = time_of(options.duration, "--duration", kStatTime);
  if (!duration) return tl::unexpected(duration.error());
  const auto bus = open_traffic(options, true);
  if (!bus) return tl::unexpected(bus.error());
  auto& link = (*bus)->link();
  BusFigures figures;
  CanProgress told("frames");
  const auto start = link.now();
  const auto end = end_of(link, *duration);
  while (link.now() < end && !link.stopped() && !link.down()) {
    if (const auto received = link.receive(end)) figures.add(received->frame);
    told.show(figures.frames());
  }
  const auto time = link.now() - start;
  const auto adapter = link.port().statistics();
  if (options.json) {
    print_out("{}", json_text(figures.to_json((*bus)->name(), (*bus)->bit_rate(), time, adapter)));
  } else {
    print_out("{}", figures.to_text((*bus)->name(), (*bus)->bit_rate(), time, adapter));
  }
  if (link.down()) return can_failure({canopen::ClientErrorKind::kDown});
  return 0;
}

std::shared_ptr<TrafficOptions> add_traffic_options(Arguments& to) {
  auto options = std::make_shared<TrafficOptions>();
  to.option("--config", &options->config, Value::file(), "Description of a CAN line (TOML)");
  to.option("--iface", &options->interface, Value::interface(),
            "CAN bus: can0, slcan:/dev/ttyACM0, slcan:tcp:HOST:PORT, socketcand:HOST:PORT/can0; replaces the simulated "
            "line of the file");
  options->can.add_bit_rate(to);
  return options;
}

}  // namespace

Execute prepare_can_dump(Arguments& to) {
  auto options = add_traffic_options(to);
  to.option("--count", &options->count, Value::text("N"), "End after this number of frames");
  to.option("--duration", &options->duration, Value::text("TIME"), "End after this time, e.g. 10, 10s or 500ms");
  to.option("--log", &options->log, Value::file(), "Also write the frames as a log of candump");
  to.option("--pcap", &options->pcap, Value::file(), "Also write the frames as pcapng, for Wireshark");
  to.flag("--listen-only", options->listen_only, "Do not acknowledge frames, where the adapter can do without");
  to.flag("--json", options->json, "One JSON document per line for each frame");
  return [options] { return dump(*options); };
}

Execute prepare_can_send(Arguments& to) {
  auto options = add_traffic_options(to);
  to.option("--wait", &options->duration, Value::text("TIME"), "Show what is received for this time afterwards");
  to.flag("--json", options->json, "With --wait: one JSON document per line for each frame");
  to.required(&options->frames, Value::text("FRAME..."),
              "Frames in candump's notation: 601#4000100000000000, 123#R4, 1234ABCD#00");
  return [options] { return send(*options); };
}

Execute prepare_can_stat(Arguments& to) {
  auto options = add_traffic_options(to);
  to.option("--duration", &options->duration, Value::text("TIME"), "How long frames are counted; default: 5s");
  to.flag("--listen-only", options->listen_only, "Do not acknowledge frames, where the adapter can do without");
  add_json_flag(to, options->json);
  return [options] { return stat(*options); };
}

}  // namespace driveline::cli
