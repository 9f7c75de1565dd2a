// Faults of the drive: raising and acknowledging.
#include <algorithm>

#include "driveline/slaves/msd/core/drive_core.hpp"
#include "driveline/slaves/msd/core/drive_values.hpp"
#include "driveline/slaves/msd/core/object_checks.hpp"

namespace driveline::slaves::msd {

/// The first fault remains active until it is acknowledged; a later fault can only make the reaction harder.
void DriveCore::raise(Fault fault) noexcept {
  disturb();
  const FaultFacts& f = facts(fault);
  if (faults_.standing()) {
    if (f.coast) control_.profile().fault(true);
    return;
  }
  const auto hours = std::clamp<std::int64_t>(operating_hours_.count() + running_time() / std::chrono::hours(1), 0,
                                              kMaxOperatingHours);
  bus_->report(faults_.enter(fault, static_cast<std::uint32_t>(hours)));
  control_.profile().fault(f.coast);
}

/// Acknowledges a fault; a cause that persists raises it again at once (MSD manual 13.3).
void DriveCore::acknowledge() noexcept {
  if (!control_.profile().acknowledge()) return;
  const auto was = faults_.standing();
  bus_->report(faults_.acknowledge());
  if (was && cause_persists(*was)) raise(*was);
}

void DriveCore::watch_fault_reset() noexcept {
  if (control_.profile().takes_fault_reset()) acknowledge();
}

/// Whether the cause of the fault persists when it is acknowledged.
bool DriveCore::cause_persists(Fault fault) const noexcept {
  if (causes_.test(static_cast<std::size_t>(fault))) return true;
  switch (fault) {
    case Fault::kInvalidConfiguration:
      return monitor_.wrong_cycle() || bus_->cause_persists(fault);
    case Fault::kEepromData:
    case Fault::kBusOff:
    case Fault::kLifeGuarding:
    case Fault::kHeartbeat:
    case Fault::kTelegramFailure:
    case Fault::kCommunicationEnded:
      return bus_->cause_persists(fault);
    case Fault::kParameterList:
      return !parameters_consistent(dictionary_) || !store_.good();
    default:
      return protection_.cause_persists(fault);
  }
}

/// Monitors in each process data cycle: currents, following error, limit switches, setpoints.
void DriveCore::monitor() noexcept {
  if (protection_.overcurrent()) raise(Fault::kOvercurrent);
  if (monitor_.step_following_error()) raise(Fault::kFollowingError);
  if (const auto hit = monitor_.limit_switch(terminals_.signals(), control_.profile().homes())) raise(*hit);
  if (clock_.millisecond() && monitor_.follows_wrong_cycle()) raise(Fault::kInvalidConfiguration);
}

/// Monitors once per millisecond: temperatures, I2t, voltages, external causes.
void DriveCore::monitor_protection() noexcept {
  protection_.step();
  if (!protection_.dc_link_present()) disturb();
  if (causes_.none() && !protection_.finds_fault()) return;
  for (const Fault fault : Protection::kFound) {
    if (!faults_.standing() && cause_persists(fault)) raise(fault);
  }
  for (std::size_t i = 0; i < causes_.size(); ++i) {
    const auto fault = static_cast<Fault>(i);
    if (causes_.test(i) && (!faults_.standing() || facts(fault).coast)) raise(fault);
  }
}

}  // namespace driveline::slaves::msd
