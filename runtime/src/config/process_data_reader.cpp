#include "config/process_data_reader.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <optional>

#include "driveline/motion/axis/startup_sdos.hpp"

namespace driveline::runtime {
namespace {

using ecat_master::ImageLayout;

constexpr std::int64_t kMaxDivider = 10'000;
constexpr std::int64_t kMaxBadCycles = 10'000;
/// Name of the group of the slaves without a [[group]].
constexpr std::string_view kOthers = "others";

using Membership = std::vector<std::optional<std::size_t>>;

std::size_t find_slave(const TomlReader& reader, std::string_view key, std::string_view name,
                       const std::vector<SlaveConfig>& slaves) {
  const auto slave = std::find_if(slaves.begin(), slaves.end(), [&](const SlaveConfig& s) { return s.name == name; });
  if (slave == slaves.end()) reader.fail(key, fmt::format("there is no [[slave]] named \"{}\"", name));
  return static_cast<std::size_t>(slave - slaves.begin());
}

bool has_axis(const LineConfig& config, std::size_t slave) {
  return std::any_of(config.axes.begin(), config.axes.end(), [=](const auto& axis) { return axis.slave == slave; });
}

void read_members(TomlReader& reader, const LineConfig& config, Membership& groups) {
  const auto number = config.process_data.groups.size();
  const auto names = reader.texts_or("slaves", {});
  if (names.empty()) reader.fail("slaves", "names of slaves are expected, at least one");
  for (const auto& name : names) {
    auto& group = groups[find_slave(reader, "slaves", name, config.slaves)];
    if (group) {
      const bool here = *group == number;
      reader.fail("slaves", here ? fmt::format("\"{}\" is there twice", name)
                                 : fmt::format("\"{}\" is already in group \"{}\"", name,
                                               config.process_data.groups[*group].name));
    }
    group = number;
  }
}

void read_zeroing(TomlReader& reader, const LineConfig& config, const Membership& groups, ExchangeGroupConfig& group) {
  if (!reader.has("zero_outputs_after")) return;
  group.settings.bad_cycle_limit = static_cast<std::uint32_t>(reader.integer("zero_outputs_after", 0, kMaxBadCycles));
  if (group.settings.bad_cycle_limit == 0) return;
  for (std::size_t i = 0; i < groups.size(); ++i) {
    if (groups[i] != config.process_data.groups.size() || !has_axis(config, i)) continue;
    // A control word of zero lets the motor coast (CiA 402-2, Disable voltage).
    reader.fail("zero_outputs_after",
                fmt::format("\"{}\" has an axis: [bus] {} stops it, zero outputs would let it coast",
                            config.slaves[i].name, config.max_lost_ms ? "max_lost_ms" : "max_lost_cycles"));
  }
}

/// Checks that object 60C2h can represent the time between two exchanges, over which drives interpolate.
void check_interpolation(const TomlReader& reader, std::string_view key, const LineConfig& config, std::size_t slave,
                         std::uint32_t divider) {
  if (!has_axis(config, slave) || motion::to_interpolation_period(config.period * divider)) return;
  reader.fail(key, fmt::format("\"{}\" would be exchanged every {} us: object 60C2h of a drive holds 1 to 255 times a "
                               "power of ten",
                               config.slaves[slave].name, (config.period * divider).count() / 1000));
}

void read_group(TomlReader reader, LineConfig& config, Membership& membership) {
  auto& groups = config.process_data.groups;
  ExchangeGroupConfig group;
  group.name = reader.text("name");
  if (group.name.empty()) reader.fail("name", "must not be empty");
  if (std::any_of(groups.begin(), groups.end(), [&](const auto& other) { return other.name == group.name; })) {
    reader.fail("name", fmt::format("\"{}\" is there twice", group.name));
  }
  read_members(reader, config, membership);
  group.settings.divider = static_cast<std::uint32_t>(reader.integer_or("divider", 1, 1, kMaxDivider));
  group.settings.phase =
      static_cast<std::uint32_t>(reader.integer_or("phase", 0, 0, std::int64_t{group.settings.divider} - 1));
  for (std::size_t i = 0; i < membership.size(); ++i) {
    if (membership[i] == groups.size()) check_interpolation(reader, "divider", config, i, group.settings.divider);
  }
  read_zeroing(reader, config, membership, group);
  reader.finish();
  groups.push_back(std::move(group));
}

/// Makes the remaining slaves the first group, which is exchanged in every cycle.
void gather_others(LineConfig& config, const Membership& membership) {
  auto& groups = config.process_data.groups;
  if (groups.empty()) return;
  const bool others = std::any_of(membership.begin(), membership.end(), [](const auto& group) { return !group; });
  if (others) groups.insert(groups.begin(), ExchangeGroupConfig{std::string(kOthers), {}});
  for (std::size_t i = 0; i < membership.size(); ++i) {
    config.slaves[i].group = membership[i] ? *membership[i] + (others ? 1 : 0) : 0;
  }
}

std::string read_end(TomlReader& reader, std::string_view key, const LineConfig& config) {
  auto name = reader.text(key);
  // Names may contain dots: compare with the names of the slaves to find the end of the slave's name.
  const bool known = std::any_of(config.slaves.begin(), config.slaves.end(), [&](const SlaveConfig& slave) {
    return name.size() > slave.name.size() + 1 && name.starts_with(slave.name + ".");
  });
  if (!known) {
    reader.fail(key, fmt::format("is \"{}\", \"slave.object\" with the name of a [[slave]] is expected, for example "
                                 "\"{}.6041h\"",
                                 name, config.slaves.front().name));
  }
  return name;
}

CopyConfig read_copy(TomlReader reader, const LineConfig& config) {
  CopyConfig copy;
  copy.from = read_end(reader, "from", config);
  copy.to = read_end(reader, "to", config);
  copy.from_place = reader.place("from");
  copy.to_place = reader.place("to");
  reader.finish();
  return copy;
}

}  // namespace

std::vector<EntryName> read_entry_names(TomlReader reader) {
  std::vector<EntryName> names;
  for (const auto& key : reader.keys()) {
    if (key.empty()) reader.fail(key, "a name must not be empty");
    names.push_back({key, reader.text(key), reader.place(key)});
  }
  return names;
}

void read_process_data(TomlReader& root, LineConfig& config) {
  auto reader = root.table("process_data");
  constexpr ImageLayout kLayouts[] = {ImageLayout::kOverlapped, ImageLayout::kSequential, ImageLayout::kSeparate};
  config.process_data.layout = kLayouts[reader.choice_or("layout", 0, {"overlapped", "sequential", "lrd_lwr"})];
  reader.finish();
  Membership membership(config.slaves.size());
  for (auto& group : root.tables("group")) read_group(std::move(group), config, membership);
  if (!config.process_data.groups.empty()) {
    const auto& groups = config.process_data.groups;
    if (std::any_of(groups.begin(), groups.end(), [](const auto& group) { return group.name == kOthers; })) {
      root.fail("group", "\"others\" is reserved for the slaves that are in no group");
    }
  }
  const bool sync = config.can && root.table("bus").has("sync_ms");
  auto period = root.table(sync ? "bus" : "line");
  for (std::size_t i = 0; i < membership.size(); ++i) {
    if (!membership[i]) check_interpolation(period, sync ? "sync_ms" : "cycle_us", config, i, 1);
  }
  gather_others(config, membership);
  for (auto& copy : root.tables("copy")) config.process_data.copies.push_back(read_copy(std::move(copy), config));
}

}  // namespace driveline::runtime
