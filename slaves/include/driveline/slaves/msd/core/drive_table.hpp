#pragma once

#include <span>
#include <vector>

#include "driveline/slaves/msd/core/variant.hpp"
#include "driveline/slaves/od/entry_row.hpp"

namespace driveline::slaves::msd {

/// All rows of the drive's object dictionary but those of its bus: what a table is made of.
[[nodiscard]] std::vector<EntryRow> drive_rows(Variant variant);

/// Parts of it by address range and, for the modes of operation, by use. Identity, errors, stored parameters:
/// 1000h-1018h.
[[nodiscard]] std::span<const EntryRow> identity_rows();
/// Manufacturer's parameters, 2000h-5FFFh.
[[nodiscard]] std::span<const EntryRow> parameter_rows();
/// CiA 402 objects that every mode uses.
[[nodiscard]] std::span<const EntryRow> profile_rows();
/// Objects of single modes of operation and of the units.
[[nodiscard]] std::span<const EntryRow> mode_rows();
/// Function selectors and images of the terminals, the motor brake.
[[nodiscard]] std::span<const EntryRow> terminal_rows();
/// Touch probe, warnings, protection of the motor, actual values in units of people.
[[nodiscard]] std::span<const EntryRow> function_rows();

}  // namespace driveline::slaves::msd
