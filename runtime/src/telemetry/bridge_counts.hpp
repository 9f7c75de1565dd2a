#pragma once

#include <cstddef>
#include <cstdint>

#include "driveline/rt/shared_region.hpp"
#include "driveline/snapshot/feed/feed_records.hpp"

namespace driveline::runtime {

/// The region into which the bridge writes its counts, and their sums over all bridges of a run. Whatever stands there
/// is copied once, compared with what can be, and otherwise left out: the bridge reads what a network sends.
class BridgeCounts {
 public:
  /// Of a line with so many axes. `region` must outlive it.
  BridgeCounts(const rt::SharedMapping& region, std::size_t axes) : region_(region), axes_(axes) {}

  /// Before a bridge is started, when the one before has ended: adds its counts up, and tells the new one where to go
  /// on. `written`: records in the feed.
  void begin(std::uint64_t written);
  /// Looks at the counts. False: they cannot be.
  [[nodiscard]] bool look(std::uint64_t written);
  /// The bridge has ended for good: what it has not taken is lost.
  void end(std::uint64_t written) noexcept;

  /// By bridges before the one that runs.
  [[nodiscard]] std::uint64_t published_before() const noexcept { return published_before_; }
  [[nodiscard]] std::uint64_t dropped_before() const noexcept { return dropped_before_; }
  /// By all of them.
  [[nodiscard]] std::uint64_t published() const noexcept { return published_before_ + last_.published; }
  [[nodiscard]] std::uint64_t dropped() const noexcept { return dropped_before_ + dropped_by(last_); }
  /// Record that the bridge takes next, as far as it is believed.
  [[nodiscard]] std::uint64_t next() const noexcept { return last_.next; }
  /// Passes of the bridge that runs, or has run last.
  [[nodiscard]] std::uint64_t beats() const noexcept { return last_.beats; }

 private:
  [[nodiscard]] snapshot::FeedReturn read() const noexcept;
  void write(const snapshot::FeedReturn& record) const noexcept;
  [[nodiscard]] bool can_be(const snapshot::FeedReturn& told, std::uint64_t written) const noexcept;
  /// Samples: the line's and those of its axes in each record.
  [[nodiscard]] std::uint64_t dropped_by(const snapshot::FeedReturn& told) const noexcept {
    return told.lost * (axes_ + 1) + told.refused;
  }

  const rt::SharedMapping& region_;
  std::size_t axes_;
  snapshot::FeedReturn last_;
  std::uint64_t begun_at_ = 0;  ///< record with which the bridge that runs began
  std::uint64_t published_before_ = 0;
  std::uint64_t dropped_before_ = 0;
};

}  // namespace driveline::runtime
