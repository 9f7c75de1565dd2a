#include "options.hpp"

#include <charconv>
#include <string_view>
#include <system_error>

namespace driveline::bridge {

const char* const kHelp =
    "usage: driveline-bridge --feed-fd N [--condition-fd N] [--return-fd N] [--commands-fd N] [--security-fd N]\n"
    "                        [--qos-fd N] [--qos-file NAME] [--supervisor-fd N]\n"
    "Publishes a drive line over DDS. `driveline run` starts it and keeps it running.\n"
    "  --feed-fd N        inherited descriptors N to N+3: description, status, cycles and events of a line's feed\n"
    "  --condition-fd N   inherited descriptor of the feed's condition: the slaves\n"
    "  --return-fd N      inherited descriptor of the region for what it has published\n"
    "  --commands-fd N    inherited descriptors N to N+3: of the regions for commands, answers, setpoints, reports\n"
    "  --security-fd N    inherited descriptors N to N+5: identity CA, certificate, private key, permissions CA,\n"
    "                     governance and permissions of DDS Security\n"
    "  --qos-fd N         inherited descriptor of an XML file with profiles of Fast DDS for the writers\n"
    "  --qos-file NAME    what that file is called in messages\n"
    "  --supervisor-fd N  inherited socket: it says there that it publishes, and ends when the other side is closed\n"
    "  --help             this text\n"
    "Without --supervisor-fd it ends with the line, or by SIGTERM. By hand, beside a run that is process P and "
    "publishes\n"
    "already, in another domain or not: descriptors D, S, C, E, L of P are memfd:driveline-feed-description, -status,\n"
    "-cycles, -events and -condition in /proc/P/fd:\n"
    "  driveline-bridge --feed-fd 3 --condition-fd 7 3</proc/P/fd/D 4</proc/P/fd/S 5</proc/P/fd/C 6</proc/P/fd/E \\\n"
    "    7</proc/P/fd/L\n";

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
    int* const value = name == "--feed-fd"         ? &options.feed
                       : name == "--return-fd"     ? &options.counts
                       : name == "--condition-fd"  ? &options.condition
                       : name == "--commands-fd"   ? &options.commands
                       : name == "--security-fd"   ? &options.security
                       : name == "--qos-fd"        ? &options.qos
                       : name == "--supervisor-fd" ? &options.supervisor
                                                   : nullptr;
    if (value == nullptr) {
      options.problem = "there is no option " + std::string{name};
      return options;
    }
    const std::string_view text = ++i < count ? arguments[i] : "";
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), *value);
    if (text.empty() || error != std::errc{} || end != text.data() + text.size() || *value < 0) {
      options.problem = std::string{name} + " needs the number of a descriptor";
      return options;
    }
  }
  if (options.feed < 0) options.problem = "--feed-fd is missing: what is to be published?";
  return options;
}

}  // namespace driveline::bridge
