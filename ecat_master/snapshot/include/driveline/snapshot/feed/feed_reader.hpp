#pragma once

#include <algorithm>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <tl/expected.hpp>
#include <utility>
#include <variant>
#include <vector>

#include "driveline/rt/shared_mapping.hpp"
#include "driveline/rt/shared_wake.hpp"
#include "driveline/snapshot/feed/feed_condition.hpp"
#include "driveline/snapshot/feed/feed_error.hpp"
#include "driveline/snapshot/feed/feed_records.hpp"

namespace driveline::snapshot {

/// Reader of a feed. It maps the feed read-only, copies every record before it uses it, and tolerates any content:
/// numbers are limited to their ranges.
///
/// Belongs to one thread.
class FeedReader {
 public:
  /// Maps a feed: its description, status, cycles and events, whose descriptors remain the caller's. Starts with record
  /// number `from` of the cycles, or with the oldest record left; without `from`, with the next record. Errors: a
  /// region does not belong to a feed of this version, or contains no description.
  [[nodiscard]] static tl::expected<FeedReader, FeedError> open(int description, int status, int cycles, int events,
                                                                std::optional<std::uint64_t> from = std::nullopt) {
    const auto described = map("description", description, feed_description_layout());
    if (!described) return tl::unexpected(described.error());
    auto text = std::make_unique<FeedDescription>();
    if (!rt::SharedBroadcastReader<FeedDescription>{*described}.latest(*text)) {
      return tl::unexpected(FeedError{"description", "there is none"});
    }
    if (text->axes > kMaxFeedAxes || text->interfaces > kMaxFeedInterfaces || text->decimation == 0 ||
        text->slaves > kMaxFeedSlaves || text->peers > kMaxFeedPeers || text->discovery_port > 0xFFFF) {
      return tl::unexpected(
          FeedError{"description", "too many axes, slaves, interfaces, peers or ports, or a decimation of 0"});
    }
    auto state = map("status", status, feed_status_layout());
    if (!state) return tl::unexpected(state.error());
    auto records = map("cycles", cycles, feed_cycles_layout(text->axes));
    if (!records) return tl::unexpected(records.error());
    auto happened = map("events", events, feed_events_layout());
    if (!happened) return tl::unexpected(happened.error());
    return FeedReader{std::move(text), *std::move(state), *std::move(records), *std::move(happened), from};
  }

  /// The constant description; its counts of axes and interfaces are valid.
  [[nodiscard]] const FeedDescription& description() const noexcept { return *description_; }

  /// Takes the next cycle: its samples, valid until the next call. False: there is none.
  [[nodiscard]] bool take() noexcept {
    if (!cycles_.take(record_)) return false;
    const auto line = part<FeedLine>(0);
    axes_.clear();
    const std::size_t count = std::min<std::size_t>(line.axes, description_->axes);
    for (std::size_t i = 0; i < count; ++i) {
      axes_.push_back(from_feed(part<FeedAxisSample>(feed_axis_offset(i)), line.cycle));
    }
    has_line_ = line.present != 0;
    line_ = from_feed(line, static_cast<std::uint16_t>(count));
    return true;
  }
  /// Sleeps until FeedWriter::wake(), a signal, or the end of `limit`; returns at once while there are cycles to take.
  /// A system call.
  void wait(std::chrono::nanoseconds limit) const noexcept { rt::wait_for_records(cycles_region_, next(), limit); }

  /// The line sample of the taken cycle; null: it was lost.
  [[nodiscard]] const LineSample* line() const noexcept { return has_line_ ? &line_ : nullptr; }
  /// The axis samples of the taken cycle.
  [[nodiscard]] std::span<const AxisSample> axes() const noexcept { return axes_; }

  /// Takes the next event, starting with the oldest in the feed. False: there is none.
  [[nodiscard]] bool take_event(FeedEvent& event, std::uint64_t& number) noexcept {
    if (!events_.take(record_)) return false;
    event = part<FeedEvent>(0);
    number = events_.next() - 1;
    return true;
  }

  /// Copies the newest status. False: the writer overtook the copy; try again later.
  [[nodiscard]] bool status(FeedStatus& status) const noexcept {
    if (!status_reader_.latest(status)) return false;
    status.faults = static_cast<std::uint16_t>(std::min<std::size_t>(status.faults, kMaxFeedFaults));
    return true;
  }

  /// Cycles that were overwritten before this reader took them.
  [[nodiscard]] std::uint64_t lost() const noexcept { return cycles_.lost(); }
  /// Number of the next cycle record to take.
  [[nodiscard]] std::uint64_t next() const noexcept { return cycles_.next(); }

 private:
  static tl::expected<rt::SharedMapping, FeedError> map(const char* name, int descriptor,
                                                        const rt::SharedLayout& layout) {
    auto mapped = rt::SharedMapping::open(descriptor, layout);
    if (const auto* error = std::get_if<rt::SharedRegionError>(&mapped)) {
      return tl::unexpected(FeedError{name, rt::describe(*error)});
    }
    return std::move(*std::get_if<rt::SharedMapping>(&mapped));
  }

  /// The value at `offset` bytes in the copied record.
  template <rt::SharedRecord T>
  [[nodiscard]] T part(std::size_t offset) const noexcept {
    T value;
    std::memcpy(static_cast<void*>(&value), record_.data() + offset / sizeof(std::uint64_t), sizeof(value));
    return value;
  }

  FeedReader(std::unique_ptr<FeedDescription> description, rt::SharedMapping status, rt::SharedMapping cycles,
             rt::SharedMapping events, std::optional<std::uint64_t> from)
      : description_{std::move(description)},
        status_region_{std::move(status)},
        cycles_region_{std::move(cycles)},
        events_region_{std::move(events)},
        status_reader_{status_region_},
        cycles_{cycles_region_, from},
        events_{events_region_, 0},
        record_(std::max(cycles_.record_words(), events_.record_words())) {
    axes_.reserve(description_->axes);
  }

  std::unique_ptr<FeedDescription> description_;  // on the heap: too large for the stack
  rt::SharedMapping status_region_;
  rt::SharedMapping cycles_region_;
  rt::SharedMapping events_region_;
  rt::SharedBroadcastReader<FeedStatus> status_reader_;
  rt::SharedBlockReader cycles_;
  rt::SharedBlockReader events_;
  std::vector<std::uint64_t> record_;
  LineSample line_;
  bool has_line_ = false;
  std::vector<AxisSample> axes_;
};

/// Writer of the record that the bridge sends back.
class FeedReturnWriter {
 public:
  /// Maps the region behind `descriptor`, which remains the caller's.
  [[nodiscard]] static tl::expected<FeedReturnWriter, FeedError> open(int descriptor) {
    auto mapped = rt::SharedMapping::open(descriptor, feed_return_layout());
    if (const auto* error = std::get_if<rt::SharedRegionError>(&mapped)) {
      return tl::unexpected(FeedError{"return", rt::describe(*error)});
    }
    return FeedReturnWriter{std::move(*std::get_if<rt::SharedMapping>(&mapped))};
  }

  /// Replaces the previous record.
  void tell(const FeedReturn& record) noexcept {
    rt::shared_detail::store_record<std::memory_order_release>(region_.words().data() + rt::shared_detail::kRecordsWord,
                                                               record);
  }
  /// The current content of the region: initially the last record of the previous bridge.
  [[nodiscard]] FeedReturn last_record() const noexcept {
    FeedReturn record;
    rt::shared_detail::load_record<std::memory_order_acquire>(record,
                                                              region_.words().data() + rt::shared_detail::kRecordsWord);
    return record;
  }

 private:
  explicit FeedReturnWriter(rt::SharedMapping region) : region_{std::move(region)} {}

  rt::SharedMapping region_;
};

}  // namespace driveline::snapshot
