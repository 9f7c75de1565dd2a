#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <tl/expected.hpp>
#include <utility>
#include <variant>
#include <vector>

#include "driveline/rt/shared_block.hpp"
#include "driveline/rt/shared_mapping.hpp"
#include "driveline/snapshot/feed/feed_error.hpp"
#include "driveline/snapshot/feed/feed_records.hpp"

/// The part of a feed that rarely changes: the slaves, their wiring, and the owners of the axes.
namespace driveline::snapshot {

/// Most slaves in a feed; further slaves are left out.
inline constexpr std::size_t kMaxFeedSlaves = 1024;
/// Ports of a slave controller.
inline constexpr std::size_t kFeedSlavePorts = 4;
/// Most silent ports (ports with a link behind which no slave answers) in a feed.
inline constexpr std::size_t kMaxFeedSilentPorts = 16;
/// FeedSlave::parent: the interface of the master.
inline constexpr std::int32_t kFeedParentMaster = -1;
/// FeedSlave::parent: unknown.
inline constexpr std::int32_t kFeedParentUnknown = -2;

/// A port of a slave: its link and its error counters, which stop at 255.
struct FeedSlavePort {
  std::uint8_t link = 0;                   ///< not 0: physical link (DL status 0110h)
  std::uint8_t open = 0;                   ///< not 0: the port is open, frames pass through it
  std::uint8_t invalid_frames = 0;         ///< invalid frames first detected at this port (0300h)
  std::uint8_t receive_errors = 0;         ///< symbols that the physical layer could not decode (0301h)
  std::uint8_t forwarded = 0;              ///< invalid frames already marked by a previous slave (0308h)
  std::uint8_t lost_links = 0;             ///< lost links (0310h)
  std::array<std::uint8_t, 2> reserved{};  ///< 0
};

/// A slave. Before it is on the line, only its name and position are valid.
struct FeedSlave {
  FeedText<31> name;                        ///< as configured
  FeedText<63> device;                      ///< device name from its EEPROM or its description
  FeedText<95> al_text;                     ///< text of the AL status code; empty: none
  std::uint32_t vendor_id = 0;              ///< vendor ID from the EEPROM
  std::uint32_t product_code = 0;           ///< product code from the EEPROM
  std::uint32_t revision = 0;               ///< revision from the EEPROM
  std::uint32_t serial_number = 0;          ///< serial number from the EEPROM; 0: none
  std::uint16_t station = 0;                ///< configured station address
  std::uint16_t alias = 0;                  ///< configured station alias; 0: none
  std::uint16_t al_status_code = 0;         ///< 0134h
  std::uint8_t al_state = 0;                ///< 0130h, bits 0 to 3
  std::uint8_t al_error = 0;                ///< not 0: error indication, 0130h bit 4
  std::uint8_t answers = 0;                 ///< 0: the slave does not answer; its register values are old
  std::uint8_t hot_connect = 0;             ///< not 0: the slave may be missing (hot connect)
  std::uint8_t processing_unit_errors = 0;  ///< 030Ch
  std::uint8_t pdi_errors = 0;              ///< 030Dh
  std::uint8_t clock = 0;        ///< 0: no clock in use; 1: follows the reference clock; 2: is the reference clock
  std::uint8_t entry_port = 0;   ///< port towards the master
  std::uint8_t parent_port = 0;  ///< port of the parent slave that leads to this slave
  std::uint8_t reserved = 0;     ///< 0
  std::int32_t parent =
      kFeedParentUnknown;                ///< previous slave towards the master, kFeedParentMaster or kFeedParentUnknown
  std::int32_t depth = 0;                ///< number of slaves between this slave and the master
  std::int64_t read_at_ns = 0;           ///< time at which its registers were read, since 1970-01-01 UTC
  std::int64_t clock_delay_ns = 0;       ///< propagation delay from the reference clock (0928h)
  std::int64_t clock_difference_ns = 0;  ///< largest absolute clock difference since operation started (092Ch)
  std::int64_t sync0_cycle_ns = 0;       ///< 0: no SYNC0
  std::array<FeedSlavePort, kFeedSlavePorts> port;  ///< by port number
};

/// Owner of an axis.
struct FeedOwner {
  FeedText<127> name;  ///< name as in the leases; empty: no owner
};

/// Facts about the line's wiring that belong to no single slave, and the counts of the following records.
struct FeedConditionHead {
  std::uint32_t slaves = 0;        ///< number of valid FeedSlave records
  std::uint32_t axes = 0;          ///< number of valid FeedOwner records
  std::uint32_t silent_ports = 0;  ///< number of valid `silent` entries
  std::int32_t ring_slave =
      kFeedParentUnknown;       ///< slave whose `ring_port` leads back to the master; kFeedParentUnknown: no ring
  std::uint32_t ring_port = 0;  ///< port of `ring_slave`
  std::uint32_t reserved = 0;   ///< 0
  std::array<std::uint32_t, kMaxFeedSilentPorts>
      silent{};  ///< slave * 4 + port: a port with a link behind which no slave answers
};

static_assert(sizeof(FeedSlave) % sizeof(std::uint64_t) == 0 &&
              sizeof(FeedConditionHead) % sizeof(std::uint64_t) == 0 && sizeof(FeedOwner) % sizeof(std::uint64_t) == 0);

/// Content number of the region.
inline constexpr std::uint32_t kFeedConditionContent = 0x4643'4F4E;
/// Number of records in the region: a reader that is overtaken while it copies a record takes the next one.
inline constexpr std::uint64_t kFeedConditions = 4;

/// Offset of the owner of axis 0 in the record of a line with `slaves` slaves, in bytes.
[[nodiscard]] constexpr std::size_t feed_owners_offset(std::size_t slaves) noexcept {
  return sizeof(FeedConditionHead) + slaves * sizeof(FeedSlave);
}

/// Layout of the region for a line with `slaves` slaves and `axes` axes.
[[nodiscard]] constexpr rt::SharedLayout feed_condition_layout(std::size_t slaves, std::size_t axes,
                                                               std::uint64_t capacity = 0) noexcept {
  return rt::shared_blocks(kFeedConditionContent, kFeedVersion,
                           static_cast<std::uint32_t>(feed_owners_offset(slaves) + axes * sizeof(FeedOwner)), capacity);
}

/// The complete condition of a line.
struct FeedCondition {
  FeedConditionHead head;         ///< `slaves` and `axes` are ignored when the condition is written
  std::vector<FeedSlave> slaves;  ///< by position
  std::vector<FeedOwner> owners;  ///< by axis
};

/// Writes the condition, in the process that holds the line. Belongs to one thread at a time.
class FeedConditionWriter {
 public:
  /// `region`: made with feed_condition_layout(slaves, axes); must outlive the writer.
  FeedConditionWriter(const rt::SharedMapping& region, std::size_t slaves, std::size_t axes)
      : writer_{region}, slaves_{slaves}, axes_{axes} {}

  /// Replaces the previous condition; slaves and axes beyond those of the layout are left out. \rtsafe
  void push(const FeedCondition& condition) noexcept {
    auto head = condition.head;
    head.slaves = static_cast<std::uint32_t>(std::min(condition.slaves.size(), slaves_));
    head.axes = static_cast<std::uint32_t>(std::min(condition.owners.size(), axes_));
    writer_.begin();
    writer_.write(0, head);
    for (std::size_t i = 0; i < head.slaves; ++i) {
      writer_.write(sizeof(FeedConditionHead) + i * sizeof(FeedSlave), condition.slaves[i]);
    }
    for (std::size_t i = 0; i < head.axes; ++i) {
      writer_.write(feed_owners_offset(slaves_) + i * sizeof(FeedOwner), condition.owners[i]);
    }
    writer_.commit();
  }

 private:
  rt::SharedBlockWriter writer_;
  std::size_t slaves_;
  std::size_t axes_;
};

/// Reads the condition. Belongs to one thread.
class FeedConditionReader {
 public:
  /// Maps the region behind `descriptor`, which remains the caller's, of a feed with `slaves` slaves and `axes` axes.
  /// Error: the region does not belong to such a feed.
  [[nodiscard]] static tl::expected<FeedConditionReader, FeedError> open(int descriptor, std::size_t slaves,
                                                                         std::size_t axes) {
    auto mapped = rt::SharedMapping::open(descriptor, feed_condition_layout(slaves, axes));
    if (const auto* error = std::get_if<rt::SharedRegionError>(&mapped)) {
      return tl::unexpected(FeedError{"condition", rt::describe(*error)});
    }
    return FeedConditionReader{std::move(*std::get_if<rt::SharedMapping>(&mapped)), slaves, axes};
  }

  /// Takes the newest condition; false: nothing new since the last call. Counts are limited to their ranges.
  [[nodiscard]] bool take(FeedCondition& condition) {
    bool any = false;
    while (reader_.take(record_)) any = true;
    if (!any) return false;
    condition.head = part<FeedConditionHead>(0);
    condition.head.slaves = std::min(condition.head.slaves, static_cast<std::uint32_t>(slaves_));
    condition.head.silent_ports =
        std::min(condition.head.silent_ports, static_cast<std::uint32_t>(kMaxFeedSilentPorts));
    condition.slaves.resize(condition.head.slaves);
    for (std::size_t i = 0; i < condition.slaves.size(); ++i) {
      condition.slaves[i] = part<FeedSlave>(sizeof(FeedConditionHead) + i * sizeof(FeedSlave));
    }
    condition.head.axes = std::min(condition.head.axes, static_cast<std::uint32_t>(axes_));
    condition.owners.resize(condition.head.axes);
    for (std::size_t i = 0; i < condition.owners.size(); ++i) {
      condition.owners[i] = part<FeedOwner>(feed_owners_offset(slaves_) + i * sizeof(FeedOwner));
    }
    return true;
  }

 private:
  FeedConditionReader(rt::SharedMapping region, std::size_t slaves, std::size_t axes)
      : region_{std::move(region)},
        slaves_{slaves},
        axes_{axes},
        reader_{region_, 0},
        record_(reader_.record_words()) {}

  template <rt::SharedRecord T>
  [[nodiscard]] T part(std::size_t offset) const noexcept {
    T value;
    std::memcpy(static_cast<void*>(&value), record_.data() + offset / sizeof(std::uint64_t), sizeof(value));
    return value;
  }

  rt::SharedMapping region_;
  std::size_t slaves_;
  std::size_t axes_;
  rt::SharedBlockReader reader_;
  std::vector<std::uint64_t> record_;
};

}  // namespace driveline::snapshot
