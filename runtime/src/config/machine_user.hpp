#pragma once

#include <optional>
#include <string>

#include "driveline/runtime/config/telemetry_config.hpp"

namespace driveline::runtime {

/// The user of that name, or of that decimal number, which need not have a name: its group has the same number then.
/// None: there is no such user on this machine.
[[nodiscard]] std::optional<MachineUser> find_user(const std::string& name);

}  // namespace driveline::runtime
