#pragma once

#include <cstddef>
#include <deque>
#include <functional>
#include <span>
#include <vector>

#include "driveline/snapshot/feed/feed_records.hpp"
#include "driveline/snapshot/snapshot.hpp"

namespace driveline::runtime {

/// Combines the samples of the line and of its axes, which arrive through two rings, into one record per cycle, in the
/// order of the cycles. If a sample is missing because a ring was full, the record lacks it.
class CycleAssembler {
 public:
  /// Receives a complete record.
  using Sink = std::function<void(const snapshot::FeedLine& line, std::span<const snapshot::FeedAxisSample> axes)>;

  /// Most line samples that may wait for the samples of their axes; more than the rings hold.
  static constexpr std::size_t kMaxWaiting = 8192;

  /// For a line with this number of axes.
  CycleAssembler(std::size_t axes, Sink sink) : expected_(axes), sink_(std::move(sink)) { axes_.reserve(axes); }

  /// Adds the next sample of the line; it must come before the samples of its axes.
  void add(const snapshot::LineSample& sample);
  /// Adds the next sample of an axis.
  void add(const snapshot::AxisSample& sample);
  /// Call after the last sample.
  void finish();

 private:
  void emit_axes();
  void emit_lines_before(std::uint64_t cycle);

  std::size_t expected_;
  Sink sink_;
  std::deque<snapshot::FeedLine> lines_;
  std::uint64_t cycle_ = 0;  ///< cycle of the samples in `axes_`
  std::vector<snapshot::FeedAxisSample> axes_;
};

}  // namespace driveline::runtime
