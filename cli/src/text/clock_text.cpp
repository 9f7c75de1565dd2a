#include "text/clock_text.hpp"

#include "driveline/ecat_master/dc/lock_detector.hpp"
#include "driveline/ecat_master/error/clock_fault.hpp"

namespace driveline::cli {

using ecat_master::dc::ClockFault;
using ecat_master::dc::LockCause;

std::string with_clock_remedy(const ecat_master::Error& error) {
  auto sentence = ecat_master::describe(error);
  if (error.kind != ecat_master::ErrorKind::kClock) return sentence;
  if (static_cast<ClockFault>(error.code) != ClockFault::kNotLocked) return sentence;
  const auto cause = static_cast<LockCause>(error.extra);
  // Of the others the sentence says it all.
  if (cause == LockCause::kNoReference || cause == LockCause::kFrequencyLimit) return sentence;
  return sentence +
         "; the limit is a hundredth of the cycle: choose a longer one ([line] cycle_us) or give each end of the wire "
         "a "
         "CPU of its own ([realtime] cpu and, where `driveline simulate` is the line, simulation_cpu and its "
         "--busy-poll)";
}

}  // namespace driveline::cli
