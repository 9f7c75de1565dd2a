#pragma once

#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <tl/expected.hpp>

#include "driveline/trajectory/kinematics.hpp"

namespace driveline::trajectory {

/// A parameter of a machine in SI units: a length in m, or 0 and 1 for no and yes.
struct KinematicParameter {
  std::string_view name;  ///< e.g. "rod"
  double value = 0.0;     ///< m, or 0 and 1
};

/// A kind of machine, as named in files.
struct KinematicKind {
  std::string_view name;                      ///< e.g. "delta"
  std::span<const std::string_view> lengths;  ///< names of the lengths; all are required
  std::span<const std::string_view> choices;  ///< names of the yes/no parameters; default no
};

/// All kinds: "cartesian", "scara", "delta", "linear_delta".
[[nodiscard]] std::span<const KinematicKind> kinematic_kinds() noexcept;
/// Reason why a machine cannot be created.
struct KinematicError {
  std::string reason;  ///< one sentence without a full stop: what is unknown, missing, duplicated or out of range
  std::string key{};   ///< the wrong parameter, or "type" for the kind; empty: a parameter is missing
};

/// The error as a sentence.
[[nodiscard]] inline std::string describe(const KinematicError& error) {
  return error.reason;
}

/// Creates the machine of a kind.
[[nodiscard]] tl::expected<std::unique_ptr<Kinematics>, KinematicError> make_kinematics(
    std::string_view kind, std::span<const KinematicParameter> parameters);

}  // namespace driveline::trajectory
