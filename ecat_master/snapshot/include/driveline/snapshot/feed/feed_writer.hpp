#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>
#include <tl/expected.hpp>
#include <utility>

#include "driveline/rt/shared_region.hpp"
#include "driveline/rt/shared_wake.hpp"
#include "driveline/snapshot/feed/feed_condition.hpp"
#include "driveline/snapshot/feed/feed_records.hpp"

namespace driveline::snapshot {

/// Writer of a feed, in the process that holds the line: creates the regions and writes them. Readers cannot affect it.
///
/// Belongs to one thread at a time.
class FeedWriter {
 public:
  /// Creates the regions of a feed that stores `cycles` cycles, rounded up to a power of two; `description` is
  /// complete. Error: there is no memory, or too many axes for a line. Not real-time safe.
  [[nodiscard]] static tl::expected<FeedWriter, rt::SharedRegionError> create(const FeedDescription& description,
                                                                              std::uint64_t cycles) {
    auto described = rt::SharedRegion::create("driveline-feed-description", feed_description_layout(1));
    if (!described) return tl::unexpected(described.error());
    auto status = rt::SharedRegion::create("driveline-feed-status", feed_status_layout(4));
    if (!status) return tl::unexpected(status.error());
    const std::size_t axes = std::min<std::size_t>(description.axes, kMaxFeedAxes);
    auto made = rt::SharedRegion::create("driveline-feed-cycles", feed_cycles_layout(axes, cycles));
    if (!made) return tl::unexpected(made.error());
    auto events = rt::SharedRegion::create("driveline-feed-events", feed_events_layout(kFeedEvents));
    if (!events) return tl::unexpected(events.error());
    auto condition = rt::SharedRegion::create("driveline-feed-condition",
                                              feed_condition_layout(description.slaves, axes, kFeedConditions));
    if (!condition) return tl::unexpected(condition.error());
    rt::SharedBroadcastWriter<FeedDescription>{*described}.push(description);
    FeedWriter writer{*std::move(described), *std::move(status),    *std::move(made),
                      *std::move(events),    *std::move(condition), axes,
                      description.slaves};
    writer.set_status({});
    return writer;
  }

  /// Publishes one cycle with one commit, whatever the number of axes. Samples beyond the axes of the line are left
  /// out. Sets `line.axes`. \rtsafe
  void push(FeedLine line, std::span<const FeedAxisSample> axes) noexcept {
    const std::size_t count = std::min(axes.size(), axes_);
    line.axes = static_cast<std::uint16_t>(count);
    writer_.begin();
    writer_.write(0, line);
    for (std::size_t i = 0; i < count; ++i) writer_.write(feed_axis_offset(i), axes[i]);
    writer_.commit();
  }

  /// Wakes readers that wait for cycles. A system call that does not wait for the readers.
  void wake() const noexcept { rt::wake_readers(cycles_); }

  /// Replaces the status. \rtsafe
  void set_status(const FeedStatus& status) noexcept { status_writer_.push(status); }

  /// Adds an event. \rtsafe
  void push_event(const FeedEvent& event) noexcept {
    event_writer_.begin();
    event_writer_.write(0, event);
    event_writer_.commit();
  }

  /// Replaces the condition of slaves and axis owners. \rtsafe
  void set_condition(const FeedCondition& condition) noexcept { condition_writer_.push(condition); }

  /// Number of cycles pushed so far. \rtsafe
  [[nodiscard]] std::uint64_t written() const noexcept { return writer_.written(); }
  /// Number of cycles that the feed stores. \rtsafe
  [[nodiscard]] std::uint64_t capacity() const noexcept { return writer_.capacity(); }
  /// Number of axes of the line. \rtsafe
  [[nodiscard]] std::size_t axes() const noexcept { return axes_; }

  /// \name Descriptors for readers, in the order in which FeedReader::open() takes them
  /// @{

  /// Descriptor of the FeedDescription.
  [[nodiscard]] int description_descriptor() const noexcept { return description_.descriptor(); }
  /// Descriptor of the FeedStatus.
  [[nodiscard]] int status_descriptor() const noexcept { return status_.descriptor(); }
  /// Descriptor of the cycles.
  [[nodiscard]] int cycles_descriptor() const noexcept { return cycles_.descriptor(); }
  /// Descriptor of the events.
  [[nodiscard]] int events_descriptor() const noexcept { return events_.descriptor(); }
  /// Descriptor of the condition, for FeedConditionReader.
  [[nodiscard]] int condition_descriptor() const noexcept { return condition_.descriptor(); }
  /// @}

 private:
  FeedWriter(rt::SharedRegion description, rt::SharedRegion status, rt::SharedRegion cycles, rt::SharedRegion events,
             rt::SharedRegion condition, std::size_t axes, std::size_t slaves)
      : description_{std::move(description)},
        status_{std::move(status)},
        cycles_{std::move(cycles)},
        events_{std::move(events)},
        condition_{std::move(condition)},
        status_writer_{status_},
        writer_{cycles_},
        event_writer_{events_},
        condition_writer_{condition_, slaves, axes},
        axes_{axes} {}

  rt::SharedRegion description_;
  rt::SharedRegion status_;
  rt::SharedRegion cycles_;
  rt::SharedRegion events_;
  rt::SharedRegion condition_;
  rt::SharedBroadcastWriter<FeedStatus> status_writer_;
  rt::SharedBlockWriter writer_;
  rt::SharedBlockWriter event_writer_;
  FeedConditionWriter condition_writer_;
  std::size_t axes_;
};

}  // namespace driveline::snapshot
