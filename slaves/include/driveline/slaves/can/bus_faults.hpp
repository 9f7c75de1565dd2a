#pragma once

#include <deque>
#include <functional>
#include <optional>
#include <vector>

#include "driveline/slaves/can/bus.hpp"
#include "driveline/slaves/can/bus_fault.hpp"

namespace driveline::slaves::can {

/// A fault has begun or ended.
struct BusFaultEvent {
  bool begins = false;  ///< false: it has ended
  BusFault fault;       ///< what it is
  nanoseconds time{0};  ///< when
};

/// The faults of a bus: those that are active, and those planned for a time of the bus. The same plan gives the same
/// faults at the same nanosecond. Not thread safe.
///
///     faults.plan(2s, {.kind = BusFaultKind::kCableBreak, .slave = 3, .duration = 500ms});
///     for (; faults.next_event() <= until; faults.advance(bus.now())) bus.advance(faults.next_event());
///     bus.advance(until);
class BusFaults {
 public:
  static constexpr std::size_t kMaxActive = 32;   ///< faults at a time
  static constexpr std::size_t kMaxEvents = 256;  ///< events that wait for take_event(); the oldest are lost

  /// `restarts`: how to switch the slaves off and on again, in their order on the bus. The bus must outlive this.
  BusFaults(Bus& bus, std::vector<std::function<void()>> restarts);

  /// Begins a fault at this time.
  void plan(nanoseconds at, const BusFault& fault);
  /// When advance() has something to do; kNever for never.
  [[nodiscard]] nanoseconds next_event() const noexcept;
  /// Begins and ends what is due. The bus must have been advanced to `now`.
  void advance(nanoseconds now);

  /// Begins a fault now; it replaces one of the same kind in the same place. False: too many are active, or there is no
  /// such slave.
  bool begin(const BusFault& fault, nanoseconds now);
  /// Ends the fault of this kind in this place; false: it is not active.
  bool heal(const BusFault& fault, nanoseconds now);
  /// Ends all faults, and forgets those that are planned.
  void heal_all(nanoseconds now);
  /// Returns the active faults in the order of their begin.
  [[nodiscard]] std::vector<BusFault> active() const;
  /// Returns the oldest event that has not been taken.
  [[nodiscard]] std::optional<BusFaultEvent> take_event();

 private:
  struct Active {
    BusFault fault;
    nanoseconds end = kNever;
    std::uint32_t number = 0;  ///< of its FrameFault
  };
  struct Planned {
    nanoseconds at{0};
    BusFault fault;
  };

  void apply(const Active& active, nanoseconds now);
  void undo(const Active& active);
  void inject(const Active& active);
  void set_wiring();
  void end(std::size_t place, nanoseconds now);
  void tell(bool begins, const BusFault& fault, nanoseconds now);

  Bus* bus_;
  Wiring wiring_;  ///< without faults
  std::vector<std::function<void()>> restarts_;
  std::vector<Active> active_;
  std::vector<Planned> planned_;  ///< in the order of time
  std::deque<BusFaultEvent> events_;
  std::uint32_t numbers_ = 0;  ///< given to frame faults so far
};

}  // namespace driveline::slaves::can
