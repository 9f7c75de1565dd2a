#pragma once

#include <memory>
#include <span>

#include "driveline/slaves/can/controller.hpp"
#include "driveline/slaves/can/frame_fault.hpp"
#include "driveline/slaves/can/wiring.hpp"
#include "driveline/slaves/esc/random_source.hpp"

namespace driveline::slaves::can {

/// Figures of a bus since its start.
struct BusStatistics {
  std::uint64_t frames = 0;        ///< sent and acknowledged
  std::uint64_t error_frames = 0;  ///< attempts that an error ended
  std::uint64_t lost = 0;          ///< receptions that a fault suppressed
  nanoseconds busy{0};             ///< time of frames and error frames with their interframe space
};

/// What all pieces of a bus share.
struct BusConditions {
  Wiring wiring;                   ///< cable and terminators
  std::vector<FrameFault> faults;  ///< of the next frames
  RandomSource random{0};          ///< for what happens now and then
  BusStatistics statistics;        ///< of the whole bus
};

/// Nodes that one piece of wire connects: all of them, unless the wire is cut. At most one transmission is under way;
/// what becomes of it is decided at its start, when all senders are known, because a node that queues a frame later
/// waits.
class Segment {
 public:
  /// `first` is the place of the first of these nodes on the bus. `terminators`: 0 to 2.
  Segment(std::span<const std::unique_ptr<Controller>> nodes, std::size_t first, unsigned terminators,
          BusConditions& conditions, nanoseconds idle_at);

  /// When something happens on this wire if no node sends anything else; kNever for nothing. \rtsafe
  [[nodiscard]] nanoseconds next_event() const noexcept;
  /// Delivers a frame that has passed, and finishes recoveries.
  void advance(nanoseconds now);
  /// Starts to transmit where the wire is free and a node has a frame.
  void start(nanoseconds now);
  /// Ends the frame under way by an error frame; returns when the wire is free.
  nanoseconds interrupt(nanoseconds now);

 private:
  /// How a transmission ends.
  enum class Outcome : std::uint8_t { kGood, kNoAcknowledge, kError };
  struct Transmission {
    Frame frame;
    Outcome outcome = Outcome::kGood;
    nanoseconds bit_time{0};
    nanoseconds end{0};   ///< its outcome is known to all
    nanoseconds idle{0};  ///< the next one may begin
  };

  void choose_senders(nanoseconds now);
  void decide(Transmission& transmission, std::size_t& bits, nanoseconds now);
  [[nodiscard]] bool collide(std::size_t& bits, nanoseconds now);
  [[nodiscard]] bool disturbed(const Transmission& transmission, std::size_t& bits);
  [[nodiscard]] bool acknowledged(const Transmission& transmission) const noexcept;
  [[nodiscard]] FrameFault* fault_of(const Frame& frame, FrameFaultKind kind) const noexcept;
  void choose_losses(const Frame& frame) noexcept;
  [[nodiscard]] bool loses(std::size_t place) const noexcept;
  void deliver(const Transmission& transmission, nanoseconds now);
  void count_errors(const Transmission& transmission, nanoseconds now);
  [[nodiscard]] bool is_sender(const Controller& node) const noexcept;
  [[nodiscard]] bool held_dominant() const noexcept;
  void advance_held(nanoseconds now);
  void wire_recessive(nanoseconds since) noexcept;

  std::span<const std::unique_ptr<Controller>> nodes_;
  std::size_t first_;
  unsigned terminators_;
  BusConditions* conditions_;
  std::vector<Controller*> senders_;  ///< of the transmission
  std::optional<Transmission> transmission_;
  nanoseconds idle_at_;
  nanoseconds held_step_ = kNever;  ///< when a wire that is held dominant counts as the next error
};

}  // namespace driveline::slaves::can
