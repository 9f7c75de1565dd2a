#pragma once

#include <string_view>

#include "driveline/wire/soe.hpp"

namespace driveline::ecat_master {

/// The display format of an operation datum in one word: "unsigned".
[[nodiscard]] std::string_view display_text(wire::SoeDisplay display) noexcept;

}  // namespace driveline::ecat_master
