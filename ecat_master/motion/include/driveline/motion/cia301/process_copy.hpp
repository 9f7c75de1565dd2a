#pragma once

#include <cstddef>
#include <span>

namespace driveline::motion {

/// Process data that the master copies from one slave to another in every cycle.
struct ProcessDataCopy {
  std::size_t from_slave = 0;  ///< position of the source slave; copies only while its inputs are valid
  std::size_t from_bit = 0;    ///< bit offset in the image of inputs
  std::size_t to_bit = 0;      ///< bit offset in the image of outputs
  std::size_t bits = 0;        ///< number of bits
};

/// Executes the copies from slaves whose inputs are valid in this cycle; the outputs of other copies do not change.
/// Every copy must lie inside the image. \rtsafe
void apply_copies(std::span<const ProcessDataCopy> copies, std::span<const bool> valid,
                  std::span<const std::byte> inputs, std::span<std::byte> outputs) noexcept;

}  // namespace driveline::motion
