#pragma once

#include <cstdint>
#include <optional>

#include "driveline.h"
#include "driveline/bridge/dds_config.hpp"
#include "driveline/snapshot/snapshot.hpp"
#include "sample_filter.hpp"

namespace driveline::bridge {

/// Combines the selected axis samples into batches of whole cycles. A batch starts at a cycle number that is a multiple
/// of the number of cycles per batch, so that batches are aligned whatever arrives late.
class AxisBatcher {
 public:
  explicit AxisBatcher(const DdsConfig& config);

  /// Adds a sample; samples must arrive in order of cycles. Returns the batch that ends with or before this sample,
  /// valid until the next call; null if there is none.
  [[nodiscard]] telemetry::AxisBatch* add(const snapshot::AxisSample& sample);
  /// Returns the batch as far as it is filled, and starts a new one; null if it is empty.
  [[nodiscard]] telemetry::AxisBatch* flush();
  /// Sets the wall clock minus the master's clock, for the following samples.
  void set_wall_offset(std::int64_t offset_ns) noexcept { wall_offset_ns_ = offset_ns; }
  /// Number of cycles per batch.
  [[nodiscard]] std::uint64_t cycles() const noexcept { return cycles_; }

 private:
  void append(const snapshot::AxisSample& sample);

  std::uint64_t cycles_;
  std::size_t axes_;
  SampleFilter filter_;
  std::int64_t wall_offset_ns_ = 0;
  std::optional<std::uint64_t> group_;  ///< batch being filled: cycle number divided by cycles per batch
  telemetry::AxisBatch filling_;
  telemetry::AxisBatch done_;
};

}  // namespace driveline::bridge
