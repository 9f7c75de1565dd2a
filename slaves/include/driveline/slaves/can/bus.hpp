#pragma once

#include <set>

#include "driveline/slaves/can/segment.hpp"

namespace driveline::slaves::can {

/// A CAN bus: a trunk with nodes in the order in which they were attached. Time is virtual: the bus and its nodes do
/// what is due when advance() is called, and the same calls give the same frames at the same nanosecond. Not thread
/// safe.
class Bus {
 public:
  /// `seed` is for what happens now and then, such as errors by reflections.
  explicit Bus(const Wiring& wiring = {}, std::uint64_t seed = 0);
  Bus(const Bus&) = delete;
  Bus& operator=(const Bus&) = delete;

  /// Adds a node at the end of the trunk; an error frame ends a frame under way. Its controller lives as long as the
  /// bus.
  Controller& attach(Node& node, const ControllerOptions& options = {});
  /// Does everything that is due up to and including `until`. Times before now() do nothing.
  void advance(nanoseconds until);
  /// Puts frames that were queued since the last advance() on a wire that is free, at now(). All else that is due waits
  /// for advance().
  void transmit();
  /// Time of the last advance(). \rtsafe
  [[nodiscard]] nanoseconds now() const noexcept { return now_; }
  /// When advance() has something to do; kNever for nothing. \rtsafe
  [[nodiscard]] nanoseconds next_event() const noexcept;
  /// Figures since the start. \rtsafe
  [[nodiscard]] const BusStatistics& statistics() const noexcept { return conditions_.statistics; }

  /// Returns the number of nodes.
  [[nodiscard]] std::size_t size() const noexcept { return controllers_.size(); }
  /// Returns the controller of the node at this place, counted from 0. Precondition: below size(). \rtsafe
  [[nodiscard]] Controller& controller(std::size_t place) noexcept { return *controllers_[place]; }
  /// Returns cable and terminators. \rtsafe
  [[nodiscard]] const Wiring& wiring() const noexcept { return conditions_.wiring; }

  /// \name Faults
  /// @{

  /// Adds a fault of the next frames.
  void inject(const FrameFault& fault);
  /// Ends the faults of frames with this number.
  void withdraw(std::uint32_t number);
  /// Whether a fault of frames with this number is still to come.
  [[nodiscard]] bool injected(std::uint32_t number) const noexcept;
  /// Cuts the trunk behind the node at this place, counted from 0; an error frame ends a frame under way. Each piece
  /// has the terminator of its own end only.
  void cut(std::size_t behind);
  /// Joins the trunk behind this node again.
  void mend(std::size_t behind);
  /// Changes cable and terminators; an error frame ends a frame under way.
  void set_wiring(const Wiring& wiring);
  /// @}

 private:
  void take_apart();
  void arrange();
  void look_at_nodes() const noexcept;
  void advance_nodes();
  [[nodiscard]] nanoseconds next_due() const noexcept;

  BusConditions conditions_;
  std::vector<std::unique_ptr<Controller>> controllers_;
  std::vector<Segment> segments_;  ///< empty: the trunk has changed
  std::set<std::size_t> cuts_;     ///< places behind which the trunk is cut
  nanoseconds idle_at_{0};         ///< when the wire is free after the last change
  nanoseconds now_{0};
};

}  // namespace driveline::slaves::can
