#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "driveline/ecat_master/discovery/discovery.hpp"
#include "driveline/ecat_master/discovery/topology.hpp"

namespace driveline::ecat_master {

/// A condition on one number of a slave's identity.
struct IdentityRule {
  /// Kind of condition.
  enum class Kind : std::uint8_t { kAny, kEqual, kAtLeast };
  Kind kind = Kind::kAny;   ///< any value, this one, or at least this one
  std::uint32_t value = 0;  ///< reference value for kEqual and kAtLeast

  /// Exactly `value`. \rtsafe
  [[nodiscard]] static constexpr IdentityRule equal(std::uint32_t value) noexcept { return {Kind::kEqual, value}; }
  /// `value` or more. \rtsafe
  [[nodiscard]] static constexpr IdentityRule at_least(std::uint32_t value) noexcept { return {Kind::kAtLeast, value}; }
  /// Whether `found` fulfils the rule. \rtsafe
  [[nodiscard]] constexpr bool accepts(std::uint32_t found) const noexcept {
    return kind == Kind::kAny || (kind == Kind::kEqual ? found == value : found >= value);
  }
  constexpr bool operator==(const IdentityRule&) const = default;
};

/// The place of a slave in a hot-connect group: so many slaves behind the head of the group, in the order in which
/// frames pass them.
struct GroupPlace {
  std::size_t head = 0;      ///< number of its plan
  std::size_t distance = 1;  ///< 1: right behind it
  constexpr bool operator==(const GroupPlace&) const = default;
};

/// A planned slave: its identity, and how it is told from the others.
struct ExpectedSlave {
  std::string name;                        ///< for messages
  IdentityRule vendor;                     ///< by the EEPROM
  IdentityRule product;                    ///< by the EEPROM
  IdentityRule revision;                   ///< by the EEPROM
  IdentityRule serial;                     ///< by the EEPROM
  std::optional<std::uint16_t> alias;      ///< anywhere on the line, by its station alias
  std::optional<std::uint16_t> device_id;  ///< anywhere on the line, by its explicit device identification
  bool optional = false;                   ///< it may be missing; needs alias or device ID
  std::optional<GroupPlace> behind{};      ///< found by the head of its group; optional if the head is
  /// Whether it is identified by its place on the line alone. \rtsafe
  [[nodiscard]] bool by_position() const noexcept { return !alias && !device_id && !behind; }
};

/// One way in which the line is not what was planned.
struct Difference {
  /// Kind of difference.
  enum class Kind : std::uint8_t {
    kMissing,      ///< planned, nowhere found
    kExtra,        ///< found, not planned
    kWrongDevice,  ///< another vendor or product
    kRevision,     ///< the right device in another revision
    kSerial,       ///< the right device, but not this one
    kSwapped,      ///< two neighbours have changed places: `slave` and `other`
    kInOut,        ///< a slave is entered at another port than IN: its cables are swapped
    kDuplicate,    ///< an alias or device ID by which a slave is planned is there more than once
    kEeprom,       ///< its identity is unknown: SlaveInfo::problem
  };
  /// No such slave or plan.
  static constexpr std::uint16_t kNone = 0xFFFF;
  Kind kind = Kind::kMissing;   ///< kind of difference
  std::uint16_t slave = kNone;  ///< position on the line; kNone: not there
  /// The second slave of kSwapped and kDuplicate; the port of kInOut; of kMissing the slave behind which it should be.
  std::uint16_t other = kNone;
  std::uint16_t plan = kNone;  ///< number in the plan; kNone: not planned
  bool operator==(const Difference&) const = default;
};

/// How a line differs from its plans, and which plan belongs to which slave.
struct LineComparison {
  /// Swapped cables first and unusable EEPROMs next, because they may cause the others; the rest in the order of the
  /// line.
  std::vector<Difference> differences;
  /// For each slave of the line the number of its plan; nothing for a slave that is not planned.
  std::vector<std::optional<std::size_t>> plan_of_slave;
  std::vector<std::size_t> absent;  ///< plans of slaves that may be missing, and are
  /// The line is as planned.
  [[nodiscard]] bool matches() const noexcept { return differences.empty(); }
};

/// Compares the planned slaves with those on the line. Slaves that are planned by alias or device ID may be anywhere;
/// the rest must come in the order of the plan. The comparison is an alignment: one missing slave is one difference,
/// not as many as there are slaves behind it. An empty plan accepts anything. `topology` may be empty; its swapped
/// slaves are differences.
[[nodiscard]] LineComparison compare_line(std::span<const ExpectedSlave> planned, std::span<const SlaveInfo> found,
                                          const Topology& topology);

/// One sentence for each difference, with what was planned and what is there.
[[nodiscard]] std::string describe(const Difference& difference, std::span<const ExpectedSlave> planned,
                                   std::span<const SlaveInfo> found);

/// All of them, one sentence each: of Master::configure() that was refused, with the slaves and expected_slaves() of
/// the plans.
[[nodiscard]] std::vector<std::string> describe(const LineComparison& comparison,
                                                std::span<const ExpectedSlave> planned,
                                                std::span<const SlaveInfo> found);

/// The difference as an error, for a caller that cannot use such a line.
[[nodiscard]] Error to_error(const Difference& difference, std::span<const ExpectedSlave> planned,
                             std::span<const SlaveInfo> found);

/// Station aliases (not 0) that several slaves have, each with all of their positions.
struct DuplicateAlias {
  std::uint16_t alias = 0;               ///< station alias
  std::vector<std::uint16_t> positions;  ///< of the slaves that have it
};
/// All of them, in ascending order; alias 0 is none. Allocates.
[[nodiscard]] std::vector<DuplicateAlias> find_duplicate_aliases(std::span<const SlaveInfo> found);
/// One sentence on the duplicate.
[[nodiscard]] std::string describe(const DuplicateAlias& duplicate);

/// Problems of a line that do not depend on plans, one sentence each: unusable EEPROMs, duplicate aliases.
[[nodiscard]] std::vector<std::string> describe_problems(std::span<const SlaveInfo> found);

}  // namespace driveline::ecat_master
