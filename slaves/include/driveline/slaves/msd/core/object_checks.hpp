#pragma once

#include "driveline/slaves/od/object_dictionary.hpp"

/// Checks of values beyond type and range.
namespace driveline::slaves::msd {

/// Whether the parameters are consistent with each other (logic check of the manual, 8.2.5). \rtsafe
[[nodiscard]] bool parameters_consistent(const ObjectDictionary& dictionary) noexcept;
/// Whether a new value is consistent with the current parameters. \rtsafe
[[nodiscard]] bool consistent_with(const ObjectDictionary& dictionary, const EntryRow& row, std::uint64_t raw) noexcept;
/// Whether the object can have this value, regardless of others. \rtsafe
[[nodiscard]] bool possible_value(const EntryRow& row, std::uint64_t raw) noexcept;

}  // namespace driveline::slaves::msd
