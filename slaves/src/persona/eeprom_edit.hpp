#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "driveline/slaves/persona/persona.hpp"

namespace driveline::slaves {

/// Changes the EEPROM content `image` according to the personas. Neither length nor checksum of the content change: the
/// configuration area is left alone. Content that ends within a category is changed up to there.
void edit_eeprom(std::span<const Persona> personas, std::vector<std::byte>& image);

}  // namespace driveline::slaves
