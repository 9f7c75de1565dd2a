#pragma once

#include <cstdint>
#include <optional>

#include "driveline.h"
#include "driveline/bridge/dds_config.hpp"
#include "driveline/snapshot/snapshot.hpp"
#include "sample_filter.hpp"

namespace driveline::bridge {

/// Puts those samples of axes that are to be published together to batches of whole cycles. A batch begins at a cycle
/// whose number the number of cycles in a batch divides, so that batches are alike whatever comes late.
class AxisBatcher {
 public:
  explicit AxisBatcher(const DdsConfig& config);

  /// Adds a sample; samples come by cycle. Returns the batch before it when that ends with it, valid until the next
  /// call; null: none does.
  [[nodiscard]] telemetry::AxisBatch* add(const snapshot::AxisSample& sample);
  /// The batch as far as it is, and a new one begins; null: it is empty.
  [[nodiscard]] telemetry::AxisBatch* flush();
  /// By the clock of the machine, minus the master's clock; for the samples that follow.
  void set_wall_offset(std::int64_t offset_ns) noexcept { wall_offset_ns_ = offset_ns; }
  /// Cycles in a batch.
  [[nodiscard]] std::uint64_t cycles() const noexcept { return cycles_; }

 private:
  void append(const snapshot::AxisSample& sample);

  std::uint64_t cycles_;
  std::size_t axes_;
  SampleFilter filter_;
  std::int64_t wall_offset_ns_ = 0;
  std::optional<std::uint64_t> group_;  ///< of the batch that is being filled: cycle number by number of cycles
  telemetry::AxisBatch filling_;
  telemetry::AxisBatch done_;
};

}  // namespace driveline::bridge
