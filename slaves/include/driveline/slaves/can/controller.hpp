#pragma once

#include <optional>

#include "driveline/slaves/can/bus_off_recovery.hpp"
#include "driveline/slaves/can/node.hpp"
#include "driveline/slaves/can/transmit_queue.hpp"

namespace driveline::slaves::can {

/// Settings of a controller.
struct ControllerOptions {
  std::uint32_t bit_rate = 1'000'000;  ///< in bit/s; a divisor of 10^9, so that a bit is a whole number of nanoseconds
  bool listen_only = false;            ///< receives, and neither sends, acknowledges nor signals errors
  bool loop_back = false;              ///< receives its own frames, too
  bool error_frames = false;           ///< receives a frame of FrameKind::kError for each error frame on the bus
  bool automatic_recovery = false;     ///< returns from bus off by itself
  std::size_t queue_capacity = 64;     ///< frames that can wait for the bus
};

/// CAN controller and transceiver of one node. A node calls the functions above the line, a test or a script the faults
/// below it; the bus does the rest. Not thread safe.
class Controller {
 public:
  /// Precondition: the bit rate divides 10^9. The node must outlive this.
  Controller(Node& node, const ControllerOptions& options);

  /// Queues a frame; false: it is dropped, because the queue is full, the frame is not valid, or the controller is bus
  /// off, without power or listens only. \rtsafe
  bool send(const Frame& frame) noexcept;
  /// Frames that wait. \rtsafe
  [[nodiscard]] TransmitQueue& queue() noexcept { return queue_; }
  /// Settings; the bit rate is the one in use. \rtsafe
  [[nodiscard]] const ControllerOptions& options() const noexcept { return options_; }
  /// Error counters. \rtsafe
  [[nodiscard]] const ErrorCounters& errors() const noexcept { return errors_; }
  /// Takes part with another bit rate from the next frame on; a divisor of 10^9. \rtsafe
  void set_bit_rate(std::uint32_t bit_rate) noexcept {
    bit_rate_ = bit_rate;
    use_bit_rate();
  }
  /// Takes part as a listener only, or not, from the next frame on. \rtsafe
  void set_listen_only(bool on) noexcept { options_.listen_only = on; }
  /// Asks for the recovery from bus off; without effect in the other states. \rtsafe
  void recover(nanoseconds now) noexcept;
  /// Starts again as after power-on: error active, in bus off, too; frames that wait are lost. \rtsafe
  void restart() noexcept;
  /// Whether transceiver and node have power. \rtsafe
  [[nodiscard]] bool powered() const noexcept { return powered_ && supplied_; }
  /// Duration of a bit. \rtsafe
  [[nodiscard]] nanoseconds bit_time() const noexcept { return bit_time_; }

  /// \name Faults
  /// @{

  /// Switches the transceiver off or on. Without power a node is not there: frames that wait are lost, counters reset.
  void set_power(bool on) noexcept;
  /// The node sends this frame without pause and whatever it was told; an empty value ends that.
  void babble(const std::optional<Frame>& frame) noexcept { babble_ = frame; }
  /// The transceiver holds the bus dominant from the end of the frame under way on, or stops to.
  void hold_dominant(bool held) noexcept { dominant_ = held; }
  /// Takes the supply of the node away, or gives it back. Without it the node is not there, whatever set_power() says.
  void set_supply(bool on) noexcept;
  /// The node takes part with this bit rate, a divisor of 10^9, whatever it was told; an empty value ends that.
  void hold_bit_rate(std::optional<std::uint32_t> bit_rate) noexcept {
    held_bit_rate_ = bit_rate;
    use_bit_rate();
  }
  /// The node goes bus off, as after 32 errors of its own frames in a row.
  void fail(nanoseconds now);
  /// @}

 private:
  friend class Bus;
  friend class Segment;

  /// Asks the node when it has something to do: behind every call of it, and before the bus relies on the answer when
  /// others may have called it.
  void look() noexcept { wake_ = node_->next_wake(); }
  void advance(nanoseconds now) {
    node_->advance(now);
    look();
  }
  void receive(const Frame& frame, nanoseconds now) {
    node_->receive(frame, now);
    look();
  }

  [[nodiscard]] bool on_bus() const noexcept { return powered() && errors_.state() != ErrorState::kBusOff; }
  /// Whether it acknowledges and signals errors.
  [[nodiscard]] bool takes_part() const noexcept { return on_bus() && !options_.listen_only; }
  /// The frame with which it competes for the bus; nullptr: none.
  [[nodiscard]] const Frame* competing() const noexcept;
  /// It has won the bus with competing().
  void begin() noexcept;
  /// The frame has been sent.
  void sent(nanoseconds now);
  /// The frame has not been sent; it waits again.
  void retry() noexcept;
  /// Tells the node when the state is no longer `before`.
  void report(ErrorState before, nanoseconds now) {
    if (errors_.state() != before) state_changed(now);
  }
  void state_changed(nanoseconds now);
  void use_bit_rate() noexcept;
  void recovered(nanoseconds now);

  Node* node_;
  ControllerOptions options_;
  TransmitQueue queue_;
  ErrorCounters errors_;
  BusOffRecovery recovery_;
  nanoseconds suspended_until_{0};  ///< error passive senders wait for 8 bits behind the interframe space
  std::optional<Frame> sending_;    ///< on the wire
  std::optional<Frame> babble_;
  nanoseconds bit_time_;
  nanoseconds wake_ = kNever;  ///< next wake of the node, as last asked
  std::uint32_t bit_rate_;     ///< bit rate reported to the node
  std::optional<std::uint32_t> held_bit_rate_;
  bool powered_ = true;
  bool supplied_ = true;
  bool dominant_ = false;
};

}  // namespace driveline::slaves::can
