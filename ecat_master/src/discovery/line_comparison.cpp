#include "driveline/ecat_master/discovery/line_comparison.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <map>

namespace driveline::ecat_master {
namespace {

enum class Fit : std::uint8_t { kYes, kUnknown, kSerial, kRevision, kNo };

Fit fit(const ExpectedSlave& expected, const SlaveInfo& found) {
  if (!found.usable()) return Fit::kUnknown;
  const auto& device = found.description;
  if (!expected.vendor.accepts(device.vendor_id) || !expected.product.accepts(device.product_code)) return Fit::kNo;
  if (!expected.revision.accepts(device.revision)) return Fit::kRevision;
  return expected.serial.accepts(device.serial_number) ? Fit::kYes : Fit::kSerial;
}

/// Cost of pairing a planned and a found slave. Leaving both unpaired costs 2 * kGap.
constexpr unsigned kGap = 4;
/// Cost of two swapped neighbours: one incident, not two.
constexpr unsigned kSwap = 5;
unsigned price(Fit fit) {
  switch (fit) {
    case Fit::kYes:
      return 0;
    case Fit::kUnknown:
      return 1;
    case Fit::kSerial:
      return 3;
    case Fit::kRevision:
      return 5;
    case Fit::kNo:
      return 7;
  }
  return 2 * kGap;
}

Difference::Kind kind_of(Fit fit) {
  if (fit == Fit::kUnknown) return Difference::Kind::kEeprom;
  return fit == Fit::kSerial     ? Difference::Kind::kSerial
         : fit == Fit::kRevision ? Difference::Kind::kRevision
                                 : Difference::Kind::kWrongDevice;
}

/// A pair of a planned and a found slave; one of them may be missing.
struct Pair {
  std::optional<std::size_t> plan;
  std::optional<std::size_t> slave;
};

/// The cheapest alignment of two sequences: the order is kept, except that neighbours may be swapped
/// (Damerau-Levenshtein distance with the costs above).
std::vector<Pair> align(std::span<const ExpectedSlave> planned, std::span<const std::size_t> plans,
                        std::span<const SlaveInfo> found, std::span<const std::size_t> slaves) {
  const auto rows = plans.size() + 1;
  const auto columns = slaves.size() + 1;
  std::vector<unsigned> cost(rows * columns);
  auto at = [&](std::size_t row, std::size_t column) -> unsigned& { return cost[row * columns + column]; };
  auto match = [&](std::size_t row, std::size_t column) {
    return price(fit(planned[plans[row - 1]], found[slaves[column - 1]]));
  };
  auto crossed = [&](std::size_t row, std::size_t column) {
    return row > 1 && column > 1 && match(row, column) != 0 && match(row - 1, column - 1) != 0 &&
           match(row - 1, column) == 0 && match(row, column - 1) == 0;
  };
  for (std::size_t row = 0; row < rows; ++row) {
    for (std::size_t column = 0; column < columns; ++column) {
      if (row == 0 || column == 0) {
        at(row, column) = static_cast<unsigned>((row + column) * kGap);
        continue;
      }
      at(row, column) = std::min(
          {at(row - 1, column - 1) + match(row, column), at(row - 1, column) + kGap, at(row, column - 1) + kGap});
      if (crossed(row, column)) at(row, column) = std::min(at(row, column), at(row - 2, column - 2) + kSwap);
    }
  }
  std::vector<Pair> pairs;
  for (auto row = rows - 1, column = columns - 1; row > 0 || column > 0;) {
    if (crossed(row, column) && at(row, column) == at(row - 2, column - 2) + kSwap) {
      pairs.push_back({plans[--row], slaves[--column]});
      pairs.push_back({plans[--row], slaves[--column]});
    } else if (row > 0 && at(row, column) == at(row - 1, column) + kGap) {
      pairs.push_back({plans[--row], std::nullopt});
    } else if (column > 0 && at(row, column) == at(row, column - 1) + kGap) {
      pairs.push_back({std::nullopt, slaves[--column]});
    } else {
      pairs.push_back({plans[--row], slaves[--column]});
    }
  }
  std::reverse(pairs.begin(), pairs.end());
  return pairs;
}

class Comparison {
 public:
  Comparison(std::span<const ExpectedSlave> planned, std::span<const SlaveInfo> found)
      : planned_(planned), found_(found) {
    result_.plan_of_slave.resize(found.size());
  }

  LineComparison run(const Topology& topology) {
    std::vector<std::size_t> plans;
    for (std::size_t i = 0; i < planned_.size(); ++i) {
      if (planned_[i].by_position()) {
        plans.push_back(i);
      } else if (!planned_[i].behind) {
        take_by_name(i);
      }
    }
    for (std::size_t i = 0; i < planned_.size(); ++i) {
      if (planned_[i].behind) take_behind(i, *planned_[i].behind);
    }
    std::vector<std::size_t> slaves;
    for (std::size_t i = 0; i < found_.size(); ++i) {
      if (!result_.plan_of_slave[i] && !spoken_for(i)) slaves.push_back(i);
    }
    take_in_order(plans, slaves);
    std::stable_partition(result_.differences.begin(), result_.differences.end(),
                          [](const Difference& difference) { return difference.kind == Difference::Kind::kEeprom; });
    // Swapped cables change the order of the slaves: they come first, because they cause most of the other differences.
    std::vector<Difference> wiring;
    for (const auto slave : planned_.empty() ? std::vector<std::uint16_t>{} : topology.swapped()) {
      wiring.push_back({Difference::Kind::kInOut, slave, topology.slaves[slave].entry_port, plan_of(slave)});
    }
    result_.differences.insert(result_.differences.begin(), wiring.begin(), wiring.end());
    return std::move(result_);
  }

 private:
  [[nodiscard]] std::uint16_t plan_of(std::size_t slave) const {
    const auto& plan = result_.plan_of_slave[slave];
    return plan ? static_cast<std::uint16_t>(*plan) : Difference::kNone;
  }
  void add(Difference difference) { result_.differences.push_back(difference); }

  [[nodiscard]] static bool carries(const ExpectedSlave& expected, const SlaveInfo& slave) {
    if (expected.alias) return slave.alias == *expected.alias;
    return expected.device_id && slave.device_id == expected.device_id;
  }
  /// A slave with the alias of a plan is not an extra slave, even if it is the second one.
  [[nodiscard]] bool spoken_for(std::size_t slave) const {
    return std::any_of(planned_.begin(), planned_.end(),
                       [&](const auto& plan) { return !plan.by_position() && carries(plan, found_[slave]); });
  }

  void take_by_name(std::size_t plan) {
    std::optional<std::size_t> first;
    const auto number = static_cast<std::uint16_t>(plan);
    for (std::size_t i = 0; i < found_.size(); ++i) {
      if (!carries(planned_[plan], found_[i])) continue;
      if (first) {
        add({Difference::Kind::kDuplicate, static_cast<std::uint16_t>(*first), static_cast<std::uint16_t>(i), number});
        return;
      }
      first = i;
    }
    if (!first && planned_[plan].optional) {
      result_.absent.push_back(plan);
      return;
    }
    if (!first) {
      add({Difference::Kind::kMissing, Difference::kNone, Difference::kNone, number});
      return;
    }
    take({plan, first});
  }

  /// Assigns a slave of a hot-connect group relative to its head.
  void take_behind(std::size_t plan, const HotConnectPlace& place) {
    const auto& plans = result_.plan_of_slave;
    const auto head = std::find(plans.begin(), plans.end(), std::optional(place.head));
    if (head == plans.end()) {
      if (planned_[place.head].optional) result_.absent.push_back(plan);
      return;  // the missing head has been reported
    }
    const auto slave = static_cast<std::size_t>(head - plans.begin()) + place.distance;
    const bool there = slave < plans.size() && !plans[slave];
    take({plan, there ? std::optional(slave) : std::nullopt});
  }

  void take(const Pair& pair) {
    const auto number = pair.plan ? static_cast<std::uint16_t>(*pair.plan) : Difference::kNone;
    const auto position = pair.slave ? static_cast<std::uint16_t>(*pair.slave) : Difference::kNone;
    if (!pair.slave) return add({Difference::Kind::kMissing, position, Difference::kNone, number});
    if (!pair.plan) {
      return add({found_[*pair.slave].usable() ? Difference::Kind::kExtra : Difference::Kind::kEeprom, position,
                  Difference::kNone, number});
    }
    result_.plan_of_slave[*pair.slave] = *pair.plan;
    const auto how = fit(planned_[*pair.plan], found_[*pair.slave]);
    if (how != Fit::kYes) add({kind_of(how), position, Difference::kNone, number});
  }

  [[nodiscard]] bool fits(const Pair& a, const Pair& b) const {
    return a.plan && b.slave && fit(planned_[*a.plan], found_[*b.slave]) == Fit::kYes;
  }
  [[nodiscard]] bool fits_itself(const Pair& a) const { return fits(a, a); }

  void take_in_order(std::span<const std::size_t> plans, std::span<const std::size_t> slaves) {
    if (planned_.empty()) return;
    const auto pairs = align(planned_, plans, found_, slaves);
    auto before = Difference::kNone;
    for (std::size_t i = 0; i < pairs.size(); ++i) {
      if (!pairs[i].slave) {
        add({Difference::Kind::kMissing, Difference::kNone, before, static_cast<std::uint16_t>(*pairs[i].plan)});
        continue;
      }
      before = static_cast<std::uint16_t>(*pairs[i].slave);
      if (i + 1 < pairs.size() && swapped(pairs[i], pairs[i + 1])) {
        add({Difference::Kind::kSwapped, static_cast<std::uint16_t>(*pairs[i].slave),
             static_cast<std::uint16_t>(*pairs[i + 1].slave), static_cast<std::uint16_t>(*pairs[i].plan)});
        before = static_cast<std::uint16_t>(*pairs[++i].slave);
        continue;
      }
      take(pairs[i]);
    }
  }

  [[nodiscard]] bool swapped(const Pair& a, const Pair& b) const {
    return a.plan && a.slave && b.plan && b.slave && !fits_itself(a) && !fits_itself(b) && fits(a, b) && fits(b, a);
  }

  std::span<const ExpectedSlave> planned_;
  std::span<const SlaveInfo> found_;
  LineComparison result_;
};

std::string device_text(const SlaveInfo& slave) {
  const auto& device = slave.description;
  const auto& name = device.name.empty() ? device.type : device.name;
  return fmt::format("{}{}vendor 0x{:08X} product 0x{:08X} revision 0x{:08X} serial {}", name, name.empty() ? "" : ", ",
                     device.vendor_id, device.product_code, device.revision, device.serial_number);
}

std::string rule_text(const char* what, const IdentityRule& rule) {
  if (rule.kind == IdentityRule::Kind::kAny) return {};
  return fmt::format(" {} {}0x{:08X}", what, rule.kind == IdentityRule::Kind::kAtLeast ? ">= " : "", rule.value);
}

/// How the slave is distinguished from the others.
std::string place_text(const ExpectedSlave& plan, std::size_t number) {
  if (plan.alias) return fmt::format("alias {}", *plan.alias);
  if (plan.device_id) return fmt::format("device ID {}", *plan.device_id);
  return fmt::format("slave {}", number);
}

std::string name_text(const ExpectedSlave& plan) {
  return plan.name.empty() ? std::string("a slave") : fmt::format("\"{}\"", plan.name);
}

std::string plan_text(const ExpectedSlave& plan, std::size_t number) {
  auto serial = plan.serial.kind == IdentityRule::Kind::kAny
                    ? std::string{}
                    : fmt::format(" serial {}{}", plan.serial.kind == IdentityRule::Kind::kAtLeast ? ">= " : "",
                                  plan.serial.value);
  const auto rules = rule_text("vendor", plan.vendor) + rule_text("product", plan.product) +
                     rule_text("revision", plan.revision) + serial;
  return fmt::format("{} ({}{}{})", name_text(plan), place_text(plan, number), rules.empty() ? "" : ":", rules);
}

/// When identical devices are adjacent, any of them may be the missing one.
std::string missing_text(const Difference& difference, std::span<const ExpectedSlave> planned,
                         std::span<const SlaveInfo> found) {
  const auto& plan = planned[difference.plan];
  auto text = fmt::format("missing: {}", plan_text(plan, difference.plan));
  if (!plan.by_position()) return text;
  if (difference.other >= found.size()) return text + ", in front of the others";
  const bool equal = fit(plan, found[difference.other]) == Fit::kYes;
  return text +
         fmt::format(", behind slave {}{}", difference.other, equal ? " or another of its kind before that" : "");
}

/// The number by which the slave of `plan` is identified.
std::pair<KnownBy, std::uint16_t> number_of(const ExpectedSlave& plan) {
  if (plan.alias) return {KnownBy::kAlias, *plan.alias};
  if (plan.device_id) return {KnownBy::kDeviceId, *plan.device_id};
  return {KnownBy::kPosition, std::uint16_t{0}};
}

facts::IdentityMismatch mismatch(const ExpectedSlave& plan, const esi::DeviceDescription& device) {
  const std::pair<const IdentityRule*, std::uint32_t> fields[] = {{&plan.vendor, device.vendor_id},
                                                                  {&plan.product, device.product_code},
                                                                  {&plan.revision, device.revision},
                                                                  {&plan.serial, device.serial_number}};
  for (std::size_t field = 0; field < std::size(fields); ++field) {
    const auto& [rule, found] = fields[field];
    if (rule->accepts(found)) continue;
    return {.number = static_cast<IdentityNumber>(field),
            .at_least = rule->kind == IdentityRule::Kind::kAtLeast,
            .expected = rule->value,
            .found = found};
  }
  return {};
}

}  // namespace

LineComparison compare_line(std::span<const ExpectedSlave> planned, std::span<const SlaveInfo> found,
                            const Topology& topology) {
  return Comparison(planned, found).run(topology);
}

std::string describe(const Difference& difference, std::span<const ExpectedSlave> planned,
                     std::span<const SlaveInfo> found) {
  const auto plan =
      difference.plan < planned.size() ? plan_text(planned[difference.plan], difference.plan) : std::string{};
  const auto device = difference.slave < found.size() ? device_text(found[difference.slave]) : std::string{};
  switch (difference.kind) {
    case Difference::Kind::kMissing:
      return missing_text(difference, planned, found);
    case Difference::Kind::kExtra:
      return fmt::format("extra: slave {} is not planned: {}", difference.slave, device);
    case Difference::Kind::kWrongDevice:
      return fmt::format("slave {}: {} is planned, found {}", difference.slave, plan, device);
    case Difference::Kind::kRevision:
      return fmt::format("slave {}: wrong revision: {} is planned, found {}", difference.slave, plan, device);
    case Difference::Kind::kSerial:
      return fmt::format("slave {}: wrong serial number: {} is planned, found {}", difference.slave, plan, device);
    case Difference::Kind::kSwapped:
      return fmt::format("slave {} and slave {} have changed places: {} is planned first", difference.slave,
                         difference.other, plan);
    case Difference::Kind::kInOut:
      return fmt::format("slave {}: IN and OUT are swapped, frames come in at port {}", difference.slave,
                         difference.other);
    case Difference::Kind::kDuplicate:
      return fmt::format("slave {} and slave {} both answer to the number of {}", difference.slave, difference.other,
                         plan);
    case Difference::Kind::kEeprom:
      return plan.empty() ? describe(*found[difference.slave].problem)
                          : fmt::format("{}; {} is planned there", describe(*found[difference.slave].problem), plan);
  }
  return {};
}

std::vector<std::string> describe(const LineComparison& comparison, std::span<const ExpectedSlave> planned,
                                  std::span<const SlaveInfo> found) {
  std::vector<std::string> sentences;
  for (const auto& difference : comparison.differences) sentences.push_back(describe(difference, planned, found));
  return sentences;
}

Error to_error(const Difference& difference, std::span<const ExpectedSlave> planned, std::span<const SlaveInfo> found) {
  const auto planned_count = static_cast<std::uint32_t>(planned.size());
  const auto found_count = static_cast<std::uint32_t>(found.size());
  switch (difference.kind) {
    case Difference::Kind::kMissing: {
      const auto [known_by, number] = number_of(planned[difference.plan]);
      return {facts::SlaveMissing{.plan = difference.plan,
                                  .known_by = known_by,
                                  .number = number,
                                  .planned = planned_count,
                                  .found = found_count}};
    }
    case Difference::Kind::kExtra:
      return {facts::SlaveExtra{.planned = planned_count, .found = found_count}, difference.slave};
    case Difference::Kind::kEeprom:
      return *found[difference.slave].problem;
    case Difference::Kind::kSwapped:
      return {facts::SlavesSwapped{difference.other}, difference.slave};
    case Difference::Kind::kInOut:
      return {facts::InOutSwapped{difference.other}, difference.slave};
    case Difference::Kind::kDuplicate: {
      const auto [known_by, number] = number_of(planned[difference.plan]);
      return {facts::DuplicateAlias{.other = difference.other, .known_by = known_by, .number = number},
              difference.slave};
    }
    case Difference::Kind::kWrongDevice:
    case Difference::Kind::kRevision:
    case Difference::Kind::kSerial:
      break;
  }
  return {mismatch(planned[difference.plan], found[difference.slave].description), difference.slave};
}

std::vector<SharedAlias> find_duplicate_aliases(std::span<const SlaveInfo> found) {
  std::map<std::uint16_t, std::vector<std::uint16_t>> positions;
  for (const auto& slave : found) {
    if (slave.alias != 0) positions[slave.alias].push_back(slave.ref.position);
  }
  std::vector<SharedAlias> duplicates;
  for (auto& [alias, list] : positions) {
    if (list.size() > 1) duplicates.push_back({alias, std::move(list)});
  }
  return duplicates;
}

std::string describe(const SharedAlias& duplicate) {
  std::string slaves = fmt::format("{}", duplicate.positions.front());
  for (std::size_t i = 1; i < duplicate.positions.size(); ++i) {
    slaves += fmt::format("{}{}", i + 1 == duplicate.positions.size() ? " and " : ", ", duplicate.positions[i]);
  }
  return fmt::format("alias {}: slaves {} have it, it does not identify any of them", duplicate.alias, slaves);
}

std::vector<std::string> describe_problems(std::span<const SlaveInfo> found) {
  std::vector<std::string> sentences;
  for (const auto& slave : found) {
    if (slave.problem) sentences.push_back(describe(*slave.problem));
  }
  for (const auto& duplicate : find_duplicate_aliases(found)) sentences.push_back(describe(duplicate));
  return sentences;
}

}  // namespace driveline::ecat_master
