#include "options.hpp"

#include <arpa/inet.h>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <ifaddrs.h>
#include <net/if.h>
#include <netinet/in.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <charconv>
#include <cstring>
#include <memory>
#include <string_view>

namespace driveline::bridge::clients {
namespace {

constexpr std::uint64_t kMaxDomain = 232;  // RTPS 2.2, 9.6.1: with a higher domain the ports exceed 16 bits
constexpr double kMaxSeconds = 1e7;

/// IPv4 addresses of this machine, with the names of their interfaces.
std::vector<std::pair<std::string, std::string>> own_interfaces() {
  std::vector<std::pair<std::string, std::string>> found;
  ifaddrs* first = nullptr;
  if (getifaddrs(&first) != 0) return found;
  const std::unique_ptr<ifaddrs, void (*)(ifaddrs*)> owner(first, freeifaddrs);
  for (const auto* entry = first; entry != nullptr; entry = entry->ifa_next) {
    if (entry->ifa_addr == nullptr || entry->ifa_addr->sa_family != AF_INET) continue;
    char text[INET_ADDRSTRLEN] = {};
    inet_ntop(AF_INET, &reinterpret_cast<const sockaddr_in*>(entry->ifa_addr)->sin_addr, text, sizeof text);
    found.emplace_back(entry->ifa_name, text);
  }
  return found;
}

bool is_address(const std::string& text) {
  in_addr parsed{};
  return inet_pton(AF_INET, text.c_str(), &parsed) == 1;
}

/// Parses the command line option by option.
class Reader {
 public:
  Reader(int count, const char* const* words) : words_(words, words + count) {}

  Outcome<Options> read() {
    if (words_.empty()) return misused("echo, record, plot or top is expected");
    options_.command = words_[0];
    for (at_ = 1; at_ < words_.size();) {
      if (auto done = word(words_[at_++]); !done) return tl::unexpected(done.error());
    }
    if (interfaces_.empty()) interfaces_.emplace_back("127.0.0.1");
    if (auto done = resolve(); !done) return tl::unexpected(done.error());
    if (auto done = look_for_keys(); !done) return tl::unexpected(done.error());
    return options_;
  }

 private:
  Outcome<void> word(const std::string& name) {
    if (name == "--json") return flag(options_.json);
    if (name == "--force") return flag(options_.force);
    if (name == "--once") return flag(options_.once);
    if (name == "--help") return flag(options_.help);
    if (!name.starts_with("--")) {
      if (!options_.argument.empty()) return misused(fmt::format("{} was not expected", name));
      options_.argument = name;
      return {};
    }
    return option(name);
  }

  Outcome<void> flag(bool& target) {
    target = true;
    return {};
  }

  Outcome<void> option(const std::string& name) {
    if (at_ == words_.size()) return misused(fmt::format("{} needs a value", name));
    const auto& value = words_[at_++];
    if (name == "--domain") return whole(name, value, 0, kMaxDomain, domain_);
    if (name == "--count") return whole(name, value, 1, UINT64_MAX, options_.count);
    if (name == "--duration") return seconds(name, value, options_.duration_s);
    if (name == "--timeout") return seconds(name, value, options_.timeout_s);
    if (name == "--period") return seconds(name, value, options_.period_s);
    if (name == "--interface") return add(interfaces_, value);
    if (name == "--peer") return add(options_.place.peers, value);
    if (name == "--topic") return add(options_.topics, value);
    if (name == "--axis") return add(options_.axes, value);
    if (name == "--unit") return unit(value);
    if (name == "--partition") return text(options_.place.partition, value);
    if (name == "--security") return text(options_.place.security, value);
    if (name == "--output") return text(options_.output, value);
    return misused(fmt::format("there is no option {}", name));
  }

  Outcome<void> add(std::vector<std::string>& target, const std::string& value) {
    target.push_back(value);
    return {};
  }

  Outcome<void> unit(const std::string& value) {
    if (options_.units.add(value)) return {};
    return misused(fmt::format("--unit \"{}\": AXIS=UNIT is expected, with rad, deg, rev, m, mm or um", value));
  }

  Outcome<void> text(std::string& target, const std::string& value) {
    target = value;
    return {};
  }

  Outcome<void> whole(const std::string& name, const std::string& value, std::uint64_t least, std::uint64_t most,
                      std::optional<std::uint64_t>& target) {
    std::uint64_t number = 0;
    const auto [end, error] = std::from_chars(value.data(), value.data() + value.size(), number);
    if (error != std::errc{} || end != value.data() + value.size() || number < least || number > most) {
      return misused(most == UINT64_MAX
                         ? fmt::format("{} \"{}\": a whole number from {} on is expected", name, value, least)
                         : fmt::format("{} \"{}\": {} to {} is expected", name, value, least, most));
    }
    target = number;
    return {};
  }

  Outcome<void> seconds(const std::string& name, const std::string& value, std::optional<double>& target) {
    double number = 0;
    const auto [end, error] = std::from_chars(value.data(), value.data() + value.size(), number);
    if (error != std::errc{} || end != value.data() + value.size() || !(number > 0 && number <= kMaxSeconds)) {
      return misused(fmt::format("{} \"{}\": seconds above 0, up to {:.0f}, are expected", name, value, kMaxSeconds));
    }
    target = number;
    return {};
  }

  /// Replaces names of interfaces by their addresses. Checks them because Fast DDS silently drops an address that the
  /// machine does not have.
  Outcome<void> resolve() {
    options_.place.domain = static_cast<std::uint32_t>(domain_.value_or(0));
    for (const auto& peer : options_.place.peers) {
      if (!is_address(peer)) return misused(fmt::format("--peer \"{}\": an IPv4 address is expected", peer));
    }
    if (std::find(interfaces_.begin(), interfaces_.end(), "all") != interfaces_.end()) return {};
    const auto own = own_interfaces();
    for (const auto& wanted : interfaces_) {
      const auto found = std::find_if(own.begin(), own.end(),
                                      [&](const auto& each) { return wanted == each.first || wanted == each.second; });
      if (found == own.end()) return misused(no_interface(wanted, own));
      options_.place.interfaces.push_back(found->second);
    }
    return {};
  }

  /// Checks the security files, because Fast DDS gives no useful message about a file that it cannot read.
  [[nodiscard]] Outcome<void> look_for_keys() const {
    if (options_.place.security.empty()) return {};
    for (const auto* name : kSecurityFiles) {
      const auto file = options_.place.security + '/' + name;
      if (::access(file.c_str(), R_OK) != 0) {
        return failed(fmt::format("{}: cannot be read: {}", file, std::strerror(errno)));
      }
    }
    return {};
  }

  static std::string no_interface(const std::string& wanted,
                                  const std::vector<std::pair<std::string, std::string>>& own) {
    std::vector<std::string> known{"all"};
    for (const auto& [name, address] : own) known.push_back(fmt::format("{} ({})", name, address));
    return fmt::format("--interface \"{}\": this machine has {}", wanted, fmt::join(known, ", "));
  }

  std::vector<std::string> words_;
  std::size_t at_ = 0;
  Options options_;
  std::optional<std::uint64_t> domain_;
  std::vector<std::string> interfaces_;
};

}  // namespace

const char* const kHelp =
    "driveline-dds COMMAND [OPTION...]: observes a line over DDS. `driveline echo`, `record`, `plot` and `top` start "
    "it,\n"
    "and their --help lists the options:\n"
    "  echo TOPIC    [--json] [--count N] [--timeout S]\n"
    "  record        --output FILE [--topic NAME]... [--duration S] [--timeout S] [--force] [--json]\n"
    "  plot FILE     [--output FILE.svg] [--axis NAME]... [--unit NAME=UNIT]...\n"
    "  top           [--once] [--period S] [--timeout S] [--unit NAME=UNIT]...\n"
    "Common options: [--domain N] [--interface NAME|ADDRESS|all]... [--peer ADDRESS]... [--partition NAME] "
    "[--security DIR]\n";

std::string Place::text() const {
  auto where = fmt::format("domain {}", domain);
  if (!partition.empty()) where += fmt::format(", partition {}", partition);
  if (!security.empty()) where += fmt::format(", secured by {}", security);
  return where + (interfaces.empty() ? " on all interfaces" : fmt::format(" on {}", fmt::join(interfaces, ", ")));
}

Outcome<Options> read_options(int count, const char* const* words) {
  return Reader(count, words).read();
}

}  // namespace driveline::bridge::clients
