#pragma once

#include <array>
#include <chrono>
#include <cstdint>
#include <limits>
#include <vector>

#include "driveline/canopen_master/pdo_image.hpp"
#include "driveline/canopen_port/can_port.hpp"
#include "frame_meter.hpp"
#include "node_table.hpp"

namespace driveline::canopen {

/// Takes the TPDOs of a line into the image, and tells which of them answer the last SYNC. \rtsafe but the constructor.
class TpdoInputs {
 public:
  /// What a frame is to the process data.
  enum class Kind : std::uint8_t {
    kTpdo,   ///< a TPDO of the line
    kOwn,    ///< a frame that only this master sends: SYNC or an RPDO
    kOther,  ///< none of them
  };
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
  [[nodiscard]] Kind kind_of(const Frame& frame) const noexcept;
  /// When the earliest frame with these inputs can have come that answers a SYNC sent at `sync`.
  [[nodiscard]] std::chrono::nanoseconds earliest_answer(const Frame& frame,
                                                         std::chrono::nanoseconds sync) const noexcept;
  /// Whether the frame is a TPDO that is due after each SYNC. Precondition: its kind is kTpdo.
  [[nodiscard]] bool answers_each_sync(const Frame& frame) const noexcept;

  /// Begins the period of a SYNC that was sent at this time; none: it was not sent.
  void begin_period(std::optional<std::chrono::nanoseconds> sync) noexcept;
  /// Takes a frame of kind kTpdo.
  void take(const ReceivedFrame& received) noexcept;
  /// Remembers what is missing, so that it counts as late when it comes. To be called when the period is judged.
  void end_period(bool synced) noexcept;
  /// Counters of this period.
  [[nodiscard]] const Tally& tally() const noexcept { return tally_; }
  /// Whether all TPDOs of the nodes in use have come that are due.
  [[nodiscard]] bool complete() const noexcept;

 private:
  struct Tpdo {
    std::size_t node = 0;
    std::size_t offset = 0;
    FrameMeter meter;
    std::uint8_t length = 0;
    bool due = false;                                                    ///< after each SYNC
    bool came = false;                                                   ///< in this period
    bool missing = false;                                                ///< it did not come in an earlier period
    std::uint32_t heard_in = std::numeric_limits<std::uint32_t>::max();  ///< NodeTable::Node::sojourn when it came last
  };
  static constexpr std::uint16_t kNone = 0xFFFF;
  static constexpr std::uint16_t kOwnFrame = 0xFFFE;

  void note_stale(Tpdo& tpdo) noexcept;
  void note_heard(Tpdo& tpdo) noexcept;

  PdoImage& image_;
  NodeTable& nodes_;
  std::uint32_t bit_rate_;
  std::vector<Tpdo> tpdos_;
  std::array<std::uint16_t, Identifier::kBaseMask + 1> by_identifier_;  ///< place in tpdos_, kNone or kOwnFrame
  std::optional<std::chrono::nanoseconds> sync_;                        ///< time of the SYNC of this period
  Tally tally_;
};

}  // namespace driveline::canopen
