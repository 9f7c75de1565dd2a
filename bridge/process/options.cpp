#include "options.hpp"

#include <charconv>
#include <string_view>
#include <system_error>

namespace driveline::bridge {

const char* const kHelp =
    "usage: driveline-bridge --process P [--qos-fd N] [--qos-file NAME] [--security-fd N]\n"
    "                        [--user U:G]\n"
    "       driveline-bridge --feed-fd N [--condition-fd N] [--return-fd N] [--commands-fd N] [--security-fd N]\n"
    "                        [--qos-fd N] [--qos-file NAME] [--user U:G] [--supervisor-fd N]\n"
    "Publishes a drive line over DDS. `driveline run` starts it and keeps it running, in the second form, unless the\n"
    "line description has `bridge = \"service\"` in [telemetry].\n"
    "  --process P        the feed of the line that process P runs, and its counters; opened by root or the user of P\n"
    "  --feed-fd N        inherited descriptors N to N+3: description, status, cycles and events of a line's feed\n"
    "  --condition-fd N   inherited descriptor of the feed's condition: the slaves\n"
    "  --return-fd N      inherited descriptor of the region for the counters of published samples\n"
    "  --commands-fd N    inherited descriptors N to N+3: of the regions for commands, answers, setpoints, reports\n"
    "  --security-fd N    inherited descriptors N to N+5: identity CA, certificate, private key, permissions CA,\n"
    "                     governance and permissions of DDS Security\n"
    "  --qos-fd N         inherited descriptor of an XML file with profiles of Fast DDS for the writers\n"
    "  --qos-file NAME    name of that file in messages\n"
    "  --user U:G         user and group, as numbers, to change to when root starts it; the user nobody otherwise\n"
    "  --supervisor-fd N  inherited socket for the report that it publishes; it ends when the other side is closed\n"
    "  --help             this text\n"
    "Without --supervisor-fd it ends with the line or on SIGTERM.\n";

namespace {

/// Highest user or group number. The next one means "none".
constexpr unsigned kLastNumber = 0xFFFF'FFFEU;

/// Parses all of `text`; nullopt if it is not a user or group number, or is that of root.
std::optional<unsigned> number_of(std::string_view text) {
  unsigned value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc{} || end != text.data() + text.size() || value == 0 || value > kLastNumber) {
    return std::nullopt;
  }
  return value;
}

/// Parses e.g. "1000:1000".
std::optional<Identity> identity_of(std::string_view text) {
  const auto colon = text.find(':');
  if (colon == std::string_view::npos) return std::nullopt;
  const auto user = number_of(text.substr(0, colon));
  const auto group = number_of(text.substr(colon + 1));
  if (!user || !group) return std::nullopt;
  return Identity{*user, *group};
}

}  // namespace

Options read_options(int count, const char* const* arguments) {
  Options options;
  for (int i = 0; i < count; ++i) {
    const std::string_view name = arguments[i];
    if (name == "--help") {
      options.help = true;
      return options;
    }
    if (name == "--qos-file") {
      if (++i == count) {
        options.problem = "--qos-file needs a name";
        return options;
      }
      options.qos_file = arguments[i];
      continue;
    }
    if (name == "--user") {
      options.user = identity_of(++i < count ? arguments[i] : "");
      if (options.user) continue;
      options.problem = "--user needs the numbers of a user and of a group, 1000:1000, and neither is 0";
      return options;
    }
    int* const value = name == "--feed-fd"         ? &options.feed
                       : name == "--return-fd"     ? &options.counts
                       : name == "--condition-fd"  ? &options.condition
                       : name == "--commands-fd"   ? &options.commands
                       : name == "--security-fd"   ? &options.security
                       : name == "--qos-fd"        ? &options.qos
                       : name == "--supervisor-fd" ? &options.supervisor
                       : name == "--process"       ? &options.process
                                                   : nullptr;
    if (value == nullptr) {
      options.problem = "there is no option " + std::string{name};
      return options;
    }
    const std::string_view text = ++i < count ? arguments[i] : "";
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), *value);
    if (text.empty() || error != std::errc{} || end != text.data() + text.size() || *value < 0) {
      options.problem =
          std::string{name} + " needs the number of a " + (name == "--process" ? "process" : "descriptor");
      return options;
    }
  }
  const bool inherited = options.feed >= 0 || options.condition >= 0 || options.counts >= 0 || options.commands >= 0;
  if (options.feed < 0 && options.process < 0) {
    options.problem = "--process or --feed-fd is missing: set the line to publish";
  } else if (options.process >= 0 && inherited) {
    options.problem = "--process replaces all inherited descriptors: remove them";
  }
  return options;
}

}  // namespace driveline::bridge
