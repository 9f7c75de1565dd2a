#pragma once

#include <array>
#include <atomic>
#include <memory>
#include <vector>

#include "driveline/ecat_master/bus/datagram_exchange.hpp"
#include "driveline/ecat_master/cyclic/acyclic_channel.hpp"
#include "driveline/ecat_master/cyclic/cyclic_event.hpp"
#include "driveline/ecat_master/cyclic/cyclic_frame.hpp"
#include "driveline/ecat_master/cyclic/receive_wait.hpp"
#include "driveline/ecat_master/dc/clock_follower.hpp"
#include "driveline/motion/cia301/process_copy.hpp"
#include "driveline/motion/control/motion_control.hpp"
#include "driveline/motion/cycle/cycle.hpp"
#include "driveline/motion/cycle/cycle_statistics.hpp"
#include "driveline/motion/cycle/cycle_task.hpp"
#include "driveline/motion/cycle/cycle_trace.hpp"
#include "driveline/motion/cycle/flight_recorder.hpp"
#include "driveline/motion/cycle/sample_rings.hpp"
#include "driveline/rt/counter.hpp"
#include "driveline/rt/cycle_timer.hpp"
#include "driveline/rt/histogram.hpp"
#include "driveline/snapshot/snapshot.hpp"

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

/// The cyclic exchange. Sends the outputs computed in the previous cycle at the grid instant, in frames that can be
/// prepared in advance for the least jitter; waits for the answers up to a deadline within the period; then reads the
/// inputs and prepares the next outputs. The frames of all due groups are on the wire at once.
///
/// A lost or late frame costs its cycle at most the waiting time, and the next cycle nothing: the grid does not move.
/// cycle() is \rtsafe and noexcept; one thread.
class CyclicCore final : public motion::Cycle {
 public:
  /// Settings of the cycle.
  struct Settings {
    std::chrono::nanoseconds period = std::chrono::microseconds{125};  ///< cycle time of the grid
    /// Longest wait for the answers, from the grid time on.
    std::chrono::nanoseconds receive_window = std::chrono::microseconds{90};
    ReceiveStrategy receive{};       ///< method of waiting for the answers
    std::uint16_t slaves = 0;        ///< number of slaves on the line, for the AL status broadcast
    std::uint16_t instance = 0;      ///< FrameTag::instance; the master sets its own
    std::uint32_t sample_every = 1;  ///< samples of every n-th cycle are written to the rings
    /// Average bytes of acyclic frames per cycle; 0: ecat_master::acyclic_bytes().
    std::size_t acyclic_bytes = 0;
    motion::TaskSchedule* tasks =
        nullptr;  ///< tasks of the application, before and after the motion; must outlive the core
    std::vector<motion::ProcessDataCopy> copies;  ///< copies from slave to slave, after tasks and motion in every cycle
    motion::FlightRecorder* recorder = nullptr;   ///< must outlive the core
    motion::CycleTrace* trace = nullptr;          ///< trace of the counted cycles; must outlive the core
    dc::ClockFollower* clocks = nullptr;          ///< distributed clocks; null: none. Must outlive the core
  };
  /// Capacity of the ring of events; when it is full, events are dropped and counted.
  static constexpr std::size_t kEventRing = 1024;
  /// Capacity of the ring of absences; likewise.
  static constexpr std::size_t kAbsenceRing = 256;

  /// `motion` may be null: then process data are exchanged as they are in the image.
  CyclicCore(port::Port& port, rt::Clock& clock, ProcessImage image, motion::MotionControl* motion,
             motion::SampleRings rings, Settings settings);

  /// Period of the settings. \rtsafe
  [[nodiscard]] std::chrono::nanoseconds period() const noexcept override { return settings_.period; }
  /// Copies the outputs into the frames of the next cycle, in the time between wake-up and grid instant; otherwise
  /// cycle() does it. Outputs must not change afterwards. \rtsafe
  void prepare() noexcept override;
  /// Runs one cycle. \rtsafe
  void cycle(const rt::CycleStart& start) noexcept override;
  /// First instant of the grid, not before `earliest`: a multiple of the period, or the planned phase of the reference
  /// clock, which is the same at every start. \rtsafe
  [[nodiscard]] std::chrono::nanoseconds first_grid(std::chrono::nanoseconds earliest) const noexcept override;
  /// Correction of the grid before the next cycle. \rtsafe
  [[nodiscard]] std::chrono::nanoseconds grid_shift() const noexcept override { return grid_shift_; }

  /// Channel for acyclic work that shares the wire; its functions state their thread.
  [[nodiscard]] AcyclicChannel& acyclic() noexcept { return acyclic_; }
  /// Settings given to the constructor, with tasks and copies. \rtsafe
  [[nodiscard]] const Settings& settings() const noexcept { return settings_; }

  // Functions for any thread, \rtsafe.
  /// Switches the statistics on (default) or off from the next cycle on; switching them on resets them, also if they
  /// were switched off and on between two cycles.
  void count(bool on) noexcept {
    auto switched = count_switched_.load(std::memory_order_relaxed);
    while (counts(switched) != on && !count_switched_.compare_exchange_weak(switched, switched + 1)) {
    }
  }
  /// Cycles so far, counted or not.
  [[nodiscard]] std::uint64_t cycles() const noexcept { return cycles_shared_.load(std::memory_order_acquire); }
  /// Consecutive cycles whose process data were not all valid.
  [[nodiscard]] std::uint32_t bad_cycles() const noexcept { return bad_cycles_.load(std::memory_order_relaxed); }
  /// Newest AL status of the line; slaves == 0 while no frame comes back.
  [[nodiscard]] LineAlStatus al_status() const noexcept {
    const auto raw = al_status_shared_.load(std::memory_order_relaxed);
    return {static_cast<std::uint16_t>(raw >> 16), static_cast<std::uint16_t>(raw & 0xFFFF)};
  }

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
  /// Excludes a slave from the check of working counters while it is being configured: its process data are not valid,
  /// and its share does not affect the others. Takes effect in the next cycle. `slave` must be in the process image.
  void set_recovering(std::size_t slave, bool recovering) noexcept {
    shared_[slave].recovering.store(recovering, std::memory_order_relaxed);
    recovery_requests_.fetch_add(1, std::memory_order_release);
  }
  /// Counters by group number.
  [[nodiscard]] std::span<const ExchangeGroupCounters> groups() const noexcept { return {groups_.get(), group_count_}; }
  /// Permits a group to drive its outputs again after ExchangeGroupSettings::bad_cycle_limit has zeroed them.
  void release_outputs(std::size_t group) noexcept { groups_[group].outputs_zeroed.store(false); }
  /// Frames since the cycle started that were no longer expected, such as late ones and duplicates.
  [[nodiscard]] std::uint64_t stale_frames() const noexcept { return stale_frames_.value(); }
  /// Frames of other senders since the cycle started; see stale_frames().
  [[nodiscard]] std::uint64_t foreign_frames() const noexcept { return foreign_frames_.value(); }

  /// Cycles since the cycle started that received no further; see motion::CycleStatistics::flooded_cycles.
  [[nodiscard]] std::uint64_t flooded_cycles() const noexcept { return flooded_cycles_.value(); }

  /// EtherCAT frames of another master since the cycle started.
  [[nodiscard]] OtherMaster other_master() const noexcept;

  /// Takes the oldest event not fetched yet; one thread.
  [[nodiscard]] bool take_event(CyclicEvent& event) noexcept { return events_.try_pop(event); }
  /// Takes the oldest absence of the master not fetched yet; one thread.
  [[nodiscard]] bool take_absence(motion::MasterAbsence& absence) noexcept { return absences_.try_pop(absence); }
  /// Absences dropped because their ring was full.
  [[nodiscard]] std::uint64_t absences_dropped() const noexcept { return absences_.dropped(); }
  /// Events dropped because their ring was full.
  [[nodiscard]] std::uint64_t events_dropped() const noexcept { return events_.dropped(); }

  /// Counters and times; only while no cycle runs.
  [[nodiscard]] const motion::CycleStatistics& statistics() const noexcept { return statistics_; }
  /// Inputs, outputs and their layout. Once cycles run, the bytes belong to the cycle.
  [[nodiscard]] ProcessImage& image() noexcept { return image_; }

 private:
  /// Unexpected frames that a cycle takes in all, and after its deadline, there besides one for each of its own frames:
  /// an answer that has arrived during a suspension of the thread may be behind those of the cycle before.
  static constexpr std::uint32_t kMostUnexpected = 256;
  static constexpr std::uint32_t kMostUnexpectedLate = 8;
  /// First sequence number, far from those of frames sent before the cycle started.
  static constexpr std::uint32_t kFirstSequence = 0x8000'0000;

  struct SharedSlave {
    std::atomic<std::uint32_t> report{0};
    std::atomic<std::uint32_t> stale{0};
    std::atomic<bool> recovering{false};
  };
  /// Results for a group in a cycle.
  struct ExchangeGroupTally {
    unsigned lost = 0;
    unsigned incomplete = 0;
    unsigned working_counter = 0;
    unsigned last_working_counter = 0;
    unsigned expected = 0;
    bool due = false;
    /// All slaves of the group were valid when they were last evaluated, so an unchanged answer changes nothing.
    bool settled = false;
  };

  [[nodiscard]] bool due(const CyclicFrame& frame) const noexcept;
  void begin(const rt::CycleStart& start) noexcept;
  /// Costs one branch without a trace.
  void mark(motion::CyclePhase phase) noexcept {
    if (settings_.trace != nullptr) settings_.trace->mark(phase, clock_.now());
  }
  [[nodiscard]] std::span<const bool> due_slaves() noexcept;
  void take_recovery_requests() noexcept;
  void take_counting() noexcept;
  [[nodiscard]] static constexpr bool counts(std::uint64_t switched) noexcept { return (switched & 1U) != 0; }
  void note_absence(const rt::CycleStart& start) noexcept;
  [[nodiscard]] bool zeroed(const CyclicFrame& frame) const noexcept;
  void send(std::chrono::nanoseconds grid) noexcept;
  void take_what_is_back() noexcept;
  void receive() noexcept;
  [[nodiscard]] bool sleep_towards_answers() noexcept;
  void wait_on(std::chrono::nanoseconds& yielded_at) noexcept;
  [[nodiscard]] bool take(const port::ReceivedFrame& frame) noexcept;
  [[nodiscard]] bool dispatch(const port::ReceivedFrame& frame) noexcept;
  void note_foreign(std::span<const std::byte> frame) noexcept;
  void run_tasks(motion::TaskTiming::Order order, const rt::CycleStart& start) noexcept;
  void remember_missing(std::uint32_t sequence) noexcept;
  [[nodiscard]] bool was_missing(std::uint32_t sequence) noexcept;
  void evaluate(const rt::CycleStart& start) noexcept;
  void judge_groups(const rt::CycleStart& start) noexcept;
  void judge_group(std::size_t number, const rt::CycleStart& start) noexcept;
  [[nodiscard]] bool anything_new() const noexcept;
  void judge_slaves(const rt::CycleStart& start) noexcept;
  [[nodiscard]] bool judge_slave(std::size_t slave, const rt::CycleStart& start) noexcept;
  [[nodiscard]] bool carried(std::size_t datagram) const noexcept;
  void note(CyclicEvent::Kind kind, std::size_t index, unsigned before, unsigned after,
            const rt::CycleStart& start) noexcept;
  void tally(const rt::CycleStart& start, std::chrono::nanoseconds cost) noexcept;
  [[nodiscard]] snapshot::LineSample line_sample(const rt::CycleStart& start,
                                                 std::chrono::nanoseconds cost) const noexcept;
  void publish(const rt::CycleStart& start, std::chrono::nanoseconds cost) noexcept;
  void record(const snapshot::LineSample& line) noexcept;
  [[nodiscard]] bool turned_bad_for_long() const noexcept;
  [[nodiscard]] bool all_received() const noexcept { return awaited_ == 0; }

  port::Port& port_;
  rt::Clock& clock_;
  ProcessImage image_;
  motion::MotionControl* motion_;
  motion::SampleRings rings_;
  Settings settings_;
  std::vector<CyclicFrame> frames_;
  std::size_t awaited_ = 0;                     ///< frames of this cycle that are not back yet
  std::vector<const DatagramResult*> results_;  ///< by datagram of the image
  std::vector<SlaveCondition> conditions_;
  std::vector<SlaveCondition> before_;
  std::vector<char> was_op_;
  std::unique_ptr<bool[]> slave_valid_;
  std::unique_ptr<bool[]> slave_operational_;
  std::unique_ptr<bool[]> slave_due_;
  bool uneven_ = false;    ///< some groups are not due in every cycle
  bool prepared_ = false;  ///< the frames contain the outputs of the next cycle
  std::unique_ptr<SharedSlave[]> shared_;
  std::size_t group_count_ = 0;
  std::unique_ptr<ExchangeGroupCounters[]> groups_;
  std::vector<ExchangeGroupTally> tallies_;
  rt::SpscRing<CyclicEvent> events_{kEventRing};
  rt::SpscRing<motion::MasterAbsence> absences_{kAbsenceRing};
  AcyclicChannel acyclic_;
  ReceiveWait receive_wait_;
  motion::CycleStatistics statistics_;
  bool counting_ = true;
  std::uint64_t count_seen_ = 1;  ///< value of count_switched_ in the last cycle
  std::uint64_t cycle_number_ = 0;
  std::uint64_t cycles_ = 0;
  std::uint32_t sequence_ = kFirstSequence;
  /// Sequence numbers of the last frames that did not come back in time; 0: none.
  std::array<std::uint32_t, 64> missing_{};
  std::size_t next_missing_ = 0;
  std::chrono::nanoseconds sent_at_{};
  std::chrono::nanoseconds deadline_{};  ///< until which answers are awaited in this cycle
  std::uint32_t unexpected_ = 0;         ///< unexpected frames in this cycle
  std::uint32_t unexpected_late_ = 0;    ///< those of them that were taken after the deadline
  bool flooded_ = false;                 ///< motion::CycleStatistics::flooded_cycles counts this cycle
  std::chrono::nanoseconds received_at_{};
  std::chrono::nanoseconds exchanged_at_{};
  std::chrono::nanoseconds grid_shift_{};
  std::uint32_t missed_now_ = 0;
  std::uint32_t recovery_requests_seen_ = 0;
  bool failure_recorded_ = false;
  rt::Counter stale_frames_;
  rt::Counter foreign_frames_;
  rt::Counter flooded_cycles_;
  rt::Counter frames_of_masters_;
  std::atomic<std::uint64_t> other_source_{0};       ///< source address of the other master, first byte lowest
  std::atomic<std::uint64_t> other_datagram_{0};     ///< weight, command, ADP and ADO
  std::atomic<std::uint32_t> recovery_requests_{0};  ///< number of set_recovering() calls; wraps around
  std::atomic<std::uint64_t> count_switched_{1};     ///< number of times that count() changed; odd: on
  std::atomic<std::uint64_t> cycles_shared_{0};
  std::atomic<std::uint32_t> bad_cycles_{0};
  std::atomic<std::uint32_t> al_status_shared_{0};
};

}  // namespace driveline::ecat_master
