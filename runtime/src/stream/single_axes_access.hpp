#pragma once

#include <cstddef>

#include "driveline/motion/single_axis/single_axes.hpp"
#include "stream/stream_axes.hpp"

namespace driveline::runtime {

/// Gives a StreamHub access to the axes of a line that are commanded by requests.
class SingleAxesAccess final : public StreamAxes {
 public:
  /// `axes` must outlive it.
  explicit SingleAxesAccess(motion::SingleAxes& axes) noexcept : axes_(axes) {}

  [[nodiscard]] View view(std::size_t axis) const noexcept override;
  void follow(std::size_t axis) noexcept override;
  void halt(std::size_t axis) noexcept override;
  void power_on(std::size_t axis) noexcept override;

 private:
  motion::SingleAxes& axes_;
};

}  // namespace driveline::runtime
