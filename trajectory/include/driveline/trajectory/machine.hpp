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

/// An axis, or a coordinate of moves, with the unit shown to users.
struct NamedAxis {
  std::string name;                    ///< e.g. "x"
  const PositionUnit* unit = nullptr;  ///< unit of its positions
};

/// A parameter of a machine as given in a file.
struct MachineValue {
  std::string name;        ///< e.g. "rod"
  double value = 0.0;      ///< in the unit of the machine; 0 or 1 for a yes/no parameter
  bool is_choice = false;  ///< a yes/no parameter
};

/// A machine with kinematics as described in files of moves and in line descriptions: its kind, its lengths and their
/// unit. Linear coordinates have the same unit; angles are in degrees.
class Machine {
 public:
  /// Creates a machine. Errors name the wrong parameter: `type`, `unit`, or a length or yes/no parameter.
  [[nodiscard]] static tl::expected<Machine, KinematicError> make(std::string_view kind, std::string_view unit,
                                                                  std::vector<MachineValue> values);

  /// Kind of the machine, e.g. "delta".
  [[nodiscard]] const std::string& kind() const noexcept { return kind_; }
  /// Unit of its lengths.
  [[nodiscard]] const PositionUnit& unit() const noexcept { return *unit_; }
  /// Unit of a coordinate of its tool.
  [[nodiscard]] const PositionUnit& unit_of(const KinematicCoordinate& coordinate) const;
  /// Parameters as given.
  [[nodiscard]] std::span<const MachineValue> values() const noexcept { return values_; }
  /// Kinematics of the machine; valid as long as this object or a copy of it exists.
  [[nodiscard]] const Kinematics& kinematics() const noexcept { return *kinematics_; }
  /// Coordinates of the moves of a group with these axes: the coordinates of the tool, then the axes that do not belong
  /// to the machine. Precondition: fault_of(axes) is empty.
  [[nodiscard]] std::vector<NamedAxis> coordinates(std::span<const NamedAxis> axes) const;
  /// Explains why the first of these axes cannot be the joints of the machine, in this order: too few, or an angle
  /// instead of a length. A sentence without a full stop; empty if they can.
  [[nodiscard]] std::string fault_of(std::span<const NamedAxis> axes) const;
  /// Describes how `other` differs from this machine, as a sentence without a full stop; empty if both are the same.
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
