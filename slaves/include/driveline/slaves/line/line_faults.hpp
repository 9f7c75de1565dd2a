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

class SimulatedLine;

/// Start or end of a fault.
struct FaultEvent {
  std::chrono::nanoseconds time{0};  ///< time of the event
  Fault fault;                       ///< the fault
  bool begins = false;               ///< true: the fault starts; false: it ends
};

/// Effect of the active faults on a frame.
struct FrameFate {
  bool lost_out = false;               ///< lost before the first slave
  bool lost_back = false;              ///< lost after the last slave
  bool duplicated = false;             ///< leaves the line twice
  bool short_working_counter = false;  ///< at least one slave does not take part, see LineFaults::takes_part()
  std::chrono::nanoseconds delay{0};   ///< additional delay of its return
  std::optional<PortId> damaged_at;    ///< port from where on its frame check sequence is wrong
};

/// Faults of a line: active ones, and faults that a script starts at their time. Chance is seeded, so the same faults
/// affect the same frames in each run.
///
/// Used by the thread that drives the line; next_event() may be called by one other thread. Only the constructor and
/// schedule() allocate.
class LineFaults {
 public:
  /// Times are on the line's clock.
  using Nanoseconds = std::chrono::nanoseconds;
  /// Time of an event that does not occur: nothing is due, or a fault lasts until healed.
  static constexpr Nanoseconds kNever = Nanoseconds::max();
  /// Maximum number of active faults.
  static constexpr std::size_t kMaxActive = 64;

  /// Creates faults for a line of `slave_count` slaves; the line must outlive this.
  explicit LineFaults(SimulatedLine& line, std::size_t slave_count);

  /// Starts a fault at `now`; it replaces a fault of the same kind and place. Returns false when there is no such slave
  /// or cable, or kMaxActive faults are active. \rtsafe
  bool begin(const Fault& fault, Nanoseconds now) noexcept;
  /// Ends the fault of this kind and place (either end of a cable); returns false when it is not active. \rtsafe
  bool heal(const Fault& fault, Nanoseconds now) noexcept;
  /// Ends all faults and discards the script. \rtsafe
  void heal_all(Nanoseconds now) noexcept;
  /// Starts a fault at the time `at`.
  void schedule(Nanoseconds at, const Fault& fault);

  /// Returns the time of the next call of run(); kNever when nothing is due.
  [[nodiscard]] Nanoseconds due() const noexcept { return due_; }
  /// Starts and ends the due faults. \rtsafe
  void run(Nanoseconds now) noexcept;

  /// Whether any active fault affects frames, so that next_frame() must be called.
  [[nodiscard]] bool concern_frames() const noexcept { return frame_faults_ > 0; }
  /// Determines the effect on the next frame; flips its bits if it is corrupted before the first slave. \rtsafe
  [[nodiscard]] FrameFate next_frame(std::span<std::byte> frame, Nanoseconds now) noexcept;
  /// Flips the bits of a frame that is corrupted after the last slave. \rtsafe
  void corrupt_reply(std::span<std::byte> frame, Nanoseconds now) noexcept;
  /// Whether the slave processes the logical datagrams of the frame of next_frame(). \rtsafe
  [[nodiscard]] bool takes_part(std::size_t slave) const noexcept { return !absent_[slave]; }

  /// An active fault. For the thread that drives the line.
  struct Active {
    Fault fault;               ///< cable faults refer to the end at the lower position
    Nanoseconds end{kNever};   ///< time when it ends automatically
    std::uint64_t hits = 0;    ///< affected frames
    std::uint32_t random = 0;  ///< state of the random numbers
    Nanoseconds before{0};     ///< replaced time setting of the slave
    std::byte checksum{0};     ///< correct checksum
  };
  /// Returns the active faults in no particular order; valid until the next change. \rtsafe
  [[nodiscard]] std::span<const Active> active() const noexcept { return std::span(active_).first(count_); }

  /// Takes the oldest start or end of a fault; returns false when there is none.
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

  SimulatedLine& line_;
  std::array<Active, kMaxActive> active_;
  std::size_t count_ = 0;
  std::size_t frame_faults_ = 0;
  std::vector<Planned> script_;  ///< latest first
  Nanoseconds due_ = kNever;
  std::vector<std::uint8_t> absent_;
  rt::SpscRing<FaultEvent> events_;
};

}  // namespace driveline::slaves
