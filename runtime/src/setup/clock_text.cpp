#include "driveline/runtime/setup/clock_text.hpp"

namespace driveline::runtime {

using ecat_master::dc::LockCause;

std::string with_clock_remedy(const ecat_master::Error& error) {
  auto sentence = ecat_master::describe(error);
  const auto* not_locked = error.as<ecat_master::facts::NotLocked>();
  if (not_locked == nullptr) return sentence;
  // The sentences of these causes already contain the remedy.
  if (not_locked->cause == LockCause::kNoReference || not_locked->cause == LockCause::kFrequencyLimit) return sentence;
  return sentence +
         "; the limit is a hundredth of the cycle: choose a longer one ([line] cycle_us) or give each end of the wire "
         "a "
         "CPU of its own ([realtime] cpu and, where `driveline simulate` is the line, simulation_cpu and its "
         "--busy-poll)";
}

}  // namespace driveline::runtime
