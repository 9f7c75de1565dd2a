#pragma once

#include <atomic>
#include <memory>
#include <span>
#include <vector>

#include "driveline/ecat_master/cyclic/cyclic_event.hpp"
#include "driveline/ecat_master/cyclic/cyclic_frame.hpp"
#include "driveline/rt/counter.hpp"
#include "driveline/rt/cycle_timer.hpp"
#include "driveline/rt/spsc_ring.hpp"

namespace driveline::ecat_master {

/// Counters of an exchange group since the cycle started. Any thread may read them. \rtsafe
struct ExchangeGroupCounters {
  rt::Counter exchanges;    ///< cycles in which the group was due
  rt::Counter lost_frames;  ///< frames of the group that were not back within their cycle
  rt::Counter wkc_errors;   ///< frames of the group whose working counter is not that of a complete line
  std::atomic<std::uint32_t> bad_cycles{0};       ///< consecutive exchanges that were not valid for the whole group
  std::atomic<std::uint32_t> longest_bad{0};      ///< highest `bad_cycles` so far
  std::atomic<std::uint32_t> working_counter{0};  ///< working counter of the last exchange
  std::atomic<bool> outputs_zeroed{false};        ///< ExchangeGroupSettings::bad_cycle_limit was reached
};

/// Judges after each cycle by working counters and status bytes which groups and slaves exchanged valid process data,
/// and shares the result with other threads. The frames of the cycle ask it which of them are due.
class ExchangeJudge {
 public:
  /// Capacity of the ring of events; when it is full, events are dropped and counted.
  static constexpr std::size_t kEventRing = 1024;

  /// `image` and `frames`, the frames of the cycle in the order of the image, must outlive this object and not move.
  ExchangeJudge(const ProcessImage& image, std::span<CyclicFrame> frames);

  /// \name Functions of the cycle, \rtsafe
  /// @{

  /// Starts cycle `number`: determines the groups that are due.
  void begin(std::uint64_t number) noexcept;
  /// Evaluates the frames of the cycle once they are back or given up.
  void evaluate(const rt::CycleStart& start) noexcept;
  /// Whether the group of the frame is due in this cycle.
  [[nodiscard]] bool due(const CyclicFrame& frame) const noexcept {
    return frame.results().empty() || tallies_[frame.group()].due;
  }
  /// Whether the outputs of the frame must be zero, see ExchangeGroupSettings::bad_cycle_limit.
  [[nodiscard]] bool zeroed(const CyclicFrame& frame) const noexcept {
    return groups_[frame.group()].outputs_zeroed.load(std::memory_order_relaxed);
  }
  /// Conditions of the slaves, by slave, for CyclicFrame::accept().
  [[nodiscard]] std::span<SlaveCondition> conditions() noexcept { return conditions_; }
  /// Slaves whose process data are valid.
  [[nodiscard]] std::span<const bool> valid() const noexcept { return {valid_.get(), conditions_.size()}; }
  /// Slaves that also take their outputs.
  [[nodiscard]] std::span<const bool> operational() const noexcept { return {operational_.get(), conditions_.size()}; }
  /// Slaves that are exchanged in this cycle; empty: all.
  [[nodiscard]] std::span<const bool> due_slaves() noexcept;
  /// Whether the process data of a group have now been bad for so many exchanges that the recorder is triggered.
  [[nodiscard]] bool turned_bad_for_long() const noexcept;
  /// @}

  /// \name Functions for any thread, \rtsafe
  /// @{

  /// State of a slave as of the last exchange.
  struct SlaveReport {
    bool valid = false;                 ///< outputs delivered, inputs fresh
    bool operational = false;           ///< valid, and has not left OP
    bool absent = false;                ///< its status byte came back untouched
    bool watched = false;               ///< it has a status byte, so `absent` and `al_status` are meaningful
    std::uint8_t al_status = 0;         ///< low byte of its AL status
    bool mailbox_full = false;          ///< its mailbox status byte reports a waiting mailbox message (only if mapped)
    std::uint32_t stale_exchanges = 0;  ///< exchanges of its group since its inputs were fresh
  };
  /// `slave` must be in the process image.
  [[nodiscard]] SlaveReport slave_report(std::size_t slave) const noexcept;
  /// Excludes a slave from the check of working counters while it is being configured, see CyclicCore.
  void set_recovering(std::size_t slave, bool recovering) noexcept {
    shared_[slave].recovering.store(recovering, std::memory_order_relaxed);
    recovery_requests_.fetch_add(1, std::memory_order_release);
  }
  /// Counters by group number.
  [[nodiscard]] std::span<const ExchangeGroupCounters> groups() const noexcept {
    return {groups_.get(), tallies_.size()};
  }
  /// Permits a group to drive its outputs again.
  void release_outputs(std::size_t group) noexcept { groups_[group].outputs_zeroed.store(false); }
  /// Consecutive cycles whose process data were not all valid.
  [[nodiscard]] std::uint32_t bad_cycles() const noexcept { return bad_cycles_.load(std::memory_order_relaxed); }
  /// Newest AL status of the line; slaves == 0 while no frame comes back.
  [[nodiscard]] LineAlStatus al_status() const noexcept {
    const auto raw = al_status_.load(std::memory_order_relaxed);
    return {static_cast<std::uint16_t>(raw >> 16), static_cast<std::uint16_t>(raw & 0xFFFF)};
  }
  /// Takes the oldest event not fetched yet; one thread.
  [[nodiscard]] bool take_event(CyclicEvent& event) noexcept { return events_.try_pop(event); }
  /// Events dropped because their ring was full.
  [[nodiscard]] std::uint64_t events_dropped() const noexcept { return events_.dropped(); }
  /// @}

 private:
  struct SharedSlave {
    std::atomic<std::uint32_t> report{0};
    std::atomic<std::uint32_t> stale{0};
    std::atomic<bool> recovering{false};
  };
  /// Results for a group in a cycle.
  struct Tally {
    unsigned lost = 0;
    unsigned incomplete = 0;
    unsigned working_counter = 0;
    unsigned last_working_counter = 0;
    unsigned expected = 0;
    bool due = false;
    /// All slaves of the group were valid when they were last evaluated, so an unchanged answer changes nothing.
    bool settled = false;
  };

  void take_recovery_requests() noexcept;
  void judge_groups(const rt::CycleStart& start) noexcept;
  void judge_group(std::size_t number, const rt::CycleStart& start) noexcept;
  void judge_limit(std::size_t number, const rt::CycleStart& start) noexcept;
  [[nodiscard]] bool anything_new() const noexcept;
  void judge_slaves(const rt::CycleStart& start) noexcept;
  [[nodiscard]] bool judge_slave(std::size_t slave, const rt::CycleStart& start) noexcept;
  void share(std::size_t slave, bool valid, bool operational, bool watched) noexcept;
  [[nodiscard]] bool carried(std::size_t datagram) const noexcept;
  void note(CyclicEvent::Kind kind, std::size_t index, unsigned before, unsigned after,
            const rt::CycleStart& start) noexcept;

  const ProcessImage& image_;
  std::span<CyclicFrame> frames_;
  std::vector<const DatagramResult*> results_;  ///< by datagram of the image
  std::vector<SlaveCondition> conditions_;
  std::vector<std::uint8_t> status_before_;  ///< last AL status that was noted as an event, by slave
  std::vector<char> was_op_;
  std::unique_ptr<bool[]> valid_;
  std::unique_ptr<bool[]> operational_;
  std::unique_ptr<bool[]> due_slaves_;
  bool uneven_;  ///< some groups are not due in every cycle
  std::unique_ptr<SharedSlave[]> shared_;
  std::vector<Tally> tallies_;  ///< by group
  std::unique_ptr<ExchangeGroupCounters[]> groups_;
  rt::SpscRing<CyclicEvent> events_{kEventRing};
  std::uint32_t recovery_requests_seen_ = 0;
  std::atomic<std::uint32_t> recovery_requests_{0};  ///< number of set_recovering() calls; wraps around
  std::atomic<std::uint32_t> bad_cycles_{0};
  std::atomic<std::uint32_t> al_status_{0};
};

}  // namespace driveline::ecat_master
