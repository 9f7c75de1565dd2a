#pragma once

#include <atomic>
#include <chrono>
#include <cstdint>
#include <optional>

#include "driveline/canopen_master/acyclic_port.hpp"
#include "driveline/canopen_master/node_report.hpp"
#include "driveline/canopen_master/pdo_image.hpp"
#include "driveline/rt/counter.hpp"
#include "node_table.hpp"
#include "period_room.hpp"
#include "rpdo_outputs.hpp"
#include "tpdo_inputs.hpp"

namespace driveline::canopen {

/// The frames of a CanCycle: SYNC, process data, heartbeat of the master, and those of the owner.
class ProcessExchange {
 public:
  /// Frames that one cycle takes: those of four of the shortest periods at 1 Mbit/s. More wait for the next cycle.
  static constexpr std::uint32_t kMostFrames = 128;
  /// As many periods as the motion bridges: then the axes are being stopped, and drives need SYNC to tell so.
  static constexpr std::uint32_t kMostWithheld = 8;

  /// All but the plan must outlive this.
  ProcessExchange(CanPort& port, rt::Clock& clock, const MasterPlan& plan, PdoImage image, AcyclicChannel& acyclic);

  /// \name For the cycle, in this order: send_sync(), the end of the period before, begin_period(), send(), receive().
  /// \rtsafe
  /// @{

  /// To be called before send_sync() if periods were missed. SYNC would make the drives act on setpoints that have
  /// waited in them as long (CiA 301 7.2.2.2), so it is withheld until they have new ones, for kMostWithheld periods at
  /// most. The nodes have not got the outputs of the period before.
  void outdate() noexcept;
  /// Sends SYNC, unless it is withheld. Until begin_period() the period before goes on.
  void send_sync() noexcept;
  /// Receives what has arrived, up to the answers to a SYNC that has been sent for the next period. Returns whether
  /// all TPDOs that are due in this period are there.
  [[nodiscard]] bool receive() noexcept;
  /// Judges the nodes at the end of the period.
  [[nodiscard]] NodeTable::Verdict judge() noexcept;
  /// Begins the period of the last SYNC; `grid`: its instant.
  void begin_period(std::chrono::nanoseconds grid) noexcept;
  /// Sends the RPDOs, if `outputs`, and what else the bus has room for in this period.
  void send(bool outputs) noexcept;
  /// @}

  /// \name Facts of the present period, \rtsafe
  /// @{

  /// When its SYNC was sent; none: the port did not take it.
  [[nodiscard]] std::optional<std::chrono::nanoseconds> synced() const noexcept { return sync_; }
  /// Counters of its TPDOs.
  [[nodiscard]] const TpdoInputs::Tally& tally() const noexcept { return inputs_.tally(); }
  /// Bits of all frames sent and received in it.
  [[nodiscard]] std::uint64_t bits() const noexcept { return bits_ + tally().bits; }
  /// Frames with an identifier that only this master sends.
  [[nodiscard]] std::uint32_t foreign() const noexcept { return foreign_; }
  /// More frames waited than a cycle takes.
  [[nodiscard]] bool flooded() const noexcept { return flooded_; }
  /// Counters of the port as of the last receive().
  [[nodiscard]] const PortStatistics& port_statistics() const noexcept { return port_statistics_; }
  /// @}

  /// The nodes.
  [[nodiscard]] NodeTable& nodes() noexcept { return nodes_; }
  [[nodiscard]] const NodeTable& nodes() const noexcept { return nodes_; }
  /// The process data.
  [[nodiscard]] PdoImage& image() noexcept { return image_; }
  [[nodiscard]] const PdoImage& image() const noexcept { return image_; }
  /// Figures since the start, but CanCycleCounters::stale_frames. Any thread. \rtsafe
  [[nodiscard]] CanCycleCounters counters() const noexcept;

 private:
  void dispatch(const ReceivedFrame& received) noexcept;
  [[nodiscard]] PeriodRoom room() const noexcept;
  void send_heartbeat(PeriodRoom& room) noexcept;
  void send_acyclic(PeriodRoom& room) noexcept;

  /// SYNC sent for the next period.
  struct NextSync {
    std::optional<std::chrono::nanoseconds> at;
    std::uint32_t bits = 0;
  };
  struct Counters {
    rt::Counter syncs_unsent;
    rt::Counter rpdos_unsent;
    rt::Counter acyclic_unsent;
    rt::Counter foreign;
    rt::Counter stale;
    rt::Counter flooded;
  };
  struct Heartbeat {
    std::chrono::nanoseconds interval{0};
    std::chrono::nanoseconds due{0};
    Frame frame;
  };

  CanPort& port_;
  rt::Clock& clock_;
  AcyclicChannel& acyclic_;
  PdoImage image_;
  NodeTable nodes_;
  TpdoInputs inputs_;
  RpdoOutputs outputs_;
  Heartbeat heartbeat_;
  Frame sync_frame_;
  std::uint32_t sync_bits_;
  std::uint32_t bit_rate_;
  std::chrono::nanoseconds period_;
  std::chrono::nanoseconds grid_{0};
  NextSync next_;
  std::uint32_t withheld_ = 0;  ///< SYNCs since the last absence
  std::optional<std::chrono::nanoseconds> sync_;
  std::optional<ReceivedFrame> held_;  ///< belongs to the next period
  std::uint64_t bits_ = 0;
  std::uint32_t foreign_ = 0;
  bool flooded_ = false;
  PortStatistics port_statistics_;
  Counters counters_;
};

}  // namespace driveline::canopen
