#pragma once

#include "driveline/slaves/canopen/entry.hpp"
#include "driveline/slaves/msd/can/can_table.hpp"

namespace driveline::slaves::msd {

/// What the drive does when an RxPDO has been applied, from the settings of both PDOs with its number. \rtsafe
/// throughout.
class RpdoUses {
 public:
  /// The dictionary must outlive this.
  explicit RpdoUses(ObjectDictionary& dictionary) noexcept;

  /// Reads the mappings again.
  void update() noexcept;
  /// Whether it contains the setpoint of the interpolated position mode, 60C1h:01. Precondition: number < kCanPdos.
  [[nodiscard]] bool carries_setpoint(std::size_t number) const noexcept { return setpoint_[number]; }
  /// Whether a TxPDO is sent after it: both PDOs have type FEh or FFh (MSD manual 8.3.1). The same precondition.
  [[nodiscard]] bool is_answered(std::size_t number) const noexcept;

 private:
  ObjectDictionary* dictionary_;
  std::array<cia301::Entry, kCanPdos> rx_types_;
  std::array<cia301::Entry, kCanPdos> tx_types_;
  std::array<bool, kCanPdos> setpoint_{};
};

}  // namespace driveline::slaves::msd
