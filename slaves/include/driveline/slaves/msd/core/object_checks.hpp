#pragma once

#include "driveline/slaves/od/object_dictionary.hpp"

/// Checks of values beyond type and range.
namespace driveline::slaves::msd {

/// Whether parameters fit each other (the manual's logic check, 8.2.5). \rtsafe
[[nodiscard]] bool parameters_consistent(const ObjectDictionary& dictionary) noexcept;
/// The same for one new value against the present ones. \rtsafe
[[nodiscard]] bool consistent_with(const ObjectDictionary& dictionary, const EntryRow& row, std::uint64_t raw) noexcept;
/// Whether the object can have this value, irrespective of others. \rtsafe
[[nodiscard]] bool possible_value(const EntryRow& row, std::uint64_t raw) noexcept;

}  // namespace driveline::slaves::msd
