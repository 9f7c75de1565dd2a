#pragma once

#include <string>
#include <string_view>

#include "driveline/runtime/error.hpp"
#include "driveline/slaves/persona/persona.hpp"

namespace driveline::runtime {

/// Reads a persona of a line description: "no-clock", or with a value "deaf-after-preop=300", decimal or 0x.... Without
/// it the value of the table applies. Error: a sentence, which lists the names if the name is unknown.
[[nodiscard]] Result<slaves::Persona> parse_persona(std::string_view text);

/// Returns all personas for users: name, value, what the device does, source.
[[nodiscard]] std::string persona_help();

}  // namespace driveline::runtime
