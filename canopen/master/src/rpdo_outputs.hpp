#pragma once

#include <chrono>
#include <cstdint>
#include <optional>
#include <vector>

#include "driveline/canopen_master/pdo_image.hpp"
#include "driveline/canopen_port/can_port.hpp"
#include "driveline/canopen_wire/frame_meter.hpp"
#include "node_table.hpp"
#include "period_room.hpp"

namespace driveline::canopen {

/// Sends the RPDOs of the nodes in use from the image. \rtsafe but the constructor.
class RpdoOutputs {
 public:
  /// Both must outlive this. Adds the bits of RPDOs with SYNC to the nodes.
  RpdoOutputs(const PdoImage& image, NodeTable& nodes);

  /// Sends the RPDOs that are due in every period. An RPDO that the port does not take is not repeated. `synced`: SYNC
  /// was sent in this period, so that the nodes act on the RPDOs of the period before. Returns the bits sent.
  [[nodiscard]] std::uint32_t send_with_sync(CanPort& port, bool synced) noexcept;
  /// Sends the RPDOs on change that are due, as far as the period has room: all RPDOs of a node that has come into use,
  /// then changed RPDOs, then repetitions, the nodes in turn. An RPDO that is not sent stays due. A control word that
  /// has changed together with other RPDOs of its node follows them in the next period, because it may announce a new
  /// target, and a drive may apply all RPDOs of a period at once (CiA 402-2: bit 4 of 6040h). A changed control word by
  /// which a drive begins to act on setpoints waits until the node acts on the setpoints of the last period: they may
  /// be missing there, or wait for SYNC. A control word that stops a drive never waits. Repetitions share the interval
  /// evenly, so that the repetitions of many nodes do not load the same period. Returns the bits sent.
  [[nodiscard]] std::uint32_t send_on_change(CanPort& port, std::chrono::nanoseconds now, PeriodRoom& room) noexcept;
  /// To be called after an absence of the cycle, before the period before it is judged: the setpoints that wait in the
  /// nodes for SYNC are as old as the absence. The outputs of these nodes count as not sent.
  void outdate() noexcept;
  /// Whether outputs that are out of date still wait in a node in use.
  [[nodiscard]] bool outdated() noexcept;
  /// RPDOs with SYNC that the port did not take.
  [[nodiscard]] std::uint64_t unsent() const noexcept { return unsent_; }

 private:
  struct Rpdo {
    PdoPlace place;
    FrameMeter meter;
    Frame frame;                                ///< sent last
    std::uint64_t sent = 0;                     ///< on change: its content, as load_few() reads it
    std::chrono::nanoseconds phase{};           ///< on change: it is repeated at this time of each interval
    std::chrono::nanoseconds repeat_at{};       ///< on change
    bool forced = true;                         ///< on change: due whatever its content is
    bool outdated = false;                      ///< with SYNC: sent before an absence, and not again
    std::optional<std::size_t> control_word{};  ///< its first byte
  };
  /// The RPDOs on change of a node; those with a control word are the last ones.
  struct Group {
    std::vector<Rpdo> rpdos;
    bool waited = false;   ///< a control word has waited for a period
    bool supplied = true;  ///< every RPDO with SYNC of the node was sent in the last period
    bool current = true;   ///< SYNC has made the node act on them
  };
  /// Why an RPDO is due.
  enum class Reason : std::uint8_t { kChange, kRepetition };

  [[nodiscard]] std::span<const std::byte> content(const Rpdo& rpdo) const noexcept {
    return image_.outputs().subspan(rpdo.place.offset, rpdo.place.length);
  }
  void spread_repetitions();
  void force_begun() noexcept;
  [[nodiscard]] bool changed(const Rpdo& rpdo) const noexcept;
  [[nodiscard]] bool send_new(CanPort& port, Rpdo& rpdo, std::uint32_t& bits) const noexcept;
  /// What a pass over the RPDOs on change needs.
  struct Pass {
    CanPort& port;
    std::chrono::nanoseconds now;
    PeriodRoom& room;
    Reason reason;
    std::uint32_t bits = 0;
  };
  [[nodiscard]] bool due(const Rpdo& rpdo, const Group& group, const Pass& pass) const noexcept;
  [[nodiscard]] bool rests(const Group& group) const noexcept;
  [[nodiscard]] bool send_due(std::size_t node, Pass& pass) noexcept;
  [[nodiscard]] bool send_all_due(Pass& pass) noexcept;

  const PdoImage& image_;
  NodeTable& nodes_;
  std::vector<Rpdo> with_sync_;
  std::vector<Group> on_change_;  ///< by node
  bool outdated_ = false;         ///< some RPDO with SYNC may be out of date
  std::size_t turn_ = 0;          ///< node that is looked at first
  std::uint64_t unsent_ = 0;
  std::chrono::nanoseconds next_repetition_{};  ///< none of a node in use is due before
};

}  // namespace driveline::canopen
