#pragma once

#include <cstddef>
#include <cstdint>

#include "driveline/stream/records.hpp"

namespace driveline::runtime {

/// What a StreamHub asks of the axes of the line. Belongs to the cycle: \rtsafe.
class StreamAxes {
 public:
  /// An axis as the hub sees it.
  struct View {
    stream::AxisState state = stream::AxisState::kDisabled;
    std::uint32_t error = 0;  ///< of ErrorStop
    double setpoint = 0.0;    ///< the last one, rad or m, as its requests count
    double offset = 0.0;      ///< by how much they count higher than the drive
  };

  virtual ~StreamAxes() = default;

  /// Of this moment.
  [[nodiscard]] virtual View view(std::size_t axis) const noexcept = 0;
  /// The axis is to follow its feed.
  virtual void follow(std::size_t axis) noexcept = 0;
  /// The axis is to come to rest.
  virtual void halt(std::size_t axis) noexcept = 0;
  /// The axis is to be switched on.
  virtual void power_on(std::size_t axis) noexcept = 0;

 protected:
  StreamAxes() = default;
  /// Copying is for implementations only.
  StreamAxes(const StreamAxes&) = default;
  StreamAxes& operator=(const StreamAxes&) = default;
};

}  // namespace driveline::runtime
