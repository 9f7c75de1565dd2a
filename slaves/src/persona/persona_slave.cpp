#include "driveline/slaves/persona/persona_slave.hpp"

#include <utility>

#include "persona/eeprom_edit.hpp"
#include "persona/persona_device.hpp"

namespace driveline::slaves {
namespace {

using std::chrono::microseconds;
using std::chrono::milliseconds;
using Kind = PersonaKind;

constexpr bool personas_are_in_order() noexcept {
  for (std::size_t i = 0; i < kPersonas.size(); ++i) {
    if (static_cast<std::size_t>(kPersonas[i].kind) != i) return false;
  }
  return true;
}
static_assert(personas_are_in_order(), "persona_row() uses the kind as index");

SlaveOptions changed_options(SlaveOptions options, std::span<const Persona> personas) {
  if (const auto* slow = find_persona(personas, Kind::kSlowTransitions); slow != nullptr) {
    options.al.transition_delay = milliseconds{slow->value};
  }
  if (const auto* slow = find_persona(personas, Kind::kSlowEeprom); slow != nullptr) {
    options.sii.busy_time = microseconds{slow->value};
  }
  if (has_persona(personas, Kind::kEepromReads4Bytes)) options.sii.reads_8_bytes = false;
  edit_eeprom(personas, options.sii_image);
  return options;
}

}  // namespace

bool changes_eeprom(PersonaKind kind) noexcept {
  return kind >= Kind::kEepromTypesSwapped && kind <= Kind::kEepromWithoutMailbox;
}

std::unique_ptr<Slave> make_persona_slave(std::unique_ptr<Device> device, const SlaveOptions& options,
                                          std::span<const Persona> personas) {
  if (personas.empty()) return std::make_unique<Slave>(std::move(device), options);
  auto with_personas = std::make_unique<PersonaDevice>(std::move(device), personas);
  PersonaDevice& connected = *with_personas;
  auto slave = std::make_unique<Slave>(std::move(with_personas), changed_options(options, personas));
  connected.connect(slave->esc());
  return slave;
}

}  // namespace driveline::slaves
