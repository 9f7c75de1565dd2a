#pragma once

#include <cstddef>
#include <cstdint>

namespace driveline::motion {

/// Position of a drive's process data in the images of outputs and inputs, and how often they are exchanged.
struct ImagePlace {
  std::size_t output_offset = 0;  ///< first byte of the drive's outputs
  std::size_t input_offset = 0;   ///< first byte of the drive's inputs
  std::uint32_t divider = 1;      ///< exchanged in every n-th cycle
};

}  // namespace driveline::motion
