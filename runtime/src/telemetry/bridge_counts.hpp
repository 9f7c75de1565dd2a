#pragma once

#include <cstddef>
#include <cstdint>

#include "driveline/rt/shared_region.hpp"
#include "driveline/snapshot/feed/feed_records.hpp"

namespace driveline::runtime {

/// Region into which the bridge writes its counts, and their sums over all bridges of a run. The content is copied
/// once, checked for plausibility, and ignored if it is implausible, because the bridge reads data from a network.
class BridgeCounts {
 public:
  /// For a line with this number of axes. `region` must outlive it.
  BridgeCounts(const rt::SharedMapping& region, std::size_t axes) : region_(region), axes_(axes) {}

  /// Call before a bridge is started, after the previous one has ended: adds up its counts, and tells the new bridge
  /// where to continue. `written`: records in the feed.
  void begin(std::uint64_t written);
  /// Checks the counts. False: they are impossible.
  [[nodiscard]] bool update(std::uint64_t written);
  /// Call when the last bridge has ended: records that it has not taken are lost.
  void end(std::uint64_t written) noexcept;

  /// Return the counts of the bridges before the present one.
  [[nodiscard]] std::uint64_t published_before() const noexcept { return published_before_; }
  [[nodiscard]] std::uint64_t dropped_before() const noexcept { return dropped_before_; }
  /// Return the counts of all bridges.
  [[nodiscard]] std::uint64_t published() const noexcept { return published_before_ + last_.published; }
  [[nodiscard]] std::uint64_t dropped() const noexcept { return dropped_before_ + dropped_by(last_); }
  /// Returns the record that the bridge takes next, as far as its counts are plausible.
  [[nodiscard]] std::uint64_t next() const noexcept { return last_.next; }
  /// Returns the passes of the present or last bridge.
  [[nodiscard]] std::uint64_t beats() const noexcept { return last_.beats; }

 private:
  [[nodiscard]] snapshot::FeedReturn read() const noexcept;
  void write(const snapshot::FeedReturn& record) const noexcept;
  [[nodiscard]] bool can_be(const snapshot::FeedReturn& counts, std::uint64_t written) const noexcept;
  /// Returns the dropped samples: each record has one of the line and one per axis.
  [[nodiscard]] std::uint64_t dropped_by(const snapshot::FeedReturn& counts) const noexcept {
    return counts.lost * (axes_ + 1) + counts.refused;
  }

  const rt::SharedMapping& region_;
  std::size_t axes_;
  snapshot::FeedReturn last_;
  std::uint64_t begun_at_ = 0;  ///< first record of the present bridge
  std::uint64_t published_before_ = 0;
  std::uint64_t dropped_before_ = 0;
};

}  // namespace driveline::runtime
