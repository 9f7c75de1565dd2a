#pragma once

#include <cstddef>
#include <cstdint>

#include "driveline/stream/records.hpp"

namespace driveline::runtime {

/// Interface of a StreamHub to the axes of the line. Belongs to the cycle: \rtsafe.
class StreamAxes {
 public:
  /// State of an axis for the hub.
  struct View {
    stream::MotionState state = stream::MotionState::kDisabled;
    std::uint32_t error = 0;  ///< error in ErrorStop
    double setpoint = 0.0;    ///< last setpoint, rad or m, as requests count
    double offset = 0.0;      ///< position in requests minus position of the drive, rad or m
  };

  virtual ~StreamAxes() = default;

  /// Returns the present state of the axis.
  [[nodiscard]] virtual View view(std::size_t axis) const noexcept = 0;
  /// Makes the axis follow its feed.
  virtual void follow(std::size_t axis) noexcept = 0;
  /// Brings the axis to rest.
  virtual void halt(std::size_t axis) noexcept = 0;
  /// Switches the axis on.
  virtual void power_on(std::size_t axis) noexcept = 0;

 protected:
  StreamAxes() = default;
  /// Copying is for implementations only.
  StreamAxes(const StreamAxes&) = default;
  StreamAxes& operator=(const StreamAxes&) = default;
};

}  // namespace driveline::runtime
