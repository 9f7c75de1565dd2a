#pragma once

#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <tl/expected.hpp>
#include <vector>

#include "driveline/trajectory/kinematic_kinds.hpp"
#include "driveline/trajectory/kinematics.hpp"
#include "driveline/trajectory/position_unit.hpp"

namespace driveline::trajectory {

/// An axis, or a coordinate of moves, as people read it.
struct NamedAxis {
  std::string name;                    ///< "x"
  const PositionUnit* unit = nullptr;  ///< of its positions
};

/// A value of a machine as a file gives it.
struct MachineValue {
  std::string name;        ///< "rod"
  double value = 0.0;      ///< in the unit of the machine; of a choice 0 or 1
  bool is_choice = false;  ///< written as yes or no
};

/// A machine with kinematics as files describe it: its kind, its lengths and the unit of them, which is that of the
/// lengths among its coordinates, too; angles are in degrees. The same words in files of moves and in line
/// descriptions.
class Machine {
 public:
  /// Errors name the value that is wrong: `type`, `unit`, or that of a length or a choice.
  [[nodiscard]] static tl::expected<Machine, KinematicError> make(std::string_view kind, std::string_view unit,
                                                                  std::vector<MachineValue> values);

  /// "delta".
  [[nodiscard]] const std::string& kind() const noexcept { return kind_; }
  /// Of its lengths.
  [[nodiscard]] const PositionUnit& unit() const noexcept { return *unit_; }
  /// Of a coordinate of its tool.
  [[nodiscard]] const PositionUnit& unit_of(const KinematicCoordinate& coordinate) const;
  /// As they were given.
  [[nodiscard]] std::span<const MachineValue> values() const noexcept { return values_; }
  /// Lives as long as this object, and its copies.
  [[nodiscard]] const Kinematics& kinematics() const noexcept { return *kinematics_; }
  /// Of the moves of a group with such axes: those of the tool, then the axes that the machine does not have.
  /// The axes must be possible.
  [[nodiscard]] std::vector<NamedAxis> coordinates(std::span<const NamedAxis> axes) const;
  /// Why these cannot be its joints, in this order, and what is behind them: too few, or an angle for a length. A
  /// sentence without a full stop; empty: they can.
  [[nodiscard]] std::string fault_of(std::span<const NamedAxis> axes) const;
  /// What `other` has that this one has not, as a sentence without a full stop; empty: both are the same machine.
  [[nodiscard]] std::string difference_to(const Machine& other) const;

 private:
  Machine(std::string_view kind, const PositionUnit& unit, std::vector<MachineValue> values,
          std::shared_ptr<const Kinematics> kinematics);
  [[nodiscard]] double value_of(std::string_view name) const;

  std::string kind_;
  const PositionUnit* unit_;
  std::vector<MachineValue> values_;
  std::shared_ptr<const Kinematics> kinematics_;
};

}  // namespace driveline::trajectory
