#pragma once

#include <cstdint>
#include <string>

#include "driveline/slaves/msd/core/msd_parameters.hpp"
#include "driveline/slaves/od/object_dictionary.hpp"

namespace driveline::slaves::msd {

/// Fixed properties of an individual drive.
struct FactoryFacts {
  Variant variant = Variant::kMsd;  ///< identity, dictionary
  FirmwareVersion firmware;         ///< 100Ah
  std::uint32_t serial_number = 1;  ///< 1018h:04
  std::string name;                 ///< P 3
  ControllerParameters controller;  ///< sanitized
};
/// Returns the properties that these parameters specify. Not for use in the cycle.
[[nodiscard]] FactoryFacts factory_facts(const MsdParameters& parameters);

/// Writes the values that are specific to this drive, not to its type: identity, motor, controller. Not for use in the
/// cycle.
void write_factory_settings(const FactoryFacts& facts, const ServoMotor& motor, ObjectDictionary& dictionary);

}  // namespace driveline::slaves::msd
