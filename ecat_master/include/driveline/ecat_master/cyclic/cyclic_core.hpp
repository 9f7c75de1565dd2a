#pragma once

#include <array>
#include <atomic>
#include <memory>
#include <vector>

#include "driveline/ecat_master/bus/datagram_exchange.hpp"
#include "driveline/ecat_master/cyclic/acyclic_channel.hpp"
#include "driveline/ecat_master/cyclic/cyclic_frame.hpp"
#include "driveline/ecat_master/cyclic/exchange_judge.hpp"
#include "driveline/ecat_master/cyclic/foreign_frames.hpp"
#include "driveline/ecat_master/cyclic/receive_wait.hpp"
#include "driveline/ecat_master/dc/clock_follower.hpp"
#include "driveline/motion/cia301/process_copy.hpp"
#include "driveline/motion/control/motion_control.hpp"
#include "driveline/motion/cycle/cycle.hpp"
#include "driveline/motion/cycle/cycle_record.hpp"
#include "driveline/motion/cycle/cycle_task.hpp"
#include "driveline/rt/counter.hpp"
#include "driveline/rt/cycle_timer.hpp"
#include "driveline/rt/histogram.hpp"
#include "driveline/snapshot/snapshot.hpp"

namespace driveline::ecat_master {

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
  void count(bool on) noexcept { record_.count(on); }
  /// Cycles so far, counted or not.
  [[nodiscard]] std::uint64_t cycles() const noexcept { return record_.cycles(); }
  /// Consecutive cycles whose process data were not all valid.
  [[nodiscard]] std::uint32_t bad_cycles() const noexcept { return judge_.bad_cycles(); }
  /// Newest AL status of the line; slaves == 0 while no frame comes back.
  [[nodiscard]] LineAlStatus al_status() const noexcept { return judge_.al_status(); }

  using SlaveReport = ExchangeJudge::SlaveReport;  ///< see ExchangeJudge
  /// `slave` must be in the process image.
  [[nodiscard]] SlaveReport slave_report(std::size_t slave) const noexcept { return judge_.slave_report(slave); }
  /// Excludes a slave from the check of working counters while it is being configured: its process data are not valid,
  /// and its share does not affect the others. Takes effect in the next cycle. `slave` must be in the process image.
  void set_recovering(std::size_t slave, bool recovering) noexcept { judge_.set_recovering(slave, recovering); }
  /// Counters by group number.
  [[nodiscard]] std::span<const ExchangeGroupCounters> groups() const noexcept { return judge_.groups(); }
  /// Permits a group to drive its outputs again after ExchangeGroupSettings::bad_cycle_limit has zeroed them.
  void release_outputs(std::size_t group) noexcept { judge_.release_outputs(group); }
  /// Frames since the cycle started that were no longer expected, such as late ones and duplicates.
  [[nodiscard]] std::uint64_t stale_frames() const noexcept { return stale_frames_.value(); }
  /// Frames of other senders since the cycle started; see stale_frames().
  [[nodiscard]] std::uint64_t foreign_frames() const noexcept { return foreign_.count(); }

  /// Cycles since the cycle started that received no further; see motion::CycleStatistics::flooded_cycles.
  [[nodiscard]] std::uint64_t flooded_cycles() const noexcept { return flooded_cycles_.value(); }

  /// EtherCAT frames of another master since the cycle started.
  [[nodiscard]] OtherMaster other_master() const noexcept { return foreign_.other_master(); }

  /// Takes the oldest event not fetched yet; one thread.
  [[nodiscard]] bool take_event(CyclicEvent& event) noexcept { return judge_.take_event(event); }
  /// Takes the oldest absence of the master not fetched yet; one thread.
  [[nodiscard]] bool take_absence(motion::MasterAbsence& absence) noexcept { return record_.take_absence(absence); }
  /// Absences dropped because their ring was full.
  [[nodiscard]] std::uint64_t absences_dropped() const noexcept { return record_.absences_dropped(); }
  /// Events dropped because their ring was full.
  [[nodiscard]] std::uint64_t events_dropped() const noexcept { return judge_.events_dropped(); }

  /// Counters and times; only while no cycle runs.
  [[nodiscard]] const motion::CycleStatistics& statistics() const noexcept { return record_.statistics(); }
  /// Inputs, outputs and their layout. Once cycles run, the bytes belong to the cycle.
  [[nodiscard]] ProcessImage& image() noexcept { return image_; }

 private:
  /// Unexpected frames that a cycle takes in all, and after its deadline, there besides one for each of its own frames:
  /// an answer that has arrived during a suspension of the thread may be behind those of the cycle before.
  static constexpr std::uint32_t kMostUnexpected = 256;
  static constexpr std::uint32_t kMostUnexpectedLate = 8;
  /// First sequence number, far from those of frames sent before the cycle started.
  static constexpr std::uint32_t kFirstSequence = 0x8000'0000;

  void begin(const rt::CycleStart& start) noexcept;
  void send(std::chrono::nanoseconds grid) noexcept;
  void take_what_is_back() noexcept;
  void receive() noexcept;
  [[nodiscard]] bool sleep_towards_answers() noexcept;
  void wait_on(std::chrono::nanoseconds& yielded_at) noexcept;
  [[nodiscard]] bool take(const port::ReceivedFrame& frame) noexcept;
  [[nodiscard]] bool dispatch(const port::ReceivedFrame& frame) noexcept;
  void run_tasks(motion::TaskTiming::Order order, const rt::CycleStart& start) noexcept;
  void remember_missing(std::uint32_t sequence) noexcept;
  [[nodiscard]] bool was_missing(std::uint32_t sequence) noexcept;
  void tally() noexcept;
  [[nodiscard]] snapshot::LineSample line_sample(const rt::CycleStart& start) const noexcept;
  [[nodiscard]] bool all_received() const noexcept { return awaited_ == 0; }

  port::Port& port_;
  rt::Clock& clock_;
  ProcessImage image_;
  motion::MotionControl* motion_;
  Settings settings_;
  motion::CycleRecord record_;
  std::vector<CyclicFrame> frames_;
  ExchangeJudge judge_;
  ForeignFrames foreign_;
  std::size_t awaited_ = 0;  ///< frames of this cycle that are not back yet
  bool prepared_ = false;    ///< the frames contain the outputs of the next cycle
  AcyclicChannel acyclic_;
  ReceiveWait receive_wait_;
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
  rt::Counter stale_frames_;
  rt::Counter flooded_cycles_;
};

}  // namespace driveline::ecat_master
