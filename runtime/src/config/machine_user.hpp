#pragma once

#include <optional>
#include <string>

#include "driveline/runtime/config/telemetry_config.hpp"

namespace driveline::runtime {

/// Finds a user by name or decimal number. A number needs no entry in the user database; its group then has the same
/// number. None: there is no such user on this machine.
[[nodiscard]] std::optional<MachineUser> find_user(const std::string& name);

}  // namespace driveline::runtime
