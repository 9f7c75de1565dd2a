#pragma once

#include <chrono>
#include <cstdint>
#include <limits>
#include <memory>
#include <optional>
#include <span>
#include <string>

#include "driveline/motion/axis/feed_forward.hpp"
#include "driveline/motion/axis/mode_change.hpp"
#include "driveline/motion/axis/setpoint_delay.hpp"
#include "driveline/motion/cia301/image_place.hpp"
#include "driveline/motion/cia301/pdo_configuration.hpp"
#include "driveline/motion/cia402/cia402.hpp"
#include "driveline/motion/cia402/cyclic_mode.hpp"
#include "driveline/motion/drive/axis_inputs.hpp"
#include "driveline/motion/drive/drive_link.hpp"
#include "driveline/snapshot/snapshot.hpp"
#include "driveline/trajectory/motion_limits.hpp"
#include "driveline/trajectory/position_unit.hpp"
#include "driveline/trajectory/profile.hpp"
#include "driveline/trajectory/setpoint.hpp"

namespace driveline::motion {

class AxisCompensation;
struct CompensationSettings;

/// Reaction of the other axes when an axis is missing: its slave exchanges no process data, or has left OP.
enum class LossPolicy : std::uint8_t {
  kStop,      ///< all axes stop, each by its own quick stop
  kHold,      ///< the other axes come to rest together, on the path, and wait for the missing one
  kContinue,  ///< the other axes continue along the path
};

/// Configuration of an axis. Lengths are rad for rotary and m for linear axes, torques Nm or N.
struct AxisConfig {
  /// `slave` of a virtual axis, which has no drive: its actual position is its setpoint, its only mode CSP.
  static constexpr std::size_t kNoSlave = std::numeric_limits<std::size_t>::max();

  std::string name;        ///< for messages and files
  std::size_t slave = 0;   ///< position on the line
  std::uint8_t drive = 0;  ///< number of its drive there, see object_of_drive()
  /// Initial mode of operation, and that of its setpoints; see Axis::mode(). Drives without CSP have interpolated
  /// position (on CANopen the MSD and the ServoOne: MSD manual 12.2).
  cia402::Mode mode = cia402::Mode::kCyclicPosition;
  trajectory::AxisKind kind = trajectory::AxisKind::kRotary;   ///< linear: m and N instead of rad and Nm
  double increments_per_unit = 1048576.0 / 6.283185307179586;  ///< drive increments per rad or m
  double unit_per_revolution = 0.0;                            ///< rad or m per motor revolution; 0: not known
  bool scale_assumed = false;  ///< increments_per_unit is a guess; the drive holds the real value
  /// The axis counts in the opposite direction of its drive: positions, velocities, torques, offsets and touch probe
  /// positions have the opposite sign there. All values here count as the axis does, except `range_min` and
  /// `range_max`.
  bool reversed = false;
  /// The unit of 6042h, the target of velocity mode, is the velocity unit of the factor group and 604Ch (MSD manual
  /// 12.2.2), not turns per minute and 604Ch (CiA 402-2).
  bool velocity_by_factors = false;
  /// rad/s or m/s per count of 6042h, signed; 0: not known.
  double velocity_count = 0.0;
  double rated_torque = 2.4;                     ///< Nm or N that correspond to 1000 per mille (6076h)
  trajectory::AxisLimits limits{200.0, 2000.0};  ///< for the approach to a path and for stops
  std::optional<double> max_jerk{};  ///< rad/s^3 or m/s^3, for motions that the master plans; none: no limit
  /// Highest torque that the master commands in either direction, Nm or N: the sum of 6071h and 60B2h. What the loops
  /// of the drive add in CSP and CSV is limited in the drive (6072h). None: no limit.
  std::optional<double> max_torque{};
  /// Position range of the drive in increments (607Bh): a position beyond one end continues at the other. `range_min`
  /// not below `range_max`: the full 32 bits.
  std::int32_t range_min = 0;
  std::int32_t range_max = 0;  ///< 607Bh:02
  /// Modulo of an endless axis, rad or m: the distance after which its positions repeat; positions are also displayed
  /// within it. None: no modulo axis.
  std::optional<double> modulo{};
  /// Positions that motions of a single axis (SingleAxes) must not leave, not shifted by AxisCommand::kSetPosition;
  /// none: unlimited.
  std::optional<trajectory::PositionRange> software_limits{};
  /// 6502h of the drive, bit n for mode n + 1; none: not known, every mode is tried.
  std::optional<std::uint32_t> supported_modes{};
  double inertia = 0.0;        ///< kg m^2 or kg moved by the axis, for the torque feed-forward; 0: none
  FeedForward feed_forward{};  ///< torque needed besides that of the inertia
  std::chrono::nanoseconds period = std::chrono::microseconds{125};  ///< time between two setpoints
  /// The drive adds 60B1h and 60B2h to its targets in CSV, too, as CiA 402-2 specifies: then the feed-forward is
  /// written to them in every mode, and the rest to 60FFh and 6071h. False: in CSV and CST the targets contain
  /// everything, and the offsets are zero while the mode changes. Exception: with a `feed_forward`, an axis that starts
  /// in CSP or CSV uses 60B2h in every mode, because nothing else passes the feed-forward to the drive.
  bool adds_offsets = false;
  /// The drive reports by bit 12 of its status word that it follows setpoints (CiA 402-2). After switching the axis on,
  /// the master waits for this bit, because the drive opens its brake first. False: Operation enabled is sufficient.
  bool follow_bit = false;
  /// The bus knows of each setpoint whether it was sent, so that the drive certainly lacks one that counts as not
  /// taken: on CAN, where a frame that was sent has arrived, and one that the adapter refused has never been sent. A
  /// setpoint takes effect in the next period there, with SYNC (CiA 301 7.2.2.2), so that one that was sent before
  /// missed periods has not done so.
  /// False: the drive may have it nevertheless, because an EtherCAT frame may be lost on its way back.
  bool loss_is_certain = false;
  LossPolicy on_loss = LossPolicy::kStop;  ///< reaction when the drive exchanges no valid process data

  /// Loops closed by the master in CSV and CST, where the drive has no position loop of its own.
  double position_gain_1_s = 20.0;  ///< velocity per position error
  double velocity_gain = 0.0;       ///< CST: torque per velocity error, Nm s/rad or N s/m; must be above 0 in CST
  /// CSP: setpoint_delay_cycles() of the drive, for the following error; none: that of a free-running drive with spline
  /// interpolation. In CSV and CST the master closes the loop, with the setpoint and the actual position of the same
  /// cycle.
  std::optional<double> setpoint_delay_cycles{};
  /// CSP: cycles by which the motion of the drive lags behind the torque offset of the same exchange, which takes
  /// effect at once. That of `feed_forward` is delayed by as many cycles.
  double offset_delay_cycles = 0.0;
  /// Distance from the setpoint at which an axis is in fault, rad or m; none: position_tolerance().
  std::optional<double> position_tolerance{};
  /// Largest permitted distance between the actual position and its setpoint, rad or m; it may be exceeded for no
  /// longer than `following_error_timeout`. None: the master does not monitor it; the drive does (6065h, 6066h), in its
  /// own position loop.
  std::optional<double> following_error_window{};
  std::chrono::nanoseconds following_error_timeout = std::chrono::milliseconds{10};  ///< for `following_error_window`
  /// Unit of the axis positions in messages and files, not in calculations; null: rad or m.
  const trajectory::PositionUnit* unit = nullptr;
  /// Pitch error and backlash between drive and axis; null: none. `limits` are the ones left by the compensation
  /// (limits_of_motion()).
  std::shared_ptr<const CompensationSettings> compensation{};

  /// Whether the axis has no drive. \rtsafe
  [[nodiscard]] bool is_virtual() const noexcept { return slave == kNoSlave; }
  /// Whether `kind` is linear. \rtsafe
  [[nodiscard]] bool linear() const noexcept { return kind == trajectory::AxisKind::kLinear; }
};

/// Unit of the positions of an axis in messages and files.
[[nodiscard]] const trajectory::PositionUnit& position_unit(const AxisConfig& axis) noexcept;

/// AxisConfig::position_tolerance if set, else the distance covered in 1 ms at maximum velocity, at least 0.05 rad or
/// 0.001 m. \rtsafe
[[nodiscard]] double position_tolerance(const AxisConfig& axis) noexcept;
/// Highest magnitude of a position in requests, rad or m: 2^42 increments. Beyond it, a double with its 53 bits would
/// resolve less than 1/1024 increment. \rtsafe
[[nodiscard]] double farthest_position(const AxisConfig& axis) noexcept;
/// Whether a position or a distance in requests is within farthest_position(). \rtsafe
[[nodiscard]] bool representable(const AxisConfig& axis, double position) noexcept;

/// Cycles by which the actual position of the axis lags behind its setpoints if the drive closes the position loop; 0
/// if the master does.
[[nodiscard]] double dead_time_cycles(const AxisConfig& axis) noexcept;

/// The process data objects that drive an axis: three RxPDOs and three TxPDOs of at most 8 bytes each (MSD manual
/// 8.3.4), sufficient for CSP, CSV and CST without remapping.
[[nodiscard]] const PdoConfiguration& axis_pdo_configuration();
/// The same for a drive on a CAN bus, where each bit counts: interpolated position and homing. The setpoint (RPDO 2),
/// and status word and position (TPDO 1), are for every SYNC; control word and mode (RPDO 1), and mode display and
/// error code (TPDO 2), for when they change.
[[nodiscard]] const PdoConfiguration& can_axis_pdo_configuration();

/// One axis: unwraps its positions, closes the loops of the master, changes modes, and exchanges with its drive through
/// a DriveLink. A Motion refuses an axis with missing_objects().
/// Used by the real-time thread only once the cycle runs; everything except the constructor is \rtsafe.
class Axis {
 public:
  /// `place` and `pdos` say where the objects lie in the image.
  Axis(AxisConfig config, const ImagePlace& place, const PdoConfiguration& pdos);
  /// A virtual axis (AxisConfig::kNoSlave). It executes its commands in the next cycle, independent of the line.
  explicit Axis(AxisConfig config);
  /// Movable, not copyable.
  Axis(Axis&& other) noexcept;
  Axis& operator=(Axis&& other) noexcept;
  ~Axis();

  /// Decodes the inputs. `valid` false: the slave exchanged no valid process data in this cycle. `fresh` false: the
  /// exchange group of the slave was not due, and the inputs are those of an earlier cycle. `late`: time by which the
  /// frame left after the grid instant, so that the drive measured its values later.
  void read_inputs(std::span<const std::byte> image, bool valid, bool fresh = true,
                   std::chrono::nanoseconds late = {}) noexcept;

  /// Marks the axis as unavailable until the next read_inputs(): its slave has left OP and ignores its outputs.
  void set_unavailable() noexcept { inputs_.state = snapshot::AxisState::kUnavailable; }

  /// Sets the position, rad or m, from which the axis is enabled, in place of the actual position, and the velocity at
  /// which it coasts until then, rad/s or m/s. The targets follow both until the axis is enabled.
  /// Once a switch-on may be in flight (commanded_on()), the correction is limited to max_acceleration: the drive may
  /// follow these targets before it reports that it is on.
  void hold_at(double position, double velocity = 0.0) noexcept;
  /// Advances the position of hold_at() by `time_s` seconds in which the axis coasted without being measured.
  void coast_on(double time_s) noexcept {
    if (hold_) *hold_ += hold_velocity_ * time_s;
  }
  /// Setpoint that continues the motion of an axis without power: that of hold_at(), advanced by the time that the
  /// drive takes to follow a position.
  [[nodiscard]] trajectory::AxisSetpoint held() const noexcept;
  /// Switches the master's position loop of CSV and CST off until the axis is enabled again, because the actual
  /// position is implausible. Returns the velocity that the loop added last; a stop starts from it.
  [[nodiscard]] double disable_position_loop() noexcept;

  /// Writes control word, mode and targets. Until the axis is in Operation enabled, the targets are its present motion
  /// (held()), so that enabling never causes a jump, and the torque that holds its weight.
  void write_outputs(std::span<std::byte> image, cia402::Goal goal, bool reset_fault,
                     const trajectory::AxisSetpoint& setpoint) noexcept;

  /// Starts a change to another mode. Between two cyclic modes the change is bumpless even while the axis moves
  /// (ModeChange), if torque and velocity (6077h, 606Ch) are mapped. During a change to another kind of mode the drive
  /// gets cyclic setpoints until it shows the new mode. A drive that has been commanded may change at any moment, so a
  /// further request waits until it has (ModeChange::committed()). Returns false and changes nothing if the process
  /// data lack an object of the mode or the mode objects themselves (6060h, 6061h), if there is no velocity gain for
  /// CST, or if the drive does not have the mode (supports()). A drive that does not change keeps taking part in the
  /// motion; the caller decides when to stop waiting and calls set_mode() with the previous mode.
  [[nodiscard]] bool set_mode(cia402::Mode mode) noexcept;
  /// Whether set_mode() accepts this mode.
  [[nodiscard]] bool can_change(cia402::Mode mode) const noexcept {
    const bool movable = mode != cia402::Mode::kCyclicTorque || config_.velocity_gain > 0.0;
    return mode == wanted_ || (possible(mode) && supports(mode) && movable && reachable(mode) && drive_.changes_mode());
  }
  /// Whether the drive has the mode, according to AxisConfig::supported_modes.
  [[nodiscard]] bool supports(cia402::Mode mode) const noexcept {
    return (config_.supported_modes.value_or(~0U) & cia402::mode_bit(mode)) != 0;
  }
  /// Cancels a mode change; from now on CST commands the torque of the setpoints only.
  void command_torque() noexcept;
  /// Hands an axis that was commanded by torque over to the loops of the master. `load`: the part of the last torque
  /// that did not accelerate the axis, Nm or N; it fades.
  void take_over_torque(double load) noexcept;
  /// Accounts for `periods` periods without write_outputs(), during which the axis kept moving.
  void skip(std::int64_t periods) noexcept;
  /// The torque target of the last write_outputs(), Nm or N.
  [[nodiscard]] double target_torque() const noexcept { return targets_.torque; }
  /// Whether a mode change is complete but the axis still returns to its setpoints.
  [[nodiscard]] bool returning() const noexcept { return changing_ && change_->returning(); }
  /// Whether a mode change is requested or in progress, or the axis still returns to its setpoints.
  [[nodiscard]] bool changing() const noexcept { return changing_ || mode_ != wanted_; }
  /// Takes the last position of the drive over as it is: the drive has a new zero, and the axis is homed.
  void recount() noexcept;
  /// Positions of the axis before and after homing, rad or m.
  struct Homed {
    double mark = 0.0;
    double setpoint = 0.0;
  };
  /// Completes homing by the master: the position at which the axis passed `before.mark`, in this direction, is named
  /// `called`. Returns both positions as they count from now on; they differ from `before` if a compensation was
  /// waiting for homing.
  [[nodiscard]] Homed home(const Homed& before, double called, bool forward) noexcept;
  /// Whether 607Ah can hold `position`, in drive positions: a target is either within half the range of the drive
  /// around its present position, where it may wrap around, or a number of 32 bits. \rtsafe
  [[nodiscard]] bool holds_target(double position) const noexcept;
  /// Converts a position that the drive reported in increments, near its present position, to rad or m, as
  /// AxisInputs::position.
  [[nodiscard]] double position_of(std::int32_t increments) const noexcept;
  /// The drive: requests to it, and what its process data contain. In modes in which the drive generates the motion,
  /// setpoint position and velocity are written unchanged and take effect by requests.
  [[nodiscard]] DriveLink& drive() noexcept { return drive_; }
  /// The drive, read-only.
  [[nodiscard]] const DriveLink& drive() const noexcept { return drive_; }
  /// Mode that the drive is in or is changing to: that of the last set_mode().
  [[nodiscard]] cia402::Mode mode() const noexcept { return wanted_; }
  /// Mode in which the drive continues if no frame reaches it any more.
  [[nodiscard]] cia402::Mode mode_in_force() const noexcept { return pending_ ? change_->in_force(mode_) : mode_; }
  /// Whether the drive is in mode(); 6061h, if mapped, has shown it for several exchanges.
  [[nodiscard]] bool mode_ready() const noexcept { return !pending_ && mode_ == wanted_ && shows_mode(); }
  /// The configuration given to the constructor. \rtsafe
  [[nodiscard]] const AxisConfig& config() const noexcept { return config_; }
  /// Whether the process data contain all objects that the mode needs (missing_objects()). \rtsafe
  [[nodiscard]] bool complete() const noexcept { return possible(mode_); }
  /// Number of cycles from one exchange with the drive to the next, at least 1. \rtsafe
  [[nodiscard]] std::uint32_t divider() const noexcept { return divider_; }
  /// Inputs of the last cycle. \rtsafe
  [[nodiscard]] const AxisInputs& inputs() const noexcept { return inputs_; }
  /// The setpoint that the drive followed when it measured the actual position, minus that position; rad or m. Both are
  /// of the instant at which the frame passed the drive, also when the frame was late. 0 while it follows none. Updated
  /// by write_outputs(). \rtsafe
  [[nodiscard]] double following_error() const noexcept { return following_error_; }
  /// Whether the axis is in Operation enabled and, if 6061h is mapped, in mode() or changing to it. \rtsafe
  [[nodiscard]] bool enabled() const noexcept {
    return inputs_.state == snapshot::AxisState::kOperationEnabled && (shows_mode() || pending_ || passing_);
  }
  /// Whether the last outputs commanded Operation enabled: the drive may be on although it has not confirmed yet.
  /// \rtsafe
  [[nodiscard]] bool commanded_on() const noexcept { return drive_.commanded_on(); }
  /// Whether the axis is enabled() and has not been commanded off since. \rtsafe
  [[nodiscard]] bool stays_on() const noexcept { return enabled() && commanded_on(); }
  /// Whether the axis stays_on() and, if it has AxisConfig::follow_bit, the drive has reported since it was enabled
  /// that it follows setpoints. \rtsafe
  [[nodiscard]] bool ready() const noexcept { return stays_on() && (followed_ || !config_.follow_bit); }
  /// Whether the drive reports a fault, or is in Fault reaction active. \rtsafe
  [[nodiscard]] bool fault() const noexcept {
    return inputs_.state == snapshot::AxisState::kFault || inputs_.state == snapshot::AxisState::kFaultReactionActive;
  }
  /// Whether the last status word reports a fault, even while the axis is unavailable.
  [[nodiscard]] bool reports_fault() const noexcept {
    const auto state = drive_.reported_state();
    return state == snapshot::AxisState::kFault || state == snapshot::AxisState::kFaultReactionActive;
  }
  /// Fills all fields except cycle, time, axis number and the fields known only to MotionControl::fill().
  void fill(snapshot::AxisSample& sample) const noexcept;

 private:
  struct Targets {
    double position = 0.0;
    double velocity = 0.0;
    double torque = 0.0;
    double acceleration = 0.0;   ///< acceleration of the setpoint
    double feed_velocity = 0.0;  ///< part of `velocity` that is feed-forward
    double feed_torque = 0.0;
  };
  void simulate_drive() noexcept;
  void write_drive(std::span<std::byte> image, cia402::Goal goal, bool reset_fault) noexcept;
  [[nodiscard]] double lead_s() const noexcept;
  [[nodiscard]] bool shows_mode() const noexcept {
    return !drive_.shows_mode() || inputs_.mode == static_cast<std::int8_t>(mode_);
  }
  [[nodiscard]] bool possible(cia402::Mode mode) const noexcept {
    return config_.is_virtual() ? mode == cia402::Mode::kCyclicPosition : drive_.possible(mode);
  }
  [[nodiscard]] bool reachable(cia402::Mode mode) const noexcept;
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
  std::uint32_t divider_;  ///< the drive is exchanged in every n-th cycle
  cia402::Mode mode_;      ///< mode commanded to the drive, or about to be
  cia402::Mode wanted_;    ///< requested mode; differs from mode_ while a change waits
  double scale_;           ///< increments of the drive per rad or m, signed by its direction
  bool changing_ = false;  ///< change_ is active
  bool pending_ = false;   ///< change_ is pending: the drive may be in either mode
  /// Whether the feed-forward is written to the offset object and only the rest to the target.
  bool velocity_by_offset_ = false;
  bool torque_by_offset_ = false;
  bool passing_ = false;   ///< changing between CSP and interpolated position; ends when the drive shows it
  bool followed_ = false;  ///< since it was enabled, the drive has reported that it follows setpoints
  std::int64_t range_;     ///< number of increments until positions wrap
  AxisInputs inputs_;
  Targets targets_;
  SetpointHistory setpoints_;
  SetpointHistory feeds_;       ///< torques of the feed-forward, Nm or N
  bool fresh_ = false;          ///< the inputs are from this cycle
  double late_cycles_ = 0.0;    ///< lateness of their frame, in cycles
  std::optional<double> hold_;  ///< position set by hold_at()
  double hold_velocity_ = 0.0;  ///< velocity set by hold_at()
  bool trusted_ = true;         ///< false after disable_position_loop()
  double correction_ = 0.0;     ///< velocity that the position loop adds, rad/s or m/s
  double loop_torque_ = 0.0;    ///< torque that the velocity loop adds, Nm or N
  /// Actual position in increments, unwrapped and as received.
  std::int64_t count_ = 0;
  std::int32_t last_count_ = 0;
  double following_error_ = 0.0;
  DriveLink drive_;
  std::unique_ptr<ModeChange> change_;              ///< on the heap, so that the data of every cycle stay compact
  std::unique_ptr<AxisCompensation> compensation_;  ///< null: no compensation
};

}  // namespace driveline::motion
