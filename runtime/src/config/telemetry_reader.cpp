#include "config/telemetry_reader.hpp"

#include <arpa/inet.h>
#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <string_view>
#include <utility>

#include "config/machine_user.hpp"
#include "driveline/snapshot/feed/feed_records.hpp"

namespace driveline::runtime {
namespace {

using snapshot::FeedTopic;

constexpr std::int64_t kMaxCyclesBetween = 1'000'000;
constexpr double kLeastHertz = 0.1;
constexpr double kMaxHertz = 10'000.0;
/// Highest rate in Hz of a topic published in intervals; the bridge checks for due topics 1,000 times per second.
constexpr double kMaxIntervals = 100.0;
constexpr std::size_t kLongestPartition = 63;
constexpr std::string_view kHertz = " Hz";

/// Rates that a topic permits.
struct RateChoice {
  FeedTopic topic;
  bool cycles;     ///< "full", a number of cycles, or Hz, converted to a number of cycles
  bool intervals;  ///< Hz, by the clock of the machine
  bool change;     ///< "change"
  bool off;        ///< "off"
  const char* expected;
};

constexpr const char* kSampleRates = R"("full", "change", "off", a rate such as "100 Hz", or 8 for every 8th cycle)";
constexpr const char* kJointRates = R"("full", "off", a rate such as "100 Hz", or 8 for every 8th cycle)";
constexpr const char* kChangeRates = R"("change" or "off")";

constexpr RateChoice kRateChoices[] = {
    {FeedTopic::kAxisTelemetry, true, false, true, true, kSampleRates},
    {FeedTopic::kLineStatus, false, true, false, false, R"(a rate from "0.1 Hz" to "100 Hz")"},
    {FeedTopic::kAxisBatch, true, false, true, true, kSampleRates},
    {FeedTopic::kEvent, false, false, true, true, kChangeRates},
    {FeedTopic::kSlave, false, false, true, true, kChangeRates},
    {FeedTopic::kTopology, false, false, true, true, kChangeRates},
    {FeedTopic::kCycleStatistics, false, false, true, true, kChangeRates},
    {FeedTopic::kAxisState, false, false, true, true, kChangeRates},
    {FeedTopic::kDiagnostics, false, true, false, true, R"("off", or a rate from "0.1 Hz" to "100 Hz")"},
    {FeedTopic::kJointStates, true, false, false, true, kJointRates},
};
static_assert(std::size(kRateChoices) == snapshot::kFeedTopics);

bool is_ipv4(const std::string& text) {
  in_addr parsed{};
  return ::inet_pton(AF_INET, text.c_str(), &parsed) == 1;
}

bool is_on_this_machine(const std::string& address) {
  return address.starts_with("127.");
}

/// Returns the number of "100 Hz"; NaN: the text is no rate.
double hertz_of(std::string_view text) {
  if (!text.ends_with(kHertz)) return std::nan("");
  text.remove_suffix(kHertz.size());
  double value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  return error == std::errc{} && end == text.data() + text.size() ? value : std::nan("");
}

/// Returns the number of cycles that is nearest to the rate, at least one.
std::uint32_t cycles_of(double hertz, std::chrono::nanoseconds period) {
  const double wanted = 1.0 / (hertz * std::chrono::duration<double>(period).count());
  return static_cast<std::uint32_t>(
      std::clamp<std::int64_t>(std::llround(std::min(wanted, 1e9)), 1, kMaxCyclesBetween));
}

TopicRate read_rate(TomlReader& reader, std::string_view key, const RateChoice& choice,
                    std::chrono::nanoseconds period) {
  using Kind = TopicRate::Kind;
  if (!reader.is_text(key)) {
    if (!choice.cycles) reader.fail(key, fmt::format("{} is expected", choice.expected));
    return {Kind::kCycles, static_cast<std::uint32_t>(reader.integer(key, 1, kMaxCyclesBetween)), {}};
  }
  const auto text = reader.text(key);
  if (choice.cycles && text == "full") return {Kind::kCycles, 1, {}};
  if (choice.change && text == "change") return {Kind::kOnChange, 1, {}};
  if (choice.off && text == "off") return {Kind::kOff, 1, {}};
  const double hertz = hertz_of(text);
  if (choice.cycles && hertz >= kLeastHertz && hertz <= kMaxHertz) {
    return {Kind::kCycles, cycles_of(hertz, period), {}};
  }
  if (choice.intervals && hertz >= kLeastHertz && hertz <= kMaxIntervals) {
    return {Kind::kPeriod, 1, std::chrono::round<std::chrono::nanoseconds>(std::chrono::duration<double>(1.0 / hertz))};
  }
  reader.fail(key, fmt::format("is \"{}\", {} is expected", text, choice.expected));
}

void read_rates(TomlReader reader, std::chrono::nanoseconds period, TelemetryConfig& telemetry) {
  for (const auto& choice : kRateChoices) {
    const auto index = static_cast<std::size_t>(choice.topic);
    const auto name = snapshot::kFeedTopicNames[index];
    if (!reader.has(name)) continue;
    telemetry.rates[index] = read_rate(reader, name, choice, period);
    const bool of_ros2 = choice.topic == FeedTopic::kDiagnostics || choice.topic == FeedTopic::kJointStates;
    if (of_ros2 && !telemetry.ros2) reader.fail(name, "is a topic of ROS 2, which needs ros2 = true in [telemetry]");
  }
  reader.finish();
}

std::string read_partition(TomlReader& reader) {
  auto partition = reader.text("partition");
  const bool plain = std::all_of(partition.begin(), partition.end(), [](char c) { return c > ' ' && c < 0x7F; });
  if (partition.empty() || partition.size() > kLongestPartition || !plain ||
      partition.find_first_of("*?[]\\") != std::string::npos) {
    reader.fail("partition", fmt::format("1 to {} letters, digits and signs but * ? [ ] \\ and blanks are expected",
                                         kLongestPartition));
  }
  return partition;
}

/// Refuses an address on another machine if all interfaces reach only this machine.
void check_reach(const TomlReader& reader, const char* key, const std::string& address,
                 const TelemetryConfig& telemetry) {
  const auto& from = telemetry.interfaces;
  const bool stays = !from.empty() && std::all_of(from.begin(), from.end(), is_on_this_machine);
  if (stays && !is_on_this_machine(address)) {
    reader.fail(key, fmt::format("{} cannot be reached from {}, which keeps telemetry on this machine: name the "
                                 "interface that leads to it in interfaces",
                                 address, fmt::join(from, ", ")));
  }
}

void read_peers(TomlReader& reader, TelemetryConfig& telemetry) {
  telemetry.peers = reader.texts_or("peers", {});
  if (telemetry.peers.size() > snapshot::kMaxFeedPeers) {
    reader.fail("peers",
                fmt::format("{} are too many, the limit is {}", telemetry.peers.size(), snapshot::kMaxFeedPeers));
  }
  for (const auto& peer : telemetry.peers) {
    if (!is_ipv4(peer)) reader.fail("peers", fmt::format("\"{}\" is not an IPv4 address such as 192.168.1.10", peer));
    check_reach(reader, "peers", peer, telemetry);
  }
}

void read_discovery_server(TomlReader& reader, TelemetryConfig& telemetry) {
  if (!reader.has("discovery_server")) return;
  const auto text = reader.text("discovery_server");
  const auto colon = text.find(':');
  const std::string port = colon == std::string::npos ? "" : text.substr(colon + 1);
  DiscoveryServer server{text.substr(0, colon), 0};
  const auto [end, error] = std::from_chars(port.data(), port.data() + port.size(), server.port);
  if (error != std::errc{} || end != port.data() + port.size() || server.port == 0 || !is_ipv4(server.address)) {
    reader.fail("discovery_server",
                fmt::format("is \"{}\", an IPv4 address and a port such as 192.168.1.10:11811 are expected", text));
  }
  check_reach(reader, "discovery_server", server.address, telemetry);
  if (!telemetry.peers.empty()) {
    reader.fail("peers", "are not used with a discovery_server: remove one of the two keys");
  }
  telemetry.discovery_server = std::move(server);
}

MachineUser read_user(TomlReader& reader) {
  const auto name = reader.text("user");
  const auto found = find_user(name);
  if (!found) reader.fail("user", fmt::format("there is no user \"{}\" on this machine", name));
  if (found->user == 0 || found->group == 0) {
    reader.fail(
        "user",
        fmt::format("is \"{}\", but a process that reads from a network must not run as root: another user is expected",
                    name));
  }
  return *found;
}

}  // namespace

TelemetryConfig read_telemetry(TomlReader reader, const std::filesystem::path& folder,
                               std::chrono::nanoseconds period) {
  TelemetryConfig telemetry;
  if (reader.has("enabled")) telemetry.asked = reader.boolean_or("enabled", true);
  telemetry.enabled = telemetry.asked.value_or(true);
  telemetry.service = reader.choice_or("bridge", 0, {"run", "service"}) == 1;
  telemetry.domain = static_cast<std::uint32_t>(reader.integer_or("domain", 0, 0, 232));
  if (reader.has("partition")) telemetry.partition = read_partition(reader);
  telemetry.decimation = static_cast<std::uint32_t>(reader.integer_or("decimation", 8, 1, kMaxCyclesBetween));
  telemetry.interfaces = reader.texts_or("interfaces", telemetry.interfaces);
  read_peers(reader, telemetry);
  read_discovery_server(reader, telemetry);
  telemetry.ros2 = reader.boolean_or("ros2", false);
  telemetry.shared_memory = reader.boolean_or("shared_memory", false);
  if (reader.has("user")) telemetry.user = read_user(reader);
  if (reader.has("security")) telemetry.security = folder / reader.text("security");
  if (telemetry.security && telemetry.shared_memory) {
    reader.fail("shared_memory", "is not tested with DDS Security: remove it or security");
  }
  if (reader.has("qos_profiles")) telemetry.qos_profiles = folder / reader.text("qos_profiles");
  for (const auto* key : {"security", "qos_profiles"}) {
    if (!telemetry.service || !reader.has(key)) continue;
    reader.fail(key, "is for the bridge that run starts; with bridge = \"service\" the service passes its own files");
  }
  if (telemetry.service && telemetry.user) {
    reader.fail("user", "is for the bridge that run starts; with bridge = \"service\" the service sets its own user");
  }
  read_rates(reader.table("rates"), period, telemetry);
  const auto axis = static_cast<std::size_t>(FeedTopic::kAxisTelemetry);
  if (reader.has("decimation") && telemetry.rates[axis].kind != TopicRate::Kind::kDefault) {
    reader.fail("decimation", "sets the rate of axis_telemetry, as does [telemetry.rates]: remove one of them");
  }
  reader.finish();
  return telemetry;
}

}  // namespace driveline::runtime
