#pragma once

#include <algorithm>
#include <array>
#include <chrono>
#include <cstdint>
#include <limits>
#include <vector>

#include "driveline/canopen_master/pdo_image.hpp"
#include "driveline/canopen_port/can_port.hpp"
#include "driveline/canopen_wire/frame_meter.hpp"
#include "node_table.hpp"

namespace driveline::canopen {

/// Takes the TPDOs of a line into the image, and tells which of them answer the last SYNC. \rtsafe but the constructor.
class TpdoInputs {
 public:
  /// What a frame is to the process data: the place of a TPDO, or one of these.
  using Place = std::uint16_t;
  static constexpr Place kOther = 0xFFFF;  ///< none of them
  static constexpr Place kOwn = 0xFFFE;    ///< a frame that only this master sends: SYNC or an RPDO
  /// Counters of a period.
  struct Tally {
    std::uint32_t wrong_length = 0;    ///< TPDOs that were too short
    std::uint32_t stale = 0;           ///< TPDOs that answered an earlier SYNC
    std::uint32_t late = 0;            ///< those of them that were missing there
    std::uint64_t bits = 0;            ///< bits on the bus of the TPDOs taken
    std::chrono::nanoseconds last{0};  ///< when the last one came that was due; 0: none has
  };

  /// `image` is the one of `plan`. Counts the TPDOs of each node in `nodes`; all must outlive this.
  TpdoInputs(const MasterPlan& plan, PdoImage& image, NodeTable& nodes);

  /// What a frame is.
  [[nodiscard]] Place place_of(const Frame& frame) const noexcept;
  /// Whether the TPDO at this place is due after each SYNC, and can answer the SYNC sent at `sync`.
  [[nodiscard]] bool answers(Place place, const ReceivedFrame& received, std::chrono::nanoseconds sync) const noexcept {
    return tpdos_[place].due && received.time >= earliest_answer(received.frame, sync);
  }

  /// Begins the period of a SYNC that was sent at this time; none: it was not sent.
  void begin_period(std::optional<std::chrono::nanoseconds> sync) noexcept;
  /// Takes a frame of the TPDO at this place.
  void take(Place place, const ReceivedFrame& received) noexcept;
  /// Remembers what is missing, so that it counts as late when it comes. To be called when the period is judged.
  void end_period(bool synced) noexcept;
  /// Counters of this period.
  [[nodiscard]] const Tally& tally() const noexcept { return tally_; }
  /// Whether all TPDOs of the nodes in use have come that are due.
  [[nodiscard]] bool complete() const noexcept { return nodes_.totals().came == nodes_.totals().due; }

 private:
  struct Tpdo {
    std::uint64_t came_in = 0;  ///< period in which it came last
    std::uint32_t node = 0;
    std::uint32_t offset = 0;
    FrameMeter meter;
    std::uint16_t number = 0;
    std::uint8_t length = 0;
    bool due = false;                                                    ///< after each SYNC
    bool missing = false;                                                ///< it did not come in an earlier period
    std::uint32_t heard_in = std::numeric_limits<std::uint32_t>::max();  ///< NodeTable::Node::sojourn when it came last
  };

  [[nodiscard]] std::chrono::nanoseconds earliest_answer(const Frame& frame,
                                                         std::chrono::nanoseconds sync) const noexcept {
    return sync + least_answer_time_[std::min<std::size_t>(frame.length, Frame::kMaxLength)];
  }
  [[gnu::cold]] void note_stale(Tpdo& tpdo) noexcept;
  void note_heard(Tpdo& tpdo) noexcept;
  [[nodiscard, gnu::cold]] bool take_unplanned(Tpdo& tpdo, const Frame& frame) noexcept;

  PdoImage& image_;
  NodeTable& nodes_;
  /// From a SYNC to the end of the answer, at least, by its length.
  std::array<std::chrono::nanoseconds, Frame::kMaxLength + 1> least_answer_time_;
  std::vector<Tpdo> tpdos_;
  std::array<Place, Identifier::kBaseMask + 1> by_identifier_;
  std::optional<std::chrono::nanoseconds> sync_;  ///< time of the SYNC of this period
  std::uint64_t period_ = 0;                      ///< number of this period
  bool some_missing_ = false;                     ///< Tpdo::missing of some TPDO may be set
  Tally tally_;
};

}  // namespace driveline::canopen
