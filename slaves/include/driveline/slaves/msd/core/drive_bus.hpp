#pragma once

#include <cstdint>

#include "driveline/slaves/msd/core/faults.hpp"

namespace driveline::slaves::msd {

/// Communication state of the drive, numbered as in P 2060 (MSD manual Table 7.4).
enum class NetworkState : std::uint8_t {
  kBootUp = 0,            ///< no communication
  kInitialising = 1,      ///< communication starts
  kSafeOperational = 4,   ///< actual values are valid, setpoints are not yet; or stopped, where a bus has that
  kOperational = 5,       ///< actual values and setpoints are valid
  kPreOperational = 127,  ///< parameter access only
};

/// Interface from the drive to its bus: receives the drive's messages, and reports whether the cause of a bus fault
/// persists. Called on the thread that drives the drive; \rtsafe.
class DriveBus {
 public:
  virtual ~DriveBus() = default;
  /// Reports a fault that has occurred or was acknowledged.
  virtual void report(const FaultMessage& message) noexcept = 0;
  /// Whether the cause of a fault raised by the bus persists.
  [[nodiscard]] virtual bool cause_persists(Fault fault) const noexcept = 0;
  /// Called after a complete set of parameters was written: data derived from the dictionary are outdated. Not \rtsafe.
  virtual void parameters_replaced() = 0;
};

}  // namespace driveline::slaves::msd
