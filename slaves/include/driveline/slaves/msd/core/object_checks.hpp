#pragma once

#include "driveline/slaves/od/object_dictionary.hpp"

/// What the drive asks of values beyond type and range.
namespace driveline::slaves::msd {

/// Parameters that only make sense together do (the manual's logic check, 8.2.5). \rtsafe
[[nodiscard]] bool parameters_consistent(const ObjectDictionary& dictionary) noexcept;
/// The same of one new value against those that are there. \rtsafe
[[nodiscard]] bool consistent_with(const ObjectDictionary& dictionary, const EntryRow& row, std::uint64_t raw) noexcept;
/// The object can have this value, whatever the others have. \rtsafe
[[nodiscard]] bool possible_value(const EntryRow& row, std::uint64_t raw) noexcept;

}  // namespace driveline::slaves::msd
