#pragma once

#include <cstdint>
#include <span>
#include <string_view>
#include <vector>

#include "driveline/slaves/msd/sercos/servoone_dictionary.hpp"

namespace driveline::slaves::msd::sercos {

/// The drive whose data a check looks at.
struct CheckedDrive {
  const ServoOneDictionary& idns;  ///< its dictionary
  std::uint8_t drive = 0;          ///< its number
};

/// Settings without which the drive refuses to change to a phase: a row of the table of checks.
struct PhaseCheck {
  std::uint8_t phase = 3;                               ///< 3: checked by S-0-0127; 4: by S-0-0128
  wire::Idn idn;                                        ///< the datum that is invalid
  std::string_view reason{};                            ///< the mistake, as continuation of the number
  bool (*broken)(const CheckedDrive& drive) = nullptr;  ///< whether these settings are invalid
  std::string_view source{};                            ///< lines of the manual; "ours" marks what no source states
};

/// An invalid datum and the reason.
struct InvalidDatum {
  wire::Idn idn;            ///< the datum
  std::string_view reason;  ///< the mistake, from PhaseCheck or WeightingRule
};

/// Returns the table of all checks but those of the weighting, which are weighting_rules() and belong to phase 3.
[[nodiscard]] std::span<const PhaseCheck> phase_checks() noexcept;
/// Returns what the checks for this phase, 3 or 4, look at: the content of S-0-0018 and S-0-0019. Ascending.
[[nodiscard]] std::vector<std::uint16_t> checked_idns(std::uint8_t phase);
/// Runs the checks for this phase, 3 or 4: returns all that is invalid, in the order of the tables.
[[nodiscard]] std::vector<InvalidDatum> find_invalid(const CheckedDrive& drive, std::uint8_t phase);
/// Runs the checks, and puts the numbers of what is invalid into S-0-0021 (phase 3) or S-0-0022 (phase 4), ascending;
/// empty after a good check. Changes no state. Returns whether all is valid.
[[nodiscard]] bool check_phase(ServoOneDictionary& idns, std::uint8_t drive, std::uint8_t phase);
/// Fills S-0-0018 and S-0-0019 of a drive.
void fill_checked_lists(ServoOneDictionary& idns, std::uint8_t drive);

}  // namespace driveline::slaves::msd::sercos
