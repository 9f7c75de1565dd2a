#pragma once

#include <memory>
#include <span>

#include "driveline/slaves/esc/slave.hpp"
#include "driveline/slaves/persona/persona.hpp"

namespace driveline::slaves {

/// Returns a simulated slave whose device has these quirks. `device` must not be null; it is the object behind
/// Slave::device() only if `personas` is empty. EEPROM personas change the content that the slave starts with. Values
/// are within the limits of their rows (kPersonas), each kind appears once.
[[nodiscard]] std::unique_ptr<Slave> make_persona_slave(std::unique_ptr<Device> device, const SlaveOptions& options,
                                                        std::span<const Persona> personas);

/// Whether a persona changes the content of the EEPROM.
[[nodiscard]] bool changes_eeprom(PersonaKind kind) noexcept;

}  // namespace driveline::slaves
