#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <optional>
#include <vector>

#include "driveline/ecat_master/dc/propagation_delay.hpp"
#include "driveline/ecat_master/dc/sync_signals.hpp"
#include "driveline/ecat_master/dc/system_time.hpp"
#include "driveline/ecat_master/dc/time_source.hpp"
#include "driveline/esi/device_description.hpp"

namespace driveline::ecat_master::dc {

/// Which clock follows which clock.
enum class FollowMode : std::uint8_t {
  kMasterFollows,  ///< the master's cycle follows the reference clock
  /// Bus shift: the reference clock follows the master's clock, or ClockPlan::time; with ClockPlan::time the cycle
  /// follows the reference clock, so that frames keep their phase.
  kReferenceFollows,
};

/// The plan for the clock of a slave.
struct SlaveClockPlan {
  SyncSignals signals;  ///< SYNC signals; none when assign_activate (0x0981) is 0
  /// The SYNC0 cycle must be a multiple of this (MSD manual 9.1: 125 us); 0: any cycle.
  std::chrono::nanoseconds base{0};
  /// DelayNode::processing_extra_ns of the slave's controller.
  double processing_extra_ns = 0.0;
};

/// The plan for the clocks of a line.
struct ClockPlan {
  FollowMode mode = FollowMode::kMasterFollows;  ///< which clock follows which
  /// Position of the slave whose clock is the reference; empty: the first slave with a clock that has SYNC signals, or,
  /// if there is none, the first slave with a clock.
  std::optional<std::uint16_t> reference;
  std::chrono::nanoseconds period = std::chrono::microseconds{125};  ///< period of the master's cycle
  /// How long before SYNC0 (of a slave without shift) the frames pass the reference clock, 0 .. period.
  std::chrono::nanoseconds frame_lead = std::chrono::nanoseconds{62'500};
  /// Time source of the clocks; null: the master's clock. With kMasterFollows the clocks are set to it once, and the
  /// cycle then follows the reference clock; with kReferenceFollows the reference clock follows it. Must outlive the
  /// cycle.
  const TimeSource* time = nullptr;
  std::vector<SlaveClockPlan> slaves;  ///< by position; slaves beyond the end get no signals
  /// Returns the plan for a slave (given the number of its plan) that joins later, called when its description `found`
  /// is known; empty: no signals. Called by the ordinary thread that configures the slave.
  std::function<Result<SlaveClockPlan>(std::size_t plan, const esi::DeviceDescription& found)> joining{};

  /// Slaves that need the time may join anywhere on the line: the first slave with a clock is then the reference, since
  /// slaves before the reference cannot follow it.
  bool may_join = false;

  // Settings for tests and unusual lines.
  /// System time minus master's clock at the time when the clocks are set, without `time`.
  std::chrono::nanoseconds epoch{0};
  unsigned latch_rounds = 16;               ///< number of frames over which receive times are averaged
  unsigned drift_datagrams = 15'000;        ///< number of datagrams of the static drift compensation
  unsigned drift_datagrams_per_frame = 32;  ///< 2 to 80
  std::chrono::nanoseconds drift_pause =
      std::chrono::microseconds{250};  ///< pause between the frames of the static drift compensation
  /// The static compensation continues until all clocks differ by less than this, but at most `drift_limit` longer than
  /// its datagrams take.
  std::chrono::nanoseconds drift_window{100};
  /// Longest extension of the static compensation.
  std::chrono::nanoseconds drift_limit = std::chrono::milliseconds{1000};
  std::chrono::nanoseconds start_lead = std::chrono::milliseconds{100};  ///< initial lead of the start time
};

/// The clock of a slave, as found and set.
struct SlaveClock {
  bool present = false;   ///< whether the slave has a clock
  bool wide = false;      ///< whether the clock has 64 bits
  bool follows = false;   ///< whether it follows the reference clock: frames pass it after the reference clock
  double delay_ns = 0.0;  ///< delay from the first clock of the line
  DelayQuality quality = DelayQuality::kNone;  ///< quality of `delay_ns`
  std::uint32_t delay = 0;                     ///< register 0x0928: delay from the reference clock
  std::uint64_t offset = 0;                    ///< register 0x0920
  SyncSignals signals;                         ///< as planned
  std::uint64_t start = 0;                     ///< register 0x0990 (for a 32-bit clock the lower half)
  double processing_extra_ns = 0.0;            ///< as planned
  /// Register 0x092C at the end of the static compensation.
  std::chrono::nanoseconds difference{0};
};

/// The clocks of a line as set by bring_up_clocks().
struct LineClocks {
  FollowMode mode = FollowMode::kMasterFollows;  ///< as planned
  std::chrono::nanoseconds period{0};            ///< period of the master's cycle
  std::chrono::nanoseconds frame_lead{0};        ///< as planned
  const TimeSource* time = nullptr;              ///< as planned; null: the master's clock
  std::uint16_t reference = 0;                   ///< position of the reference clock
  std::uint16_t station = 0;                     ///< station address of the reference
  std::vector<SlaveClock> slaves;                ///< by position
  /// Relation of the master's clock to the reference clock.
  ClockMapping mapping;
  /// System time of the first SYNC0 of a slave without shift; it repeats with every multiple of the common cycle.
  std::uint64_t start = 0;
  std::chrono::nanoseconds common_cycle{0};  ///< time after which all signals and the master's cycle repeat
  unsigned drift_frames = 0;                 ///< number of frames of the static compensation
  unsigned drift_frames_lost = 0;            ///< number of these frames that did not return
};

/// DelayNode::processing_extra_ns of all slaves.
[[nodiscard]] inline std::vector<double> processing_extra(const LineClocks& clocks) {
  std::vector<double> all;
  for (const auto& clock : clocks.slaves) all.push_back(clock.processing_extra_ns);
  return all;
}

}  // namespace driveline::ecat_master::dc
