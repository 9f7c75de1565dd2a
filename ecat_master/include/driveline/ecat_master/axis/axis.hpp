#pragma once

#include <chrono>
#include <cstdint>
#include <limits>
#include <memory>
#include <optional>
#include <span>
#include <string>

#include "driveline/ecat_master/axis/feed_forward.hpp"
#include "driveline/ecat_master/axis/mode_change.hpp"
#include "driveline/ecat_master/axis/profile_objects.hpp"
#include "driveline/ecat_master/axis/setpoint_delay.hpp"
#include "driveline/ecat_master/axis/touch_probe.hpp"
#include "driveline/ecat_master/cia402/cia402.hpp"
#include "driveline/ecat_master/cia402/cyclic_mode.hpp"
#include "driveline/ecat_master/process_data/pdo_configuration.hpp"
#include "driveline/ecat_master/process_data/process_image.hpp"
#include "driveline/snapshot/snapshot.hpp"
#include "driveline/trajectory/motion_limits.hpp"
#include "driveline/trajectory/position_unit.hpp"
#include "driveline/trajectory/profile.hpp"
#include "driveline/trajectory/setpoint.hpp"

namespace driveline::ecat_master {

class AxisCompensation;
struct CompensationSettings;

/// What the other axes do when an axis is missing: its slave exchanges no process data, or has left OP.
enum class LossPolicy : std::uint8_t {
  kStop,      ///< all axes stop by their own quick stop
  kHold,      ///< the others come to rest together, on the path, and wait for it
  kContinue,  ///< the others go on along the path
};

/// Configuration of an axis. Lengths are rad for rotary and m for linear axes, torques Nm or N.
struct AxisConfig {
  /// `slave` of an axis without a drive, a virtual one: it is where its setpoints are, and has no mode but CSP.
  static constexpr std::size_t kNoSlave = std::numeric_limits<std::size_t>::max();

  std::string name;                                            ///< for messages and files
  std::size_t slave = 0;                                       ///< position on the line
  cia402::Mode mode = cia402::Mode::kCyclicPosition;           ///< mode of operation to begin with; see Axis::mode()
  trajectory::AxisKind kind = trajectory::AxisKind::kRotary;   ///< linear: positions in m, forces in N, not rad and Nm
  double increments_per_unit = 1048576.0 / 6.283185307179586;  ///< drive increments per rad or m
  double unit_per_revolution = 0.0;                            ///< rad or m per turn of the motor; 0: not known
  bool scale_assumed = false;  ///< increments_per_unit is a guess: the drive knows better
  /// The axis counts against its drive: positions, velocities, torques, offsets and places of the touch probe have the
  /// other sign there. Everything here is as the axis counts, but `range_min` and `range_max`.
  bool reversed = false;
  /// 6042h, the target of velocity mode, counts in velocity units of the factor group and 604Ch (MSD manual 12.2.2),
  /// not in turns per minute and 604Ch (CiA 402-2).
  bool velocity_by_factors = false;
  /// rad/s or m/s that a count of 6042h stands for, with its sign; 0: not known.
  double velocity_count = 0.0;
  double rated_torque = 2.4;                     ///< Nm or N that 1000 per mille stand for (6076h)
  trajectory::AxisLimits limits{200.0, 2000.0};  ///< for the approach of a path and for stops
  std::optional<double> max_jerk{};              ///< rad/s^3 or m/s^3, of motions that the master plans; none: no limit
  /// Nm or N that the master asks for at most, either way: of 6071h and 60B2h together. What the loops of the drive add
  /// in CSP and CSV is limited in the drive (6072h). None: no limit.
  std::optional<double> max_torque{};
  /// Increments between which positions count, as 607Bh has them: an axis that goes on beyond one end comes back at the
  /// other. Not below each other: all of the 32 bits.
  std::int32_t range_min = 0;
  std::int32_t range_max = 0;  ///< 607Bh:02
  /// After which an endless axis is where it was, rad or m; positions are shown within it, too. None: it has none.
  std::optional<double> modulo{};
  /// Positions, before AxisCommand::kSetPosition, that motions of the axis by itself must not leave (SingleAxes); none:
  /// anywhere.
  std::optional<trajectory::PositionRange> software_limits{};
  /// 6502h of the drive, bit n for mode n + 1; none: not known, every mode is tried.
  std::optional<std::uint32_t> supported_modes{};
  double inertia = 0.0;        ///< kg m^2 or kg moved by the axis, for the torque feed-forward; 0: none
  FeedForward feed_forward{};  ///< what it needs besides the torque of its inertia
  std::chrono::nanoseconds period = std::chrono::microseconds{125};  ///< from one setpoint to the next
  /// The drive adds 60B1h and 60B2h to its targets in CSV, too, as CiA 402-2 says: the feed-forward then goes there in
  /// every mode, the rest into 60FFh and 6071h. False: in CSV and CST the targets have all, and offsets are zero while
  /// the mode changes; but 60B2h is used in every mode if there is a `feed_forward` and the axis begins in CSP or CSV,
  /// where nothing else brings that to the drive.
  bool adds_offsets = false;
  /// The drive tells by bit 12 of its status word that it follows setpoints (CiA 402-2): an axis that is switched on
  /// waits for it, for a drive opens its brake before. False: Operation enabled is enough.
  bool follow_bit = false;
  LossPolicy on_loss = LossPolicy::kStop;  ///< what happens when the drive exchanges no valid process data

  /// Loops closed by the master in CSV and CST, where the drive has no position loop of its own.
  double position_gain_1_s = 20.0;  ///< velocity per position error
  double velocity_gain = 0.0;       ///< CST: torque per velocity error, Nm s/rad or N s/m; above 0 there
  /// CSP: setpoint_delay_cycles() of the drive, for the following error; none: that of a drive that runs free and
  /// joins its setpoints by a spline. In CSV and CST the loop is closed here, with the setpoint and the actual position
  /// of the same cycle.
  std::optional<double> setpoint_delay_cycles{};
  /// CSP: cycles by which the drive's motion lags behind what it is told with the same exchange and uses at once, the
  /// torque offset: that of `feed_forward` waits for so long.
  double offset_delay_cycles = 0.0;
  /// How far an axis may be from its setpoint until that is a fault, rad or m; none: position_tolerance().
  std::optional<double> position_tolerance{};
  /// How far the actual position may be from the setpoint that belongs to it, rad or m, for no longer than
  /// `following_error_timeout`; none: it is not watched here, but by the drive (6065h, 6066h) in its own position loop.
  std::optional<double> following_error_window{};
  std::chrono::nanoseconds following_error_timeout = std::chrono::milliseconds{10};  ///< of `following_error_window`
  /// Unit of its positions in messages and files, not in calculations; null: rad or m.
  const trajectory::PositionUnit* unit = nullptr;
  /// Pitch error and backlash of what lies between drive and axis; null: none. `limits` are those that it leaves
  /// (limits_of_motion()).
  std::shared_ptr<const CompensationSettings> compensation{};

  /// Whether it has no drive. \rtsafe
  [[nodiscard]] bool is_virtual() const noexcept { return slave == kNoSlave; }
  /// Whether `kind` is linear. \rtsafe
  [[nodiscard]] bool linear() const noexcept { return kind == trajectory::AxisKind::kLinear; }
};

/// Unit of the positions of an axis in messages and files.
[[nodiscard]] const trajectory::PositionUnit& position_unit(const AxisConfig& axis) noexcept;

/// AxisConfig::position_tolerance, else the distance at highest velocity in a millisecond, at least 0.05 rad or 1 mm.
/// \rtsafe
[[nodiscard]] double position_tolerance(const AxisConfig& axis) noexcept;

/// Cycles by which the actual position of the axis lags behind its setpoints where the drive closes the position loop;
/// 0 where the master does.
[[nodiscard]] double dead_time_cycles(const AxisConfig& axis) noexcept;

/// Inputs of one axis, decoded; kept from the last valid cycle.
struct AxisInputs {
  std::uint16_t status_word = 0;                                  ///< object 6041h
  std::uint16_t error_code = 0;                                   ///< 603Fh
  std::int8_t mode = 0;                                           ///< 6061h
  snapshot::AxisState state = snapshot::AxisState::kUnavailable;  ///< CiA 402 state out of the status word
  double position = 0.0;                                          ///< rad or m; goes on where the 32 bits end
  double velocity = 0.0;                                          ///< rad/s or m/s
  double torque = 0.0;                                            ///< Nm or N
  double drive_following_error = 0.0;                             ///< as the drive reports it (60F4h); rad or m
  /// What the loops of the drive follow (6062h, 606Bh, 6074h); each not a number where it is not mapped.
  double demand_position = std::numeric_limits<double>::quiet_NaN();  ///< rad or m
  double demand_velocity = std::numeric_limits<double>::quiet_NaN();  ///< rad/s or m/s
  double demand_torque = std::numeric_limits<double>::quiet_NaN();    ///< Nm or N
  std::int64_t digital_inputs = snapshot::kNoDigitalInputs;           ///< 60FDh; kNoDigitalInputs: not mapped
};

/// The process data objects an axis is driven with: three RxPDOs and three TxPDOs of at most 8 bytes each (MSD manual
/// 8.3.4), enough for CSP, CSV and CST without a change of mapping.
[[nodiscard]] const PdoConfiguration& axis_pdo_configuration();

/// One axis in the process image: decodes its inputs, writes its control word and targets.
///
/// Objects that are not mapped are skipped on output and read as zero; a Motion refuses an axis with missing_objects().
/// Belongs to the real-time thread once the cycle runs; everything but the constructor is \rtsafe.
class Axis {
 public:
  /// `place` and `pdos` say where the objects lie in the image.
  Axis(AxisConfig config, const ProcessDataPlace& place, const PdoConfiguration& pdos);
  /// An axis without a drive (AxisConfig::kNoSlave). It answers its commands in the next cycle, whatever the line does.
  explicit Axis(AxisConfig config);
  /// Moved, not copied.
  Axis(Axis&& other) noexcept;
  Axis& operator=(Axis&& other) noexcept;
  ~Axis();

  /// Takes over the inputs; `valid` false: the slave exchanged no valid process data in this cycle. `fresh` false: its
  /// group was not due, and the inputs are those of an earlier one.
  void read_inputs(std::span<const std::byte> image, bool valid, bool fresh = true) noexcept;

  /// The slave has fallen out of OP: it does not take its outputs. Until the next read_inputs().
  void set_unavailable() noexcept { inputs_.state = snapshot::AxisState::kUnavailable; }

  /// Where the axis is when it is enabled, instead of the actual position, and the velocity with which it coasts until
  /// then, rad/s or m/s: where the targets are until it is.
  /// Of one that coasts and may be on by what it was told, it is not corrected faster than the axis may accelerate: its
  /// drive may follow these targets before it has said so.
  void hold_at(double position, double velocity = 0.0) noexcept;
  /// An axis that coasts, and was not seen, has gone on so long.
  void coast_on(double time_s) noexcept {
    if (hold_) *hold_ += hold_velocity_ * time_s;
  }
  /// The setpoint that goes on with the motion of an axis without power: of hold_at(), and as far ahead as the drive
  /// takes to follow a position.
  [[nodiscard]] trajectory::AxisSetpoint held() const noexcept;
  /// Switches the master's position loop of CSV and CST off until the axis is enabled anew, because the actual position
  /// is implausible. Returns the velocity that the loop has added last, from which a stop begins.
  [[nodiscard]] double distrust_position() noexcept;

  /// Writes control word, mode and targets. While the axis is not in Operation enabled the targets are where it is
  /// (held()), so that enabling never starts with a jump, and what holds its weight.
  void write_outputs(std::span<std::byte> image, cia402::Goal goal, bool reset_fault,
                     const trajectory::AxisSetpoint& setpoint) noexcept;

  /// Lets the drive change to another mode. From one cyclic mode to another that is without a step also while the axis
  /// moves (ModeChange), if torque and velocity (6077h, 606Ch) are mapped; on the way to another mode the drive is led
  /// by cyclic setpoints until it shows that. While a drive that has been told may change at any moment, another
  /// request waits until it has (ModeChange::committed()). False, and nothing is changed: the process data lack an
  /// object of that mode or the modes themselves (6060h, 6061h), for CST there is no velocity gain, or the drive does
  /// not have it (supports()). A drive that does not change takes part in the motion as it is; when that is too long,
  /// and what happens then, is the caller's business: set_mode() with the mode before.
  [[nodiscard]] bool set_mode(cia402::Mode mode) noexcept;
  /// Whether set_mode() would do it.
  [[nodiscard]] bool can_change(cia402::Mode mode) const noexcept {
    const bool movable = mode != cia402::Mode::kCyclicTorque || config_.velocity_gain > 0.0;
    return mode == wanted_ || (possible(mode) && supports(mode) && movable && mode_object_ && mode_display_);
  }
  /// Whether the drive has the mode, by AxisConfig::supported_modes.
  [[nodiscard]] bool supports(cia402::Mode mode) const noexcept {
    return (config_.supported_modes.value_or(~0U) & cia402::mode_bit(mode)) != 0;
  }
  /// From now on the torque of the setpoints is all that the drive is told in CST.
  void command_torque() noexcept;
  /// The loops of the master take over an axis that was led by torques; `load` of the last one was not for its
  /// acceleration, and fades.
  void take_over_torque(double load) noexcept;
  /// So many periods have gone by without write_outputs(), in which the axis went on.
  void skip(std::int64_t periods) noexcept;
  /// The torque target of the last write_outputs(), Nm or N.
  [[nodiscard]] double target_torque() const noexcept { return targets_.torque; }
  /// A change of mode is over, but the axis still on its way back to its setpoints.
  [[nodiscard]] bool returning() const noexcept { return changing_ && change_->returning(); }
  /// A change of mode has been asked for, and is not over, or the axis still on its way back to its setpoints.
  [[nodiscard]] bool changing() const noexcept { return changing_ || mode_ != wanted_; }
  /// Positions count as the drive has told the last one: it has a new zero, and its axis is homed.
  void recount() noexcept;
  /// Positions of the axis, rad or m.
  struct Homed {
    double mark = 0.0;
    double setpoint = 0.0;
  };
  /// The master has homed: at its position `mark`, passed in this direction, the axis is called `called`. Both
  /// positions as they count from now on: others where a compensation has waited for this.
  [[nodiscard]] Homed home(const Homed& before, double called, bool forward) noexcept;
  /// A place that the drive has told in increments, near where it stands; rad or m as AxisInputs::position.
  [[nodiscard]] double position_of(std::int32_t increments) const noexcept;
  /// The touch probe of the drive, as far as its objects are mapped.
  [[nodiscard]] TouchProbe& probe() noexcept { return probe_; }
  /// The same, to look at.
  [[nodiscard]] const TouchProbe& probe() const noexcept { return probe_; }
  /// Limits of the movements that the drive makes itself, as far as their objects are mapped.
  [[nodiscard]] ProfileObjects& profile() noexcept { return profile_; }
  /// Mode that the drive is in, or on its way into; that of the last set_mode().
  [[nodiscard]] cia402::Mode mode() const noexcept { return wanted_; }
  /// Mode by which the drive goes on when nothing reaches it any more.
  [[nodiscard]] cia402::Mode mode_in_force() const noexcept { return pending_ ? change_->in_force(mode_) : mode_; }
  /// The drive is in mode(), as 6061h has shown for some exchanges, if it is mapped.
  [[nodiscard]] bool mode_ready() const noexcept { return !pending_ && mode_ == wanted_ && shows_mode(); }
  /// Bits of cia402::command_bit that the control word of an enabled axis gets from now on, besides those of its state.
  /// In the modes in which the drive makes its motion, setpoint position and velocity are written as they are (607Ah,
  /// 60FFh), and take effect as these bits say.
  void set_command_bits(std::uint16_t bits) noexcept { command_bits_ = bits & cia402::command_bit::kAll; }

  /// The configuration given to the constructor. \rtsafe
  [[nodiscard]] const AxisConfig& config() const noexcept { return config_; }
  /// Whether the process data hold all objects that its mode needs (missing_objects()). \rtsafe
  [[nodiscard]] bool complete() const noexcept { return possible(mode_); }
  /// Inputs of the last cycle. \rtsafe
  [[nodiscard]] const AxisInputs& inputs() const noexcept { return inputs_; }
  /// Setpoint that the drive followed when it measured the actual position, minus that; rad or m. 0 while it follows
  /// none. As of the last write_outputs(). \rtsafe
  [[nodiscard]] double following_error() const noexcept { return following_error_; }
  /// Whether it is in Operation enabled, in mode() or on its way into it if 6061h is mapped. \rtsafe
  [[nodiscard]] bool enabled() const noexcept {
    return inputs_.state == snapshot::AxisState::kOperationEnabled && (shows_mode() || pending_ || passing_);
  }
  /// Whether the last outputs had the command to enable: the drive may be on, though its answer has not come.
  /// \rtsafe
  [[nodiscard]] bool told_on() const noexcept {
    return (targets_.control_word & cia402::command::kEnableOperation) == cia402::command::kEnableOperation;
  }
  /// Whether it is enabled(), and has not been told to switch off since. \rtsafe
  [[nodiscard]] bool stays_on() const noexcept { return enabled() && told_on(); }
  /// Whether it stays_on(), and the drive has said since it was enabled that it follows setpoints if it tells that
  /// (AxisConfig::follow_bit). \rtsafe
  [[nodiscard]] bool ready() const noexcept { return stays_on() && (followed_ || !config_.follow_bit); }
  /// Whether the drive reports a fault, or is in Fault reaction active. \rtsafe
  [[nodiscard]] bool fault() const noexcept {
    return inputs_.state == snapshot::AxisState::kFault || inputs_.state == snapshot::AxisState::kFaultReactionActive;
  }
  /// Whether the last status word reports a fault, also while the axis is unavailable.
  [[nodiscard]] bool reports_fault() const noexcept {
    const auto state = cia402::decode_state(inputs_.status_word);
    return state == snapshot::AxisState::kFault || state == snapshot::AxisState::kFaultReactionActive;
  }
  /// Fills everything but cycle, time, axis number, and what only MotionControl::fill() knows.
  void fill(snapshot::AxisSample& sample) const noexcept;

 private:
  struct Targets {
    std::uint16_t control_word = 0;
    double position = 0.0;
    double velocity = 0.0;
    double torque = 0.0;
    double acceleration = 0.0;   ///< of the setpoint
    double feed_velocity = 0.0;  ///< share of the feed-forward in velocity and torque
    double feed_torque = 0.0;
  };
  void be_its_drive() noexcept;
  void write_targets(std::span<std::byte> image) const noexcept;
  [[nodiscard]] double lead_s() const noexcept;
  [[nodiscard]] bool shows_mode() const noexcept {
    return !mode_display_ || inputs_.mode == static_cast<std::int8_t>(mode_);
  }
  [[nodiscard]] bool possible(cia402::Mode mode) const noexcept {
    return (possible_modes_ >> static_cast<unsigned>(mode) & 1U) != 0;
  }
  [[nodiscard]] double followed_setpoint() const noexcept;
  [[nodiscard]] Targets targets_in_change(const trajectory::AxisSetpoint& setpoint) noexcept;
  [[nodiscard]] ModeChange::Measured measured() const noexcept;
  void note_change() noexcept;
  void start_change() noexcept;
  [[nodiscard]] bool set_interpolation(cia402::Mode mode) noexcept;
  [[nodiscard]] std::int32_t wrapped(double increments) const noexcept;
  [[nodiscard]] double of_axis(double drive_position) const noexcept;
  [[nodiscard]] double velocity_of_axis(double drive_velocity) const noexcept;
  void compensate(bool moving, const trajectory::AxisSetpoint& setpoint) noexcept;
  void compare(bool moving) noexcept;
  [[nodiscard]] Targets targets_for(const trajectory::AxisSetpoint& setpoint) noexcept;
  [[nodiscard]] double feed_forward(const trajectory::AxisSetpoint& setpoint) const noexcept;
  void delay_offset() noexcept;
  void limit_torque() noexcept;
  [[nodiscard]] double position_loop(const trajectory::AxisSetpoint& setpoint) const noexcept;
  [[nodiscard]] double velocity_loop(double velocity) noexcept;
  void count(std::int32_t increments) noexcept;

  AxisConfig config_;
  std::uint32_t possible_modes_;  ///< bit of each whose objects are mapped
  cia402::Mode mode_;             ///< that the drive is told, or about to be
  cia402::Mode wanted_;           ///< another one: next
  double scale_;                  ///< increments of the drive per rad or m, with the sign of its direction
  double nm_per_permille_;        ///< likewise; N of linear axes
  bool changing_ = false;         ///< change_ is active
  bool pending_ = false;          ///< and pending
  /// Whether the feed-forward goes out as offset, and the rest of it in the target.
  bool velocity_by_offset_ = false;
  bool torque_by_offset_ = false;
  std::uint16_t command_bits_ = 0;
  bool passing_ = false;   ///< from CSP to interpolated position or back, until the drive shows it
  bool followed_ = false;  ///< the drive has said that it follows setpoints since it was enabled
  std::int64_t range_;     ///< positions until they begin anew
  AxisInputs inputs_;
  Targets targets_;
  SetpointHistory setpoints_;
  SetpointHistory feeds_;       ///< torques of the feed-forward
  bool fresh_ = false;          ///< the inputs are of this cycle
  std::optional<double> hold_;  ///< hold_at()
  double hold_velocity_ = 0.0;  ///< hold_at()
  bool trusted_ = true;         ///< not distrust_position()
  double correction_ = 0.0;     ///< velocity that the position loop adds
  double loop_torque_ = 0.0;    ///< torque that the velocity loop adds
  /// Actual position without the wrap at 32 bits, and as it came.
  std::int64_t count_ = 0;
  std::int32_t last_count_ = 0;
  double following_error_ = 0.0;
  std::optional<PdoEntry<std::uint16_t>> control_word_;           // 6040h
  std::optional<PdoEntry<std::int8_t>> mode_object_;              // 6060h
  std::optional<PdoEntry<std::int32_t>> target_position_;         // 607Ah
  std::optional<PdoEntry<std::int32_t>> interpolation_data_;      // 60C1h:01
  std::optional<PdoEntry<std::int32_t>> target_velocity_;         // 60FFh
  std::optional<PdoEntry<std::int32_t>> velocity_offset_;         // 60B1h
  std::optional<PdoEntry<std::int16_t>> target_torque_;           // 6071h
  std::optional<PdoEntry<std::int16_t>> torque_offset_;           // 60B2h
  std::optional<PdoEntry<std::uint16_t>> status_word_;            // 6041h
  std::optional<PdoEntry<std::int8_t>> mode_display_;             // 6061h
  std::optional<PdoEntry<std::int32_t>> actual_position_;         // 6064h
  std::optional<PdoEntry<std::int32_t>> actual_velocity_;         // 606Ch
  std::optional<PdoEntry<std::int32_t>> following_error_object_;  // 60F4h
  std::optional<PdoEntry<std::int16_t>> actual_torque_;           // 6077h
  std::optional<PdoEntry<std::uint16_t>> error_code_;             // 603Fh
  std::optional<PdoEntry<std::int32_t>> demand_position_;         // 6062h
  std::optional<PdoEntry<std::int32_t>> demand_velocity_;         // 606Bh
  std::optional<PdoEntry<std::int16_t>> demand_torque_;           // 6074h
  std::optional<PdoEntry<std::uint32_t>> digital_inputs_;         // 60FDh
  TouchProbe probe_;                                              // 60B8h to 60BDh
  ProfileObjects profile_;                                        // 6042h, 6081h, 6083h, 6084h
  std::unique_ptr<ModeChange> change_;                            ///< beside what every cycle needs
  std::unique_ptr<AxisCompensation> compensation_;                ///< null: none
};

}  // namespace driveline::ecat_master
