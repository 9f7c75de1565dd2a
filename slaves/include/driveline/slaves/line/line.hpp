#pragma once

#include <array>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "driveline/port/port.hpp"
#include "driveline/rt/clock.hpp"
#include "driveline/slaves/esc/slave.hpp"
#include "driveline/slaves/line/frame_datagrams.hpp"
#include "driveline/slaves/line/frame_path.hpp"
#include "driveline/slaves/line/line_end.hpp"
#include "driveline/slaves/line/line_faults.hpp"
#include "driveline/slaves/line/wiring.hpp"

namespace driveline::slaves {

/// Delays of a line.
struct LineOptions {
  SlaveDelays delays;                       ///< of every slave that slave_delays does not reach
  std::vector<SlaveDelays> slave_delays{};  ///< by position
  std::chrono::nanoseconds cable_delay{5};  ///< of every cable of the plain line (1 m)
  /// Serialisation of a byte of the frame; 80 ns at 100 Mbit/s. Not zero: frames wait for those sent before them.
  std::chrono::nanoseconds byte_time{0};
};

/// A line of emulated slaves, and the in-process port of a master that runs them: a frame that is sent passes all
/// slaves in the order of their wiring at once and can be received when its time on the wire has passed.
///
/// The same line serves a network interface: process() takes a frame that came in there, advance() runs the slaves
/// while none comes.
///
/// One thread at a time. After construction nothing allocates but mailbox traffic.
class Line final : public port::Port {
 public:
  /// Times are on the line's clock.
  using Nanoseconds = std::chrono::nanoseconds;

  /// `slaves` wired as `wiring` says, as a plain line without it. Throws std::invalid_argument when the wiring is for
  /// another number of slaves.
  Line(rt::Clock& clock, std::vector<std::unique_ptr<Slave>> slaves, const LineOptions& options = {},
       std::optional<Wiring> wiring = std::nullopt);
  Line(const Line&) = delete;
  Line& operator=(const Line&) = delete;

  /// \name The primary interface of the master
  /// @{
  [[nodiscard]] port::SendStatus send(std::span<const std::byte> frame) noexcept override { return end(0).send(frame); }
  [[nodiscard]] std::optional<port::ReceivedFrame> receive() noexcept override { return end(0).receive(); }
  bool wait_readable(Nanoseconds deadline) noexcept override { return end(0).wait_readable(deadline); }
  [[nodiscard]] Nanoseconds last_send_time() const noexcept override { return ends_[0]->last_send_time(); }
  /// @}
  /// The secondary interface of the master, at the far end of a ring.
  [[nodiscard]] port::Port& secondary() noexcept { return end(1); }

  /// Exit and delay of a frame.
  struct Passage {
    MasterPort exit;             ///< interface
    Nanoseconds delay;           ///< of slaves and cables
    Nanoseconds fault_delay{0};  ///< besides, by a fault
    bool duplicated = false;     ///< by a fault: the frame comes out twice
  };
  /// Lets a frame pass all slaves, in place, beginning at `now` (slaves are advanced to it). \rtsafe as Slave::advance.
  std::optional<Passage> process(std::span<std::byte> frame, Nanoseconds now, MasterPort from = MasterPort::kPrimary);
  /// The same without advancing the slaves, for a caller that does so itself. \rtsafe
  std::optional<Passage> pass(std::span<std::byte> frame, Nanoseconds now, MasterPort from = MasterPort::kPrimary);
  /// Runs the slaves up to `now` while no frames come.
  void advance(Nanoseconds now);
  /// Runs `count` slaves from `first` on up to `now`; all of them when a fault is due. For callers that have other work
  /// in between.
  void advance_some(std::size_t first, std::size_t count, Nanoseconds now);

  /// Slaves, powered or not. \rtsafe
  [[nodiscard]] std::size_t size() const noexcept { return slaves_.size(); }
  /// Precondition: position < size(). \rtsafe
  [[nodiscard]] Slave& slave(std::size_t position) noexcept { return *slaves_[position]; }
  /// The same, read only. \rtsafe
  [[nodiscard]] const Slave& slave(std::size_t position) const noexcept { return *slaves_[position]; }

  /// Counters of frames.
  struct Counters {
    std::uint64_t frames = 0;     ///< of any kind, from either interface
    std::uint64_t malformed = 0;  ///< EtherCAT frames with a broken datagram structure
    std::uint64_t foreign = 0;    ///< frames that are not EtherCAT
    std::uint64_t lost = 0;       ///< frames that did not come out again
  };
  /// Since construction. \rtsafe
  [[nodiscard]] const Counters& counters() const noexcept { return counters_; }

  /// \name Faults
  /// @{

  /// Faults, injected now or by a script.
  [[nodiscard]] LineFaults& faults() noexcept { return faults_; }
  /// Begins a fault now; false when it is not possible here. \rtsafe
  bool inject(const Fault& fault) noexcept { return faults_.begin(fault, clock_.now()); }
  /// Ends a fault now; false when it is not there. \rtsafe
  bool heal(const Fault& fault) noexcept { return faults_.heal(fault, clock_.now()); }
  /// Switches the supply of a slave. Without supply its neighbours see no link.
  void set_power(std::size_t position, bool on, Nanoseconds now) noexcept;
  /// The same, now.
  void set_power(std::size_t position, bool on) noexcept { set_power(position, on, clock_.now()); }
  /// Breaks or heals the cable at a port of a slave; false when there is none.
  bool break_cable(PortId port, bool broken = true) noexcept;
  /// The next `count` frames get lost before the first slave.
  void drop_frames(unsigned count) noexcept { inject({.kind = FaultKind::kDrop, .count = count}); }
  /// Cables as they are, the broken ones marked. \rtsafe
  [[nodiscard]] const Wiring& wiring() const noexcept { return wiring_; }
  /// @}

 private:
  friend class LineEnd;

  [[nodiscard]] LineEnd& end(std::size_t number) noexcept { return *ends_[number]; }
  port::SendStatus transmit(LineEnd& from, std::span<const std::byte> frame) noexcept;
  /// The way of a frame that starts now; opens auto-closed ports that it would come in at.
  const FramePath& current_path(MasterPort from) noexcept;
  std::optional<Passage> pass_along(std::span<std::byte> frame, const FramePath& way, Nanoseconds now) noexcept;
  /// False when the frame was destroyed.
  bool pass_slaves(const FramePath& way, const FrameFate& fate, Nanoseconds now) noexcept;
  bool pass_frame(std::span<std::byte> frame, const FramePath& way, const FrameFate& fate, Nanoseconds now) noexcept;
  void process_without_logical(Esc& esc, Nanoseconds time) noexcept;
  /// When the frame is damaged on its way; never without such a fault.
  [[nodiscard]] static Nanoseconds time_of_damage(const FramePath& way, const FrameFate& fate) noexcept;
  void count_damage(const FramePath& way, PortId damaged_at) noexcept;
  void advance_slaves(std::span<const std::unique_ptr<Slave>> slaves, Nanoseconds now);
  void latch_receive_times(const FramePath& way, Nanoseconds now) noexcept;
  [[nodiscard]] bool survives_as_foreign(const FramePath& way) const noexcept;
  [[nodiscard]] bool link_up(PortId port) const noexcept;
  void refresh_topology() noexcept;
  void refresh_ports(std::size_t position, bool loop_control_written) noexcept;

  rt::Clock& clock_;
  std::vector<std::unique_ptr<Slave>> slaves_;
  Wiring wiring_;
  LineOptions options_;
  std::array<std::unique_ptr<LineEnd>, kMasterPortCount> ends_;
  std::vector<SlavePorts> ports_;
  /// Ports that lost their link under auto-close: closed until DL control is written or a frame comes in.
  std::vector<std::array<bool, kPortCount>> auto_closed_;
  std::array<FramePath, kMasterPortCount> paths_;
  FrameDatagrams datagrams_;
  std::vector<std::byte> lost_frame_;  ///< a frame that will not come out is processed here
  bool topology_changed_ = true;
  std::uint64_t serial_ = 0;
  Counters counters_;
  LineFaults faults_;
};

}  // namespace driveline::slaves
