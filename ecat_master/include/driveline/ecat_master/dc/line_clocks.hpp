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

/// Which clock follows which.
enum class FollowMode : std::uint8_t {
  kMasterFollows,  ///< the master's cycle follows the reference clock
  /// Bus shift: the reference clock follows the master's clock, or ClockPlan::time; in the latter case the cycle
  /// follows the reference clock, so that frames keep their phase.
  kReferenceFollows,
};

/// The plan for the clock of one slave.
struct SlaveClockPlan {
  SyncSignals signals;  ///< none when 0x0981 is 0
  /// The SYNC0 cycle must be a multiple of it (MSD manual 9.1: 125 us); 0: any.
  std::chrono::nanoseconds base{0};
  /// DelayNode::processing_extra_ns of its controller.
  double processing_extra_ns = 0.0;
};

/// The plan for the clocks of a line.
struct ClockPlan {
  FollowMode mode = FollowMode::kMasterFollows;  ///< which clock follows which
  /// Position of the slave whose clock is the reference; none: the first that has one.
  std::optional<std::uint16_t> reference;
  std::chrono::nanoseconds period = std::chrono::microseconds{125};  ///< of the master
  /// How long before SYNC0 (of a slave without shift) the frames pass the reference clock: 0 .. period.
  std::chrono::nanoseconds frame_lead = std::chrono::nanoseconds{62'500};
  /// Time source of the clocks; null: the master's clock. With kMasterFollows they are set to it once and then follow
  /// the reference clock; with kReferenceFollows the reference clock follows this time. Must outlive the cycle.
  const TimeSource* time = nullptr;
  std::vector<SlaveClockPlan> slaves;  ///< by position; slaves beyond the end get no signals
  /// The plan for a slave (by the number of its plan) that joins later, called once its description `found` is known;
  /// empty: no signals. Called by the ordinary thread that configures it.
  std::function<Result<SlaveClockPlan>(std::size_t plan, const esi::DeviceDescription& found)> joining{};

  // Settings for tests and unusual lines.
  /// System time minus master's clock when the clocks are set, without `time`.
  std::chrono::nanoseconds epoch{0};
  unsigned latch_rounds = 16;               ///< receive times are averaged over so many frames
  unsigned drift_datagrams = 15'000;        ///< of the static drift compensation
  unsigned drift_datagrams_per_frame = 32;  ///< 2 to 80
  std::chrono::nanoseconds drift_pause = std::chrono::microseconds{250};  ///< between its frames
  /// The static compensation goes on until all clocks are as near as this, but no longer than that beyond its
  /// datagrams.
  std::chrono::nanoseconds drift_window{100};
  /// The longest it goes on beyond its datagrams
  std::chrono::nanoseconds drift_limit = std::chrono::milliseconds{1000};
  std::chrono::nanoseconds start_lead = std::chrono::milliseconds{100};  ///< of the start time, at first
};

/// The clock of one slave, as found and set.
struct SlaveClock {
  bool present = false;                        ///< the slave has a clock
  bool wide = false;                           ///< 64 bits
  bool follows = false;                        ///< it follows the reference clock: frames pass it after that
  double delay_ns = 0.0;                       ///< from the first clock of the line
  DelayQuality quality = DelayQuality::kNone;  ///< of `delay_ns`
  std::uint32_t delay = 0;                     ///< register 0x0928: from the reference clock
  std::uint64_t offset = 0;                    ///< register 0x0920
  SyncSignals signals;                         ///< as planned
  std::uint64_t start = 0;                     ///< register 0x0990 (of a 32-bit clock the lower half)
  double processing_extra_ns = 0.0;            ///< as planned
  /// Register 0x092C at the end of the static compensation.
  std::chrono::nanoseconds difference{0};
};

/// The clocks of a line after bring_up_clocks().
struct LineClocks {
  FollowMode mode = FollowMode::kMasterFollows;  ///< as planned
  std::chrono::nanoseconds period{0};            ///< of the master's cycle
  std::chrono::nanoseconds frame_lead{0};        ///< as planned
  const TimeSource* time = nullptr;              ///< as planned; null: the master's clock
  std::uint16_t reference = 0;                   ///< position
  std::uint16_t station = 0;                     ///< station address of the reference
  std::vector<SlaveClock> slaves;                ///< by position
  /// The master's clock against the reference clock.
  ClockMapping mapping;
  /// SYNC0 of a slave without shift comes at this system time, and every multiple of the common cycle from there.
  std::uint64_t start = 0;
  std::chrono::nanoseconds common_cycle{0};  ///< after which all signals and the master's cycle repeat
  unsigned drift_frames = 0;                 ///< of the static compensation
  unsigned drift_frames_lost = 0;            ///< of `drift_frames`, those that did not come back
};

/// DelayNode::processing_extra_ns of all slaves.
[[nodiscard]] inline std::vector<double> processing_extra(const LineClocks& clocks) {
  std::vector<double> all;
  for (const auto& clock : clocks.slaves) all.push_back(clock.processing_extra_ns);
  return all;
}

}  // namespace driveline::ecat_master::dc
