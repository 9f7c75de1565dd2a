#pragma once

#include <pugixml.hpp>
#include <vector>

#include "driveline/esi/device_description.hpp"
#include "xml_context.hpp"

namespace driveline::esi {

/// Reads the objects of a Profile/Dictionary element, ascending by index; its DataTypes resolve the type names.
[[nodiscard]] std::vector<Object> read_dictionary(XmlContext& context, pugi::xml_node dictionary);

/// Appends the Dictionary element (DataTypes and Objects) to a Profile element.
void write_dictionary(pugi::xml_node profile, const std::vector<Object>& objects);

}  // namespace driveline::esi
