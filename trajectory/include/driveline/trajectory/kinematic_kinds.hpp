#pragma once

#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <tl/expected.hpp>

#include "driveline/trajectory/kinematics.hpp"

namespace driveline::trajectory {

/// A value of a machine as a file gives it: in m, or 0 and 1 for no and yes.
struct KinematicParameter {
  std::string_view name;  ///< "rod"
  double value = 0.0;     ///< m
};

/// A kind of machine, as files call it.
struct KinematicKind {
  std::string_view name;                      ///< "delta"
  std::span<const std::string_view> lengths;  ///< all of them are needed
  std::span<const std::string_view> choices;  ///< yes or no; no if it is not said
};

/// "cartesian", "scara", "delta", "linear_delta".
[[nodiscard]] std::span<const KinematicKind> kinematic_kinds() noexcept;
/// Why there is no such machine.
struct KinematicError {
  std::string reason;  ///< one sentence without a full stop: what is not known, missing, twice or out of range
  std::string key{};   ///< the value that is wrong, or "type" for the kind; empty: one is missing
};

/// The machine of a kind.
[[nodiscard]] tl::expected<std::unique_ptr<Kinematics>, KinematicError> make_kinematics(
    std::string_view kind, std::span<const KinematicParameter> parameters);

}  // namespace driveline::trajectory
