#pragma once

#include <cstddef>
#include <deque>
#include <functional>
#include <span>
#include <vector>

#include "driveline/snapshot/feed/feed_records.hpp"
#include "driveline/snapshot/snapshot.hpp"

namespace driveline::runtime {

/// Puts the samples of the line and of its axes, which come through two rings, together to one record for each cycle,
/// in the order of the cycles. A cycle that lacks a sample, because a ring was full, is a record that lacks it.
class CycleAssembler {
 public:
  /// Takes a whole record.
  using Sink = std::function<void(const snapshot::FeedLine& line, std::span<const snapshot::FeedAxisSample> axes)>;

  /// Line samples that may wait for the samples of their axes; more than the rings hold.
  static constexpr std::size_t kMostWaiting = 8192;

  /// Of a line with so many axes.
  CycleAssembler(std::size_t axes, Sink sink) : expected_(axes), sink_(std::move(sink)) { axes_.reserve(axes); }

  /// The next samples of the line, which come before those of its axes.
  void add(const snapshot::LineSample& sample);
  /// The next sample of an axis.
  void add(const snapshot::AxisSample& sample);
  /// Nothing follows.
  void finish();

 private:
  void emit_axes();
  void emit_lines_before(std::uint64_t cycle);

  std::size_t expected_;
  Sink sink_;
  std::deque<snapshot::FeedLine> lines_;
  std::uint64_t cycle_ = 0;  ///< of the samples in `axes_`
  std::vector<snapshot::FeedAxisSample> axes_;
};

}  // namespace driveline::runtime
