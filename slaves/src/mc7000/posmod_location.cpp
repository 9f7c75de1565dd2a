#include "driveline/slaves/mc7000/posmod_location.hpp"

namespace driveline::slaves::mc7000 {

std::string_view text_of(PosModLocation location) noexcept {
  switch (location) {
    case PosModLocation::kNone:
      return "no error";
    case PosModLocation::kPositiveLimitSwitch:
      return "positive hardware limit switch reached";
    case PosModLocation::kNegativeLimitSwitch:
      return "negative hardware limit switch reached";
    case PosModLocation::kPositiveSoftwareLimit:
      return "positive software limit reached";
    case PosModLocation::kNegativeSoftwareLimit:
      return "negative software limit reached";
    case PosModLocation::kNoReference:
      return "no reference point";
    case PosModLocation::kNoHardware:
      return "addressed hardware is not there";
    case PosModLocation::kNoProgram:
      return "selected program is not there";
    case PosModLocation::kNoRecord:
      return "jump to a record that is not there";
    case PosModLocation::kNoSubroutine:
      return "called subroutine is not there";
    case PosModLocation::kOutsideRange:
      return "target outside the positioning range";
    case PosModLocation::kDivisionByZero:
      return "division by zero";
    case PosModLocation::kNesting:
      return "nesting too deep";
    case PosModLocation::kManualTimeout:
      return "timeout in manual mode";
    case PosModLocation::kNotReached:
      return "target not reached";
    case PosModLocation::kNoFeed:
      return "feed is held";
    case PosModLocation::kHeldByPcProgram:
      return "a PC program holds manual mode";
    case PosModLocation::kIndexOverflow:
      return "index out of range";
    case PosModLocation::kTooFast:
      return "above the maximum velocity";
    case PosModLocation::kNotEnabled:
      return "controller is not enabled";
    case PosModLocation::kMoving:
      return "command not allowed while the axis moves";
  }
  return {};
}

}  // namespace driveline::slaves::mc7000
