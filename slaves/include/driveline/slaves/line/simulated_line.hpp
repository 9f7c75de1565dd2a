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
  SlaveDelays delays;                       ///< delays of slaves without an element in slave_delays
  std::vector<SlaveDelays> slave_delays{};  ///< by position
  std::chrono::nanoseconds cable_delay{5};  ///< delay of each cable of the plain line (1 m)
  /// Serialisation time of a byte; 80 ns at 100 Mbit/s. If it is not zero, frames wait for previously sent frames.
  std::chrono::nanoseconds byte_time{0};
};

/// A line of emulated slaves, and the in-process port of a master that runs them: a sent frame passes all slaves at
/// once in the order of their wiring, and can be received when its time on the wire has passed.
///
/// The line can also serve a network interface: process() handles a received frame, advance() runs the slaves while no
/// frames arrive.
///
/// For one thread at a time. After construction only mailbox traffic allocates.
class SimulatedLine final : public port::Port {
 public:
  /// Times are on the line's clock.
  using Nanoseconds = std::chrono::nanoseconds;

  /// Creates the line with `slaves`, connected by `wiring`, or as a plain line without it. Throws std::invalid_argument
  /// when the wiring has a different number of slaves.
  SimulatedLine(rt::Clock& clock, std::vector<std::unique_ptr<Slave>> slaves, const LineOptions& options = {},
                std::optional<Wiring> wiring = std::nullopt);
  SimulatedLine(const SimulatedLine&) = delete;
  SimulatedLine& operator=(const SimulatedLine&) = delete;

  /// \name The primary interface of the master
  /// @{
  [[nodiscard]] port::SendStatus send(std::span<const std::byte> frame) noexcept override { return end(0).send(frame); }
  [[nodiscard]] std::optional<port::ReceivedFrame> receive() noexcept override { return end(0).receive(); }
  bool wait_readable(Nanoseconds deadline) noexcept override { return end(0).wait_readable(deadline); }
  [[nodiscard]] Nanoseconds last_send_time() const noexcept override { return ends_[0]->last_send_time(); }
  /// @}
  /// Returns the secondary interface of the master, at the other end of a ring.
  [[nodiscard]] port::Port& secondary() noexcept { return end(1); }

  /// Exit and delay of a frame.
  struct Passage {
    MasterPort exit;             ///< interface where the frame leaves
    Nanoseconds delay;           ///< delay of slaves and cables
    Nanoseconds fault_delay{0};  ///< additional delay by a fault
    bool duplicated = false;     ///< by a fault: the frame leaves twice
  };
  /// Passes a frame through all slaves, in place; advances them to `now`. \rtsafe if Slave::advance is.
  std::optional<Passage> process(std::span<std::byte> frame, Nanoseconds now, MasterPort from = MasterPort::kPrimary);
  /// Passes a frame through all slaves like process(), but the caller advances the slaves. \rtsafe
  std::optional<Passage> pass(std::span<std::byte> frame, Nanoseconds now, MasterPort from = MasterPort::kPrimary);
  /// Runs the slaves up to `now` while no frames arrive.
  void advance(Nanoseconds now);
  /// Runs `count` slaves from `first` on up to `now`, all when a fault is due. For callers with other work in between.
  void advance_some(std::size_t first, std::size_t count, Nanoseconds now);

  /// Returns the number of slaves, powered or not. \rtsafe
  [[nodiscard]] std::size_t size() const noexcept { return slaves_.size(); }
  /// Returns a slave. Precondition: position < size(). \rtsafe
  [[nodiscard]] Slave& slave(std::size_t position) noexcept { return *slaves_[position]; }
  /// Returns a slave, read only. Precondition: position < size(). \rtsafe
  [[nodiscard]] const Slave& slave(std::size_t position) const noexcept { return *slaves_[position]; }

  /// Counters of frames.
  struct Counters {
    std::uint64_t frames = 0;     ///< frames of any kind, from both interfaces
    std::uint64_t malformed = 0;  ///< EtherCAT frames with a broken datagram structure
    std::uint64_t foreign = 0;    ///< frames that are not EtherCAT
    std::uint64_t lost = 0;       ///< frames that did not leave the line
  };
  /// Returns the counts since construction. \rtsafe
  [[nodiscard]] const Counters& counters() const noexcept { return counters_; }

  /// \name Faults
  /// @{

  /// Returns the faults, which are injected directly or by a script.
  [[nodiscard]] LineFaults& faults() noexcept { return faults_; }
  /// Starts a fault now; returns false when it is not possible here. \rtsafe
  bool inject(const Fault& fault) noexcept { return faults_.begin(fault, clock_.now()); }
  /// Ends a fault now; returns false when it is not active. \rtsafe
  bool heal(const Fault& fault) noexcept { return faults_.heal(fault, clock_.now()); }
  /// Switches the power supply of a slave. The neighbours of a slave without supply detect no link.
  void set_power(std::size_t position, bool on, Nanoseconds now) noexcept;
  /// Switches the power supply of a slave now.
  void set_power(std::size_t position, bool on) noexcept { set_power(position, on, clock_.now()); }
  /// Breaks or heals the cable at a port of a slave; returns false when there is none.
  bool break_cable(PortId port, bool broken = true) noexcept;
  /// Drops the next `count` frames before the first slave.
  void drop_frames(unsigned count) noexcept { inject({.kind = FaultKind::kDrop, .count = count}); }
  /// Returns the wiring with the state of its cables. \rtsafe
  [[nodiscard]] const Wiring& wiring() const noexcept { return wiring_; }
  /// @}

 private:
  friend class LineEnd;

  [[nodiscard]] LineEnd& end(std::size_t number) noexcept { return *ends_[number]; }
  port::SendStatus transmit(LineEnd& from, std::span<const std::byte> frame) noexcept;
  /// Returns the path of a frame that starts now; opens auto-closed ports that would receive it.
  const FramePath& current_path(MasterPort from) noexcept;
  std::optional<Passage> pass_along(std::span<std::byte> frame, const FramePath& path, Nanoseconds now) noexcept;
  /// Returns false when the frame was destroyed.
  bool pass_slaves(const FramePath& path, const FrameFate& fate, Nanoseconds now) noexcept;
  bool pass_frame(std::span<std::byte> frame, const FramePath& path, const FrameFate& fate, Nanoseconds now) noexcept;
  void process_without_logical(Esc& esc, Nanoseconds time) noexcept;
  /// Returns the time when the frame is damaged on its path; kNever without such a fault.
  [[nodiscard]] static Nanoseconds time_of_damage(const FramePath& path, const FrameFate& fate) noexcept;
  void count_damage(const FramePath& path, PortId damaged_at) noexcept;
  void advance_slaves(std::span<const std::unique_ptr<Slave>> slaves, Nanoseconds now);
  void latch_receive_times(const FramePath& path, Nanoseconds now) noexcept;
  [[nodiscard]] bool survives_as_foreign(const FramePath& path) const noexcept;
  [[nodiscard]] bool link_up(PortId port) const noexcept;
  void refresh_topology() noexcept;
  void refresh_ports(std::size_t position, bool loop_control_written) noexcept;

  rt::Clock& clock_;
  std::vector<std::unique_ptr<Slave>> slaves_;
  Wiring wiring_;
  LineOptions options_;
  std::array<std::unique_ptr<LineEnd>, kMasterPortCount> ends_;
  std::vector<SlavePorts> ports_;
  /// Ports that lost their link in auto-close mode: closed until DL control is written or a frame is received.
  std::vector<std::array<bool, kPortCount>> auto_closed_;
  std::array<FramePath, kMasterPortCount> paths_;
  FrameDatagrams datagrams_;
  std::vector<std::byte> lost_frame_;  ///< buffer to process frames that do not leave the line
  bool topology_changed_ = true;
  std::uint64_t serial_ = 0;
  Counters counters_;
  LineFaults faults_;
};

}  // namespace driveline::slaves
