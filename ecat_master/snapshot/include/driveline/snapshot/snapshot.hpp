#pragma once

#include <cstdint>
#include <limits>
#include <type_traits>

/// The fixed-size records of the real-time cycle, which reach their consumers through wait-free rings. All records are
/// trivially copyable and carry SI units: rad, rad/s and Nm for a rotary axis, m, m/s and N for a linear one.
namespace driveline::snapshot {

/// State of the CiA 402 power drive system, as decoded from the status word (CiA 402-2, status word masks).
enum class AxisState : std::uint8_t {
  kNotReadyToSwitchOn,
  kSwitchOnDisabled,
  kReadyToSwitchOn,
  kSwitchedOn,
  kOperationEnabled,
  kQuickStopActive,
  kFaultReactionActive,
  kFault,
  kUnavailable,  ///< the slave does not exchange valid process data
};

/// State of an axis in the sense of PLCopen (Motion Control, part 1: the state diagram).
enum class SampledPlcopenState : std::uint8_t {
  kNone,  ///< all axes of the line are moved together: by a path, a task or a program
  kDisabled,
  kStandstill,
  kHoming,
  kStopping,
  kDiscreteMotion,
  kContinuousMotion,
  kSynchronizedMotion,
  kErrorStop,
};

/// Whether the axis has been homed in this run.
enum class AxisHomed : std::uint8_t {
  kUnknown,  ///< no homing in this run; the drive may still know its position
  kNo,       ///< homing is in progress, or has failed
  kYes,      ///< homed in this run
};

/// AxisSample::digital_inputs of an axis that has no digital inputs.
inline constexpr std::int64_t kNoDigitalInputs = -1;

/// One axis in one cycle.
struct AxisSample {
  std::uint64_t cycle = 0;                    ///< number of the cycle since cyclic operation started
  std::int64_t time_ns = 0;                   ///< grid time of the cycle on the master's clock
  std::uint16_t axis = 0;                     ///< index of the axis in the line description
  std::uint16_t control_word = 0;             ///< 6040h as sent in this cycle
  std::uint16_t status_word = 0;              ///< 6041h as received in this cycle
  std::int8_t mode = 0;                       ///< 6061h mode of operation display
  AxisState state = AxisState::kUnavailable;  ///< CiA 402 state of the drive
  SampledPlcopenState plcopen_state = SampledPlcopenState::kNone;  ///< for axes that are commanded individually
  AxisHomed homed = AxisHomed::kUnknown;                           ///< result of the homing requests of this run
  std::uint16_t error_code = 0;                                    ///< 603Fh; 0 also where it is not mapped
  std::uint32_t reserved = 0;                                      ///< 0
  std::int64_t digital_inputs = kNoDigitalInputs;  ///< 60FDh, 32 bits; kNoDigitalInputs where it is not mapped
  double target_position = 0;                      ///< commanded in this cycle; rad, m for a linear axis
  double actual_position = 0;                      ///< reported by the drive; rad, m for a linear axis
  double target_velocity = 0;                      ///< commanded; rad/s, m/s for a linear axis
  double actual_velocity = 0;                      ///< reported by the drive; rad/s, m/s for a linear axis
  double target_torque = 0;                        ///< commanded; Nm, N for a linear axis
  double actual_torque = 0;                        ///< reported by the drive; Nm, N for a linear axis
  /// Setpoint that the drive followed at the time of `actual_position`, minus that position; rad, m for a linear axis.
  double following_error = 0;
  /// The following error reported by the drive (60F4h), in the same unit; NaN when it is not mapped.
  double drive_following_error = std::numeric_limits<double>::quiet_NaN();
  /// Setpoints of the drive's control loops (6062h, 606Bh, 6074h); each is NaN when it is not mapped.
  double demand_position = std::numeric_limits<double>::quiet_NaN();  ///< rad, m for a linear axis
  double demand_velocity = std::numeric_limits<double>::quiet_NaN();  ///< rad/s, m/s for a linear axis
  double demand_torque = std::numeric_limits<double>::quiet_NaN();    ///< Nm, N for a linear axis
};
static_assert(std::is_trivially_copyable_v<AxisSample>);

/// The line as a whole in one cycle.
struct LineSample {
  std::uint64_t cycle = 0;            ///< number of the cycle, from 0 at the start of the exchange
  std::int64_t time_ns = 0;           ///< grid time of the cycle on the master's clock
  std::int64_t wake_latency_ns = 0;   ///< wake-up after the grid time, missed periods included
  std::int64_t cost_ns = 0;           ///< work of the cycle, from wake-up to the end of the send
  std::int64_t round_trip_ns = 0;     ///< from sending to receiving the frame; 0 when none returned
  std::int64_t dc_difference_ns = 0;  ///< reference clock minus the master's estimate, most recent value
  std::uint32_t missed_periods = 0;   ///< periods skipped before this cycle
  std::uint16_t working_counter = 0;  ///< answers that came; on EtherCAT, the working counters received
  std::uint16_t expected_working_counter =
      0;                        ///< answers that were due; on EtherCAT, the sum over the datagrams, from the FMMUs
  std::uint16_t axes = 0;       ///< number of axes; as many AxisSamples follow with the same cycle number
  bool frame_received = false;  ///< all frames that were due have returned in time
  bool dc_locked = false;       ///< the grid is locked to the reference clock
  float bus_load = 0.0F;        ///< CAN: share of the time since the last cycle in which the bus carried frames; else 0
  std::uint8_t bus_send_errors = 0;     ///< CAN: transmit error counter of the adapter; 0 where it does not tell
  std::uint8_t bus_receive_errors = 0;  ///< CAN: receive error counter of the adapter; 0 where it does not tell
};
static_assert(std::is_trivially_copyable_v<LineSample>);

}  // namespace driveline::snapshot
