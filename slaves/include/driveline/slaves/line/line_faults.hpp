#pragma once

#include <array>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "driveline/rt/spsc_ring.hpp"
#include "driveline/slaves/line/fault.hpp"

namespace driveline::slaves {

class Line;

/// A fault has begun or ended.
struct FaultEvent {
  std::chrono::nanoseconds time{0};  ///< when
  Fault fault;                       ///< which
  bool begins = false;               ///< else it ends
};

/// Effect of the present faults on one frame.
struct FrameFate {
  bool lost_out = false;               ///< before the first slave
  bool lost_back = false;              ///< behind the last slave
  bool duplicated = false;             ///< comes out twice
  bool short_working_counter = false;  ///< some slave takes no part, see LineFaults::takes_part()
  std::chrono::nanoseconds delay{0};   ///< how much later it comes back
  std::optional<PortId> damaged_at;    ///< port where its check sequence is wrong from then on
};

/// The faults of a line: those that are there now, and those that a script will bring at their time. Chance is seeded,
/// so the same faults hit the same frames again.
///
/// Used by the thread that drives the line; next_event() by one thread of any kind. Nothing but the constructor and
/// schedule() allocates.
class LineFaults {
 public:
  /// Times are on the line's clock.
  using Nanoseconds = std::chrono::nanoseconds;
  /// Stands for "nothing due", and for "lasts until it is healed".
  static constexpr Nanoseconds kNever = Nanoseconds::max();
  /// Faults that can be there at the same time.
  static constexpr std::size_t kMaxActive = 64;

  /// Faults of a line of `slave_count` slaves; the line must outlive this.
  explicit LineFaults(Line& line, std::size_t slave_count);

  /// Begins a fault at `now`, in place of one of the same kind in the same place. False when there is no such slave or
  /// cable, or kMaxActive faults are there. \rtsafe
  bool begin(const Fault& fault, Nanoseconds now) noexcept;
  /// Ends the fault of this kind in this place (either end of a cable); false when it is not there. \rtsafe
  bool heal(const Fault& fault, Nanoseconds now) noexcept;
  /// Ends all faults and forgets the script. \rtsafe
  void heal_all(Nanoseconds now) noexcept;
  /// Begins a fault when the time `at` has come.
  void schedule(Nanoseconds at, const Fault& fault);

  /// Time of the next call of run(); kNever when nothing is due.
  [[nodiscard]] Nanoseconds due() const noexcept { return due_; }
  /// Begins and ends what is due. \rtsafe
  void run(Nanoseconds now) noexcept;

  /// Whether any fault affects frames, so that next_frame() must be called.
  [[nodiscard]] bool concern_frames() const noexcept { return frame_faults_ > 0; }
  /// Decides about the next frame; damages it when it is to be corrupted on its way out. \rtsafe
  [[nodiscard]] FrameFate next_frame(std::span<std::byte> frame, Nanoseconds now) noexcept;
  /// Flips the bits of a frame that is to be corrupted on its way back. \rtsafe
  void corrupt_reply(std::span<std::byte> frame, Nanoseconds now) noexcept;
  /// The slave processes logical datagrams of the frame that next_frame() has decided about. \rtsafe
  [[nodiscard]] bool takes_part(std::size_t slave) const noexcept { return !absent_[slave]; }

  /// An active fault. For the thread that drives the line.
  struct Active {
    Fault fault;               ///< for a cable with the end at the lower position
    Nanoseconds end{kNever};   ///< when it ends by itself
    std::uint64_t hits = 0;    ///< frames
    std::uint32_t random = 0;  ///< state of its random numbers
    Nanoseconds before{0};     ///< the slave's own time that is replaced
    std::byte checksum{0};     ///< the right one
  };
  /// In no particular order; valid until the next change. \rtsafe
  [[nodiscard]] std::span<const Active> active() const noexcept { return std::span(active_).first(count_); }

  /// Takes the oldest fault that has begun or ended; false when there is none.
  [[nodiscard]] bool next_event(FaultEvent& event) noexcept { return events_.try_pop(event); }

 private:
  struct Planned {
    Nanoseconds at;
    Fault fault;
  };

  [[nodiscard]] bool possible(const Fault& fault) const noexcept;
  [[nodiscard]] Fault with_cable_end(Fault fault) const noexcept;
  [[nodiscard]] std::size_t find(const Fault& fault) const noexcept;
  void apply(Active& active, Nanoseconds now) noexcept;
  void undo(const Active& active, Nanoseconds now) noexcept;
  void end(std::size_t index, Nanoseconds now) noexcept;
  void end_used_up(Nanoseconds now) noexcept;
  [[nodiscard]] static bool hits(Active& active) noexcept;
  static void flip_bits(Active& active, std::span<std::byte> frame) noexcept;
  void refresh() noexcept;

  Line& line_;
  std::array<Active, kMaxActive> active_;
  std::size_t count_ = 0;
  std::size_t frame_faults_ = 0;
  std::vector<Planned> script_;  ///< latest first
  Nanoseconds due_ = kNever;
  std::vector<std::uint8_t> absent_;
  rt::SpscRing<FaultEvent> events_;
};

}  // namespace driveline::slaves
