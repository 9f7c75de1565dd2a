#include "telemetry/bridge_counts.hpp"

#include "driveline/rt/shared_words.hpp"

namespace driveline::runtime {

using snapshot::FeedReturn;

FeedReturn BridgeCounts::read() const noexcept {
  FeedReturn told;
  rt::shared_detail::load_record<std::memory_order_acquire>(told,
                                                            region_.words().data() + rt::shared_detail::kRecordsWord);
  return told;
}

void BridgeCounts::write(const FeedReturn& record) const noexcept {
  rt::shared_detail::store_record<std::memory_order_release>(region_.words().data() + rt::shared_detail::kRecordsWord,
                                                             record);
}

/// Whether the counts are plausible: no count decreases or exceeds the records written since this bridge started.
bool BridgeCounts::can_be(const FeedReturn& told, std::uint64_t written) const noexcept {
  const auto records = written - begun_at_;
  const auto samples = records * axes_;
  return told.beats >= last_.beats && told.next >= last_.next && told.next <= written &&
         told.published >= last_.published && told.published <= samples && told.lost >= last_.lost &&
         told.lost <= records && told.refused >= last_.refused && told.refused <= samples;
}

bool BridgeCounts::look(std::uint64_t written) {
  const auto told = read();
  if (!can_be(told, written)) return false;
  last_ = told;
  return true;
}

void BridgeCounts::begin(std::uint64_t written) {
  static_cast<void>(look(written));
  published_before_ += last_.published;
  dropped_before_ += dropped_by(last_);
  begun_at_ = last_.next;
  last_ = {};
  last_.next = begun_at_;
  write(last_);
}

void BridgeCounts::end(std::uint64_t written) noexcept {
  static_cast<void>(look(written));
  last_.lost += written - last_.next;
  last_.next = written;
}

}  // namespace driveline::runtime
