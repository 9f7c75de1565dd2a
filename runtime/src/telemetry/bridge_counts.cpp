#include "telemetry/bridge_counts.hpp"

#include "driveline/rt/shared_words.hpp"

namespace driveline::runtime {

using snapshot::FeedReturn;

FeedReturn BridgeCounts::read() const noexcept {
  FeedReturn counts;
  rt::shared_detail::load_record<std::memory_order_acquire>(counts,
                                                            region_.words().data() + rt::shared_detail::kRecordsWord);
  return counts;
}

void BridgeCounts::write(const FeedReturn& record) const noexcept {
  rt::shared_detail::store_record<std::memory_order_release>(region_.words().data() + rt::shared_detail::kRecordsWord,
                                                             record);
}

/// Whether the counts are plausible: no count decreases or exceeds the records written since this bridge started.
bool BridgeCounts::can_be(const FeedReturn& counts, std::uint64_t written) const noexcept {
  const auto records = written - begun_at_;
  const auto samples = records * axes_;
  return counts.beats >= last_.beats && counts.next >= last_.next && counts.next <= written &&
         counts.published >= last_.published && counts.published <= samples && counts.lost >= last_.lost &&
         counts.lost <= records && counts.refused >= last_.refused && counts.refused <= samples;
}

bool BridgeCounts::update(std::uint64_t written) {
  const auto counts = read();
  if (!can_be(counts, written)) return false;
  last_ = counts;
  return true;
}

void BridgeCounts::begin(std::uint64_t written) {
  static_cast<void>(update(written));
  published_before_ += last_.published;
  dropped_before_ += dropped_by(last_);
  begun_at_ = last_.next;
  last_ = {};
  last_.next = begun_at_;
  write(last_);
}

void BridgeCounts::end(std::uint64_t written) noexcept {
  static_cast<void>(update(written));
  last_.lost += written - last_.next;
  last_.next = written;
}

}  // namespace driveline::runtime
