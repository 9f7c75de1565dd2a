#pragma once

#include <cstdint>

#include "driveline/slaves/msd/core/faults.hpp"

namespace driveline::slaves::msd {

/// How far the bus has brought the drive, as P 2060 counts it (MSD manual Table 7.4).
enum class NetworkState : std::uint8_t {
  kBootUp = 0,            ///< no communication
  kInitialising = 1,      ///< it begins
  kSafeOperational = 4,   ///< actual values are valid, setpoints not yet
  kOperational = 5,       ///< both are
  kPreOperational = 127,  ///< parameters alone
};

/// The bus as the drive sees it: takes its messages, and tells whether the cause of a bus fault persists. Called on the
/// thread that drives the drive; \rtsafe.
class DriveBus {
 public:
  virtual ~DriveBus() = default;
  /// A fault has come, or was acknowledged.
  virtual void report(const FaultMessage& message) noexcept = 0;
  /// The cause of a fault that the bus has raised is still there.
  [[nodiscard]] virtual bool cause_persists(Fault fault) const noexcept = 0;
  /// A whole set of parameters has been taken: what was derived from the dictionary is out of date. Not \rtsafe.
  virtual void parameters_replaced() = 0;
};

}  // namespace driveline::slaves::msd
