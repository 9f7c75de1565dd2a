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

/// Position of a slave in a hot-connect group: number of slaves behind the head of the group, in the order in which
/// frames pass them.
struct HotConnectPlace {
  std::size_t head = 0;      ///< plan number of the head
  std::size_t distance = 1;  ///< 1: directly behind the head
  constexpr bool operator==(const HotConnectPlace&) const = default;
};

/// A planned slave: its identity, and how it is distinguished from the others.
struct ExpectedSlave {
  std::string name;                         ///< for messages
  IdentityRule vendor;                      ///< rule for the vendor ID in the EEPROM
  IdentityRule product;                     ///< rule for the product code in the EEPROM
  IdentityRule revision;                    ///< rule for the revision in the EEPROM
  IdentityRule serial;                      ///< rule for the serial number in the EEPROM
  std::optional<std::uint16_t> alias;       ///< station alias; finds the slave anywhere on the line
  std::optional<std::uint16_t> device_id;   ///< explicit device identification; finds the slave anywhere on the line
  bool optional = false;                    ///< the slave may be missing; needs alias or device ID
  std::optional<HotConnectPlace> behind{};  ///< found relative to the head of its group; optional if the head is
  /// Whether the slave is identified only by its position on the line. \rtsafe
  [[nodiscard]] bool by_position() const noexcept { return !alias && !device_id && !behind; }
};

/// A difference between the line and the plan.
struct Difference {
  /// Kind of difference.
  enum class Kind : std::uint8_t {
    kMissing,      ///< planned, but not found
    kExtra,        ///< found, but not planned
    kWrongDevice,  ///< another vendor or product
    kRevision,     ///< the planned device in another revision
    kSerial,       ///< the planned device with another serial number
    kSwapped,      ///< two adjacent slaves are swapped: `slave` and `other`
    kInOut,        ///< frames enter the slave at another port than IN: its cables are swapped
    kDuplicate,    ///< an alias or device ID in the plan exists more than once on the line
    kEeprom,       ///< the identity of the slave is unknown: SlaveInfo::problem
  };
  /// No slave, or no plan.
  static constexpr std::uint16_t kNone = 0xFFFF;
  Kind kind = Kind::kMissing;   ///< kind of difference
  std::uint16_t slave = kNone;  ///< position on the line; kNone: not on the line
  /// kSwapped, kDuplicate: the second slave; kInOut: the port; kMissing: the slave behind which it should be.
  std::uint16_t other = kNone;
  std::uint16_t plan = kNone;  ///< plan number; kNone: not planned
  bool operator==(const Difference&) const = default;
};

/// The differences between a line and its plans, and the assignment of plans to slaves.
struct LineComparison {
  /// Swapped cables first, then unusable EEPROMs, because they may cause the others; the rest in line order.
  std::vector<Difference> differences;
  /// For each slave of the line the number of its plan; empty for a slave that is not planned.
  std::vector<std::optional<std::size_t>> plan_of_slave;
  std::vector<std::size_t> absent;  ///< plans of missing optional slaves
  /// Whether the line is as planned.
  [[nodiscard]] bool matches() const noexcept { return differences.empty(); }
};

/// Compares the planned slaves with those on the line. Slaves planned by alias or device ID may be anywhere; the others
/// must appear in the order of the plan. The comparison is an alignment: one missing slave is one difference, whatever
/// the number of slaves behind it. An empty plan accepts anything. `topology` may be empty; its swapped slaves are
/// differences.
[[nodiscard]] LineComparison compare_line(std::span<const ExpectedSlave> planned, std::span<const SlaveInfo> found,
                                          const Topology& topology);

/// The difference in one sentence, with the planned and the found slave.
[[nodiscard]] std::string describe(const Difference& difference, std::span<const ExpectedSlave> planned,
                                   std::span<const SlaveInfo> found);

/// All differences, one sentence each; for a refused Master::configure(), with its slaves and expected_slaves() of the
/// plans.
[[nodiscard]] std::vector<std::string> describe(const LineComparison& comparison,
                                                std::span<const ExpectedSlave> planned,
                                                std::span<const SlaveInfo> found);

/// The difference as an error, for a caller that cannot use such a line.
[[nodiscard]] Error to_error(const Difference& difference, std::span<const ExpectedSlave> planned,
                             std::span<const SlaveInfo> found);

/// A station alias (not 0) that several slaves have, with all their positions.
struct SharedAlias {
  std::uint16_t alias = 0;               ///< station alias
  std::vector<std::uint16_t> positions;  ///< positions of these slaves
};
/// Finds all duplicate aliases, in ascending order; alias 0 means no alias. Allocates.
[[nodiscard]] std::vector<SharedAlias> find_duplicate_aliases(std::span<const SlaveInfo> found);
/// The duplicate in one sentence.
[[nodiscard]] std::string describe(const SharedAlias& duplicate);

/// Problems of a line that do not depend on plans, one sentence each: unusable EEPROMs, duplicate aliases.
[[nodiscard]] std::vector<std::string> describe_problems(std::span<const SlaveInfo> found);

}  // namespace driveline::ecat_master
