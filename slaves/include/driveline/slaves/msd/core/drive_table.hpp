#pragma once

#include <span>
#include <vector>

#include "driveline/slaves/msd/core/variant.hpp"
#include "driveline/slaves/od/entry_row.hpp"

namespace driveline::slaves::msd {

/// Returns all rows of the drive's object dictionary except those of its bus.
[[nodiscard]] std::vector<EntryRow> drive_rows(Variant variant);

/// Returns the rows of identity, errors and stored parameters: 1000h-1018h. This and the following functions return
/// parts of the rows, by address range and, for the modes of operation, by use.
[[nodiscard]] std::span<const EntryRow> identity_rows();
/// Returns the manufacturer's parameters, 2000h-5FFFh.
[[nodiscard]] std::span<const EntryRow> parameter_rows();
/// Returns the CiA 402 objects that every mode uses.
[[nodiscard]] std::span<const EntryRow> profile_rows();
/// Returns the objects of individual modes of operation, and of the units.
[[nodiscard]] std::span<const EntryRow> mode_rows();
/// Returns the function selectors and images of the terminals, and the motor brake.
[[nodiscard]] std::span<const EntryRow> terminal_rows();
/// Returns touch probe, warnings, protection of the motor, and actual values in motor units.
[[nodiscard]] std::span<const EntryRow> function_rows();

}  // namespace driveline::slaves::msd
