#pragma once

#include "driveline/sdo/sdo_abort.hpp"

namespace driveline::wire {

// CoE has the abort codes of CANopen (ETG.1000.6 Table 41).
using sdo::kSdoAbortTexts;
using sdo::SdoAbort;
using sdo::SdoAbortText;
using sdo::to_text;

}  // namespace driveline::wire
