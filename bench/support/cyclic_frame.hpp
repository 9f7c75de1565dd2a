#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "driveline/ecat_master/process_data/process_image.hpp"

namespace driveline::bench {

/// A frame of the cycle as the master sends it: the AL status of all slaves (BRD, in the first one) and process data.
struct CyclicFrame {
  /// A byte that a line in OP changes, and its new value.
  struct Change {
    std::size_t offset = 0;
    std::byte value{};
  };
  std::vector<std::byte> bytes;
  std::vector<Change> changes;  ///< AL status and working counters

  /// The first change that is missing in a returned frame; null: all are present.
  [[nodiscard]] const Change* missing_in(std::span<const std::byte> answer) const noexcept;
};

/// The frames of a cycle of `image`, for a line of at most 255 slaves that are all in OP.
[[nodiscard]] std::vector<CyclicFrame> cyclic_frames(const ecat_master::ProcessImage& image);

}  // namespace driveline::bench
