#include "driveline/slaves/msd/msd_drive.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "driveline/esi/sii.hpp"
#include "driveline/slaves/msd/device_layout.hpp"
#include "driveline/slaves/msd/msd_values.hpp"
#include "driveline/wire/endian.hpp"

namespace driveline::slaves::msd {
namespace {

using std::chrono::nanoseconds;
using wire::AlState;
using wire::AlStatusCode;

/// From the amplitude of a phase voltage to volts rms between phases, as P 312 counts them.
const double kLineRms = std::sqrt(1.5);
constexpr std::uint16_t kSoftwareVersionIndex = 0x100A;
constexpr std::uint16_t kMessagesIndex = 0x2000 + 33;  ///< P 33
constexpr std::uint16_t kWarningTexts = 8;             ///< P 33[1-8]
constexpr std::int16_t kJerkLimited = 3;               ///< 6086h
constexpr std::uint16_t kThermalOverload = 1;          ///< P 735
constexpr std::uint64_t kStepsPerMs = 16;

constexpr double kOvercurrentShare = 2.0;  ///< of the current of the peak torque, ours
constexpr std::uint8_t kBootUp = 0;        ///< P 2060
/// A motor that nobody watched for longer (supply off) has come to rest meanwhile.
constexpr nanoseconds kMaxCatchUp = std::chrono::seconds{10};

/// Network states of P 2060 (MSD manual Table 7.4).
constexpr std::uint8_t nmt_state(AlState state) noexcept {
  switch (state) {
    case AlState::kInit:
      return 1;
    case AlState::kPreOp:
      return 127;
    case AlState::kSafeOp:
      return 4;
    case AlState::kOp:
      return 5;
    default:
      return 0;
  }
}

/// The codes of a loss of synchronisation (ETG.1020, AL status codes).
constexpr bool is_sync_error(AlStatusCode code) noexcept {
  switch (code) {
    case AlStatusCode::kSynchronizationError:
    case AlStatusCode::kFatalSyncError:
    case AlStatusCode::kNoSyncError:
    case AlStatusCode::kPllError:
    case AlStatusCode::kDcSyncIoError:
    case AlStatusCode::kDcSyncTimeout:
      return true;
    default:
      return false;
  }
}

DeviceProfile make_profile(const MsdParameters& parameters) {
  using Use = SyncManagerLayout::Use;
  auto description = eeprom_description(parameters.variant);
  description.serial_number = parameters.serial_number;
  DeviceProfile profile;
  profile.sii_image = esi::encode_sii(esi::make_sii(description));
  profile.bootstrap_mailboxes = {
      {Use::kMailboxOut, kMailboxOutStart, kMailboxMinSize, kMailboxSize, kMailboxSize},
      {Use::kMailboxIn, kMailboxInStart, kMailboxMinSize, kMailboxSize, kMailboxSize},
  };
  profile.sync_managers = {
      {Use::kMailboxOut, kMailboxOutStart, kMailboxMinSize, kMailboxSize, kMailboxSize},
      {Use::kMailboxIn, kMailboxInStart, kMailboxMinSize, kMailboxSize, kMailboxSize},
      {Use::kOutputs, kOutputsStart, 0, kMaxProcessData, 0},
      {Use::kInputs, kInputsStart, 0, kMaxProcessData, 0},
  };
  return profile;
}

}  // namespace

MsdDrive::MsdDrive(const MsdParameters& parameters)
    : parameters_(parameters),
      profile_(make_profile(parameters)),
      dictionary_(dictionary_table(parameters.variant)),
      stored_(dictionary_table(parameters.variant)),
      coe_(dictionary_, *this, {.fill_sign = true}),  // MSD manual Table 8.3
      mailbox_(std::array<MailboxProtocol*, 1>{&coe_}, kMailboxSize),
      motion_(parameters.motor, parameters.initial_position_rad),
      dc_link_(parameters.dc_link, parameters.dc_link_volts),
      thermal_(parameters.thermal),
      fault_text_(dictionary_.table().find(kMessagesIndex, 0)->slot),
      warning_text_(dictionary_.table().find(kMessagesIndex, 1)->slot) {
  parameters_.motor = motion_.motor().parameters();
  parameters_.controller = parameters.controller.sanitized();
  pdo_limits_.even_bytes = firmware() < facts(parameters_.variant).odd_pdos_since;
  motion_.set_dc_link_voltage(dc_link_.volts());
  overcurrent_a_ = kOvercurrentShare * motion_.motor().rated_characteristic().max_current_a;
  write_device_facts(stored_);
  load_stored_parameters();
  restart();
}

/// A file that cannot be used leaves the factory settings and a fault that stays until the parameters are saved.
void MsdDrive::load_stored_parameters() {
  parameter_file_good_ = true;
  if (parameters_.parameter_file.empty()) return;
  const auto loaded = load_parameter_file(parameters_.parameter_file, stored_);
  if (!loaded) parameter_file_error_ = loaded.error();
  parameter_file_good_ = loaded.has_value();
}

/// Values that belong to this drive rather than to the type: identity, motor, controller.
void MsdDrive::write_device_facts(ObjectDictionary& dictionary) const {
  const auto& motor = parameters_.motor;
  const auto& controller = parameters_.controller;
  const auto real = [&](Value value, double number) { dictionary.set(value, static_cast<float>(number)); };
  dictionary.set(kSerialNumber, parameters_.serial_number);
  dictionary.text(dictionary.table().find(kSoftwareVersionIndex, 0)->slot) = firmware().text();
  // A variant without the object has no such limit.
  if (dictionary.table().object(0x607F).empty()) dictionary.set(kMaxProfileVelocity, 0xFFFFFFFFU);
  dictionary.text(dictionary.table().find(0x2003, 0)->slot) = parameters_.name.substr(0, 100);
  dictionary.set(kMotorRatedCurrent, saturate<std::uint32_t>(motor.rated_current_a * 1e3));
  dictionary.set(kMotorRatedTorque, saturate<std::uint32_t>(motor.rated_torque_nm * 1e3));
  dictionary.set(kEncoderIncrements, motor.encoder_increments);
  dictionary.set(kVelocityEncoderIncrements, motor.encoder_increments);
  dictionary.set(kFeed, motor.encoder_increments);
  real(kVelocityGain, controller.velocity_gain_nm_s * kRpm);
  real(kVelocityReset, controller.velocity_reset_s * 1e3);
  real(kVelocityFilter, controller.velocity_filter_s * 1e3);
  real(kPositionGain, controller.position_gain_per_s * 60.0);
  real(kTotalInertia, motor.inertia_kg_m2);
  const auto characteristic = motion_.motor().rated_characteristic();
  real(kBoostVoltage, characteristic.boost_v * kLineRms);
  real(kNominalVoltage, characteristic.nominal_v * kLineRms);
  real(kNominalFrequency, characteristic.nominal_hz);
  const double rated_hz = motor.rated_speed_rad_s * motor.pole_pairs / (2.0 * std::numbers::pi);
  real(kMotorRatedFrequency, rated_hz);
  real(kOverloadRatedFrequency, rated_hz);
  dictionary.set(kMaxMotorSpeed, saturate<std::uint32_t>(motor.max_speed_rad_s / kRpm));
  real(kMotorRatedCurrentA, motor.rated_current_a);
  real(kMotorRatedTorqueNm, motor.rated_torque_nm);
  real(kMotorInertia, motor.inertia_kg_m2);
  dictionary.set(kMotorPolePairs, motor.pole_pairs);
}

bool MsdDrive::store_parameters() {
  const bool factory = factory_reset_pending_;
  if (factory) {
    stored_.reset();
    write_device_facts(stored_);
    factory_reset_pending_ = false;
  } else {
    stored_.copy_backup_values(dictionary_);
  }
  stored_are_factory_ = factory;
  save_left_ = parameters_.save_time;
  if (parameters_.parameter_file.empty()) return true;
  const auto saved = save_parameter_file(parameters_.parameter_file, stored_);
  if (!saved) parameter_file_error_ = saved.error();
  parameter_file_good_ = saved.has_value();
  if (!saved) raise(Fault::kParameterList);
  return parameter_file_good_;
}

void MsdDrive::restart() {
  enter_al_state(AlState::kInit);
  dictionary_.reset();
  write_device_facts(dictionary_);
  dictionary_.copy_backup_values(stored_);
  power_ = PowerStateMachine{};
  fault_.reset();
  modes_.reset();
  last_control_word_ = 0;
  settings_changed_ = true;
  factory_reset_pending_ = false;
  following_error_ = false;
  brake_open_ = false;
  terminals_.clear_outputs();
  warnings_ = 0;
  probe_ = {};
  start_left_ =
      std::exchange(stored_are_factory_, false) ? parameters_.factory_start_up_time : parameters_.start_up_time;
  save_left_ = nanoseconds{0};
  shown_since_ = running_time();
  build_process_data();
  initialise_control_ = true;
  apply_settings();
  follow_brake_output();
  motion_.restart_encoder();
  motion_.select(MotionCommand::kOff, MotionSource::kNone, false);
  publish();
  if (!parameter_file_good_) raise(Fault::kParameterList);
  if (!eeprom_good_) raise(Fault::kEepromData);
}

/// The self-resetting commands: 200Bh sub 1 is 0 again when the data have been saved (MSD manual 7.5.3).
void MsdDrive::finish_commands() noexcept {
  if (save_left_.count() <= 0) return;
  save_left_ -= kProcessDataPeriod;
  if (save_left_.count() <= 0) dictionary_.set(kSaveParameters, 0U);
}

nanoseconds MsdDrive::process_data_period() const noexcept {
  return kProcessDataPeriod;
}

void MsdDrive::build_process_data() noexcept {
  rx_map_.build(dictionary_, kOutputsSyncManager, pdo_limits_);
  tx_map_.build(dictionary_, kInputsSyncManager, pdo_limits_);
}

/// Settings act as if they had come in an SDO. A device parameter whose value an SDO would refuse keeps the one it has.
void MsdDrive::decode_outputs(std::span<const std::byte> data) noexcept {
  const auto fields = rx_map_.fields();
  const auto is_setting = [](const PdoMap::Field& field) { return (field.row->access & access::kBackup) != 0; };
  std::array<std::uint64_t, PdoMap::kDefaultFields> before{};
  for (std::size_t i = 0; i < fields.size(); ++i) before[i] = dictionary_.get<std::uint64_t>(fields[i].slot);
  rx_map_.decode(data, dictionary_);
  for (std::size_t i = 0; i < fields.size(); ++i) {
    const EntryRow& row = *fields[i].row;
    const std::uint64_t raw = dictionary_.get<std::uint64_t>(row.slot);
    if (!is_setting(fields[i]) || raw == before[i]) continue;
    const bool parameter = row.index < 0x6000;
    const bool refused = parameter && (!check_range(row, raw) || !accept(row, raw));
    if (refused) dictionary_.set(row.slot, before[i]);
    if (!refused) written(row);
  }
}

std::size_t MsdDrive::process_data_size(std::size_t sync_manager) const noexcept {
  if (sync_manager == kOutputsSyncManager) return rx_map_.size();
  return sync_manager == kInputsSyncManager ? tx_map_.size() : 0;
}

void MsdDrive::enter_al_state(AlState state) noexcept {
  al_state_ = state;
  dictionary_.set(kNmtState, starting() ? kBootUp : nmt_state(state));
  if (state == AlState::kInit) mailbox_.reset();
  rhythm_ = {};
}

/// BOOT to INIT restarts the device (MSD manual 9.2, transition BI).
AlStatusCode MsdDrive::transition(AlState from, AlState to) noexcept {
  if (from == AlState::kBootstrap) restart();
  if (to == AlState::kOp && !timing_valid()) {
    raise(Fault::kInvalidConfiguration);
    return AlStatusCode::kInconsistentSettings;
  }
  if (to == AlState::kOp && !sync0_matches()) {
    raise(Fault::kInvalidConfiguration);
    return AlStatusCode::kDcInvalidSyncCycleTime;
  }
  enter_al_state(to);
  if (to == AlState::kOp) dictionary_.set(kSyncError, std::uint8_t{0});
  if (from == AlState::kOp && power_.power_on()) raise(Fault::kMissingOutputs);
  return AlStatusCode::kNoError;
}

/// Er 14 02 is "wrong EEPROM data" and "unsupported communication controller" (MSD manual 5.3.3): a content that cannot
/// be loaded, or that is another device's.
void MsdDrive::eeprom_loaded(std::span<const std::byte> image, bool valid) noexcept {
  constexpr std::size_t kVendor = 0x10;  // bytes in the EEPROM (ETG.1000.6 Table 16)
  constexpr std::size_t kProduct = 0x14;
  const bool own = valid && image.size() >= kProduct + sizeof(std::uint32_t) &&
                   wire::load_le<std::uint32_t>(image.subspan(kVendor)) == kVendorId &&
                   wire::load_le<std::uint32_t>(image.subspan(kProduct)) == facts(parameters_.variant).product_code;
  eeprom_good_ = own;
  if (!own) raise(Fault::kEepromData);
}

void MsdDrive::fall_back(AlState from, AlState to, AlStatusCode reason) noexcept {
  enter_al_state(to);
  if (from != AlState::kOp) return;
  dictionary_.set(kSyncError, std::uint8_t{is_sync_error(reason)});
  raise(reason == AlStatusCode::kSyncManagerWatchdog ? Fault::kEtherCatWatchdog : Fault::kLocalError);
}

/// SYNC0 in multiples of 125 us (MSD manual 9.1). 1C32h:01 = 2 insists on SYNC0, 1 on process data in each setpoint
/// cycle; 0, its default, takes what is there.
SyncDemand MsdDrive::sync_demand() const noexcept {
  SyncDemand demand;
  const auto type = static_cast<SyncType>(dictionary_.get<std::uint16_t>(kSyncTypeOutputs));
  if (type != SyncType::kFreeRun) demand.type = type;
  if (type == SyncType::kSmEvent)
    demand.cycle = nanoseconds{std::llrint(dictionary_.get<float>(kReferenceCycle) * 1e6)};
  demand.time_base = demand.min_cycle = kProcessDataPeriod;
  demand.error_limit = dictionary_.get<std::uint16_t>(kSyncErrorLimit);
  return demand;
}

/// The control steps lie half a step beside SYNC0, so that none comes now before and now behind it.
void MsdDrive::sync_event(SyncSignal signal, nanoseconds time) noexcept {
  if (signal != SyncSignal::kSync0) return;
  sync0_period_ = time - std::exchange(last_sync0_, time);
  if (next_step_) next_step_ = time + kControlStep / 2;
}

void MsdDrive::sync_margin(const SyncMargin& margin) noexcept {
  dictionary_.set(kSyncEventsMissed, static_cast<std::uint16_t>(std::min<std::uint64_t>(margin.missed, 0xFFFF)));
  if (margin.pulses == 0) return;
  dictionary_.set(kSyncDistanceMin, static_cast<std::uint32_t>(margin.shortest.count()));
  dictionary_.set(kSyncDistanceMax, static_cast<std::uint32_t>(margin.longest.count()));
}

void MsdDrive::write_outputs(std::size_t sync_manager, std::span<const std::byte> data) noexcept {
  if (sync_manager != kOutputsSyncManager) return;
  decode_outputs(data);
  watch_fault_reset();
  rhythm_.sample(motion_.settings().steps_per_setpoint);
  apply_setpoints();
}

void MsdDrive::read_inputs(std::size_t sync_manager, std::span<std::byte> data) noexcept {
  if (sync_manager == kInputsSyncManager) tx_map_.encode(dictionary_, data);
}

/// For the mode that 6060h asks for: what comes together with a new mode is meant for that one.
Setpoints MsdDrive::setpoints() const noexcept {
  const auto wanted = static_cast<OperationMode>(dictionary_.get<std::int8_t>(kMode));
  const OperationMode mode = ModeControl::supported(wanted) ? wanted : modes_.mode();
  const bool interpolated = mode == OperationMode::kInterpolatedPosition;
  return {dictionary_.get<std::int32_t>(interpolated ? kInterpolationData : kTargetPosition),
          dictionary_.get<std::int32_t>(kTargetVelocity), dictionary_.get<std::int16_t>(kTargetTorque),
          dictionary_.get<std::int32_t>(kVelocityOffset), dictionary_.get<std::int16_t>(kTorqueOffset)};
}

void MsdDrive::apply_setpoints() noexcept {
  if (references_from_bus()) motion_.set(setpoints());
}

std::uint32_t MsdDrive::steps_per_setpoint() const noexcept {
  const double period_s = dictionary_.get<std::uint8_t>(kInterpolationPeriodValue) *
                          std::pow(10.0, dictionary_.get<std::int8_t>(kInterpolationPeriodIndex));
  return std::max(saturate<std::uint32_t>(period_s / kControlStepS), 1U);
}

/// P 306 and 60C2h must tell the same cycle (MSD manual 7.4.2), a multiple of 125 us (9.1).
bool MsdDrive::timing_valid() const noexcept {
  const std::int64_t cycle_ns = std::llrint(dictionary_.get<float>(kReferenceCycle) * 1e6);
  std::int64_t period_ns = dictionary_.get<std::uint8_t>(kInterpolationPeriodValue);
  for (auto exponent = dictionary_.get<std::int32_t>(kInterpolationPeriodIndex); exponent > -9; --exponent)
    period_ns *= 10;
  return cycle_ns == period_ns && period_ns % kProcessDataPeriod.count() == 0;
}

/// Setpoints come every SYNC0 or, of a line whose drives have process data less often, every so many of them.
bool MsdDrive::sync0_matches() const noexcept {
  constexpr int kShare = 8;  // of a period, for clocks that differ
  const bool running = next_step_ && sync0_period_.count() > 0 && *next_step_ - last_sync0_ < 2 * sync0_period_;
  if (!running) return true;
  const nanoseconds cycle{std::llrint(dictionary_.get<float>(kReferenceCycle) * 1e6)};
  const auto pulses = (cycle + sync0_period_ / 2) / sync0_period_;
  return pulses > 0 && std::chrono::abs(cycle - pulses * sync0_period_) <= sync0_period_ / kShare;
}

void MsdDrive::apply_settings() noexcept {
  settings_changed_ = false;
  const auto real = [this](Value value) { return static_cast<double>(dictionary_.get<float>(value)); };
  const auto number = [this](Value value) { return static_cast<double>(dictionary_.get<std::uint32_t>(value)); };
  const auto& motor = parameters_.motor;
  MotionSettings s;
  // Changed units count from the next start of the control on (MSD manual 10.3).
  s.scaling = initialise_control_ ? Scaling::from(dictionary_, motor.encoder_increments) : motion_.settings().scaling;
  initialise_control_ = false;
  apply_motor_data(s);
  s.range = {dictionary_.get<std::int32_t>(kRangeMin), dictionary_.get<std::int32_t>(kRangeMax)};
  s.controller.position_gain_per_s = real(kPositionGain) / 60.0;
  s.controller.velocity_gain_nm_s = real(kVelocityGain) / kRpm * real(kVelocityGainScale) * 1e-2;
  s.controller.velocity_reset_s = real(kVelocityReset) * 1e-3;
  s.controller.velocity_filter_s = real(kVelocityFilter) * 1e-3;
  s.controller.max_velocity_rad_s = number(kMaxMotorSpeed) * kRpm;
  s.controller.max_torque_nm =
      std::min(motor.peak_torque_nm / s.torque_per_demand, number(kMaxTorque) * 1e-3 * s.rated_torque_nm);
  s.method = static_cast<FineInterpolator::Method>(dictionary_.get<std::uint8_t>(kInterpolationType));
  s.steps_per_setpoint = steps_per_setpoint();
  s.speed_feed_forward = real(kSpeedFeedForwardScale) * 1e-2;
  s.torque_feed_forward = real(kTorqueFeedForwardScale) * 1e-2;
  s.external_speed_feed_forward = dictionary_.get<std::uint16_t>(kSpeedFeedForwardSource) != 0;
  s.external_torque_feed_forward = dictionary_.get<std::uint16_t>(kTorqueFeedForwardSource) != 0;
  s.feed_forward_inertia_kg_m2 = real(kTotalInertia);
  s.slow_down_rad_s2 = number(kProfileDeceleration) * s.scaling.acceleration_rad_s2;
  s.quick_stop_rad_s2 = number(kQuickStopDeceleration) * s.scaling.acceleration_rad_s2;
  s.voltage_frequency = motion_.motor().rated_characteristic();
  s.voltage_frequency.boost_v = real(kBoostVoltage) / kLineRms;
  s.voltage_frequency.nominal_v = real(kNominalVoltage) / kLineRms;
  s.voltage_frequency.nominal_hz = real(kNominalFrequency);
  s.voltage_frequency.max_current_a =
      std::numbers::sqrt2 * s.rated_current_a * s.controller.max_torque_nm / s.rated_torque_nm;
  s.jerk_time_s = dictionary_.get<std::int16_t>(kMotionProfileType) == kJerkLimited ? real(kJerkTime) * 1e-3 : 0.0;
  s.standstill_rad_s = real(kStandstillWindow) * kRpm;
  s.position_min = dictionary_.get<std::int32_t>(kPositionLimitMin);
  s.position_max = dictionary_.get<std::int32_t>(kPositionLimitMax);
  s.position_limited = s.position_min < s.position_max;
  const bool external_spline = s.method == FineInterpolator::Method::kExternal;
  if (facts(parameters_.variant).external_feed_forward_needs_spline) {
    s.external_speed_feed_forward = s.external_speed_feed_forward && external_spline;
    s.external_torque_feed_forward = s.external_torque_feed_forward && external_spline;
  } else if (external_spline) {
    // The controller sends speed and torque with every position (MSD manual Table 12.16).
    s.external_speed_feed_forward = s.external_torque_feed_forward = true;
  }
  motion_.configure(s);
  terminals_.configure(dictionary_);
  dc_link_limit_volts_ = real(kUndervoltageLimit);
  overload_limits_ = {dictionary_.get<std::uint16_t>(kOverloadType) == kThermalOverload,
                      real(kOverloadTimeConstant),
                      real(kOverloadRated) * 1e-2,
                      real(kOverloadStandstill) * 1e-2,
                      real(kOverloadMiddle) * 1e-2,
                      real(kOverloadMiddleFrequency),
                      real(kOverloadRatedFrequency),
                      s.rated_current_a / motor.rated_current_a};
}

/// P 457 and P 460 are what the drive believes about its motor: it asks for the current that by them makes the torque.
void MsdDrive::apply_motor_data(MotionSettings& s) noexcept {
  const auto& motor = parameters_.motor;
  s.rated_current_a = dictionary_.get<float>(kMotorRatedCurrentA);
  s.rated_torque_nm = dictionary_.get<float>(kMotorRatedTorqueNm);
  s.torque_per_demand = (s.rated_current_a / motor.rated_current_a) / (s.rated_torque_nm / motor.rated_torque_nm);
  dictionary_.set(kMotorRatedCurrent, saturate<std::uint32_t>(s.rated_current_a * 1e3));
  dictionary_.set(kMotorRatedTorque, saturate<std::uint32_t>(s.rated_torque_nm * 1e3));
}

void MsdDrive::advance(nanoseconds now) noexcept {
  if (!next_step_) {
    next_step_ = now + kControlStep;
    evaluate_switches();
    start_scripts(now);
  }
  if (now - *next_step_ > kMaxCatchUp) *next_step_ += (now - *next_step_ - kMaxCatchUp) / kControlStep * kControlStep;
  bool stepped = false;
  for (; *next_step_ <= now; *next_step_ += kControlStep) {
    const bool process_data_cycle = steps_ % 2 == 0;
    if (process_data_cycle) power_step();
    if (modes_.step_homing(terminals_.signals(), motion_, parameters_.homing_time_out)) raise(Fault::kHoming);
    control_touch_probe();
    rhythm_.step();
    follow_brake_output();
    motion_.step(brake_closed());
    evaluate_switches();
    if (const auto index = motion_.motor().index_pulse()) probe_.zero_pulse(shown_position(*index));
    apply_scheduled_inputs();
    if (script_due_ <= *next_step_) follow_scripts();
    terminals_.step_outputs({dictionary_.get<std::uint32_t>(kPhysicalOutputs),
                             dictionary_.get<std::uint32_t>(kOutputMask), brake_open_,
                             (status() & status_word::kInternalLimit) != 0, steps_ % kStepsPerMs == 0});
    if (process_data_cycle) {
      monitor_current();
      monitor_following_error();
      monitor_limit_switches();
      if (steps_ % kStepsPerMs == 0) monitor_setpoint_cycle();
      finish_commands();
    }
    if (steps_ % kStepsPerMs == 0) monitor_protection();
    ++steps_;
    stepped = true;
  }
  if (stepped) publish();
}

std::uint16_t MsdDrive::status() const noexcept {
  return dictionary_.get<std::uint16_t>(kStatusWord);
}

void MsdDrive::publish() noexcept {
  const auto torque = saturate<std::int16_t>(motion_.torque_permille());
  dictionary_.set(kStatusWord, status_word());
  dictionary_.set(kNmtState, starting() ? kBootUp : nmt_state(al_state_));
  dictionary_.set(kModeDisplay, static_cast<std::int8_t>(modes_.mode()));
  const PositionRange& range = motion_.settings().range;
  if (!position_held_) dictionary_.set(kPositionActual, range.wrap(motion_.position() + position_error_));
  dictionary_.set(kPositionDemand, range.wrap(std::llrint(motion_.position_demand())));
  dictionary_.set(kFollowingError, saturate<std::int32_t>(motion_.following_error()));
  dictionary_.set(kVelocityActual, saturate<std::int32_t>(motion_.velocity()));
  dictionary_.set(kVelocityDemand, saturate<std::int32_t>(motion_.velocity_demand()));
  dictionary_.set(kTorqueActual, torque);
  // The sign of the torque, the size of both currents: in saturated iron, or with d current, more than the torque's.
  dictionary_.set(kCurrentActual, saturate<std::int16_t>(std::copysign(motion_.current_permille(), torque)));
  dictionary_.set(kTorqueDemand, saturate<std::int16_t>(motion_.torque_demand_permille()));
  dictionary_.set(kDcLinkVoltage, saturate<std::uint32_t>(dc_link_.volts() * 1e3));
  dictionary_.set(kDcLinkVolts, static_cast<float>(dc_link_.volts()));
  dictionary_.set(kTouchProbeStatus, probe_.status());
  for (std::uint16_t i = 0; i < TouchProbe::kValues; ++i) {
    dictionary_.set(static_cast<std::uint16_t>(kTouchProbeValueFirst + i),
                    probe_.value(static_cast<TouchProbe::Value>(i)));
  }
  publish_warnings();
  publish_motor_values();
  dictionary_.set(kInputState, terminals_.input_image());
  dictionary_.set(kDigitalInputs, terminals_.function_image());
  dictionary_.set(kOutputState, terminals_.output_image());
  if (shown_state_ != shown_state()) {
    shown_state_ = shown_state();
    shown_since_ = running_time();
  }
}

/// P 412-P 419: the same as the profile's objects, in units of the motor.
void MsdDrive::publish_motor_values() noexcept {
  const auto actual = static_cast<std::int32_t>(motion_.motor().encoder_count());
  const auto difference = saturate<std::int32_t>(motion_.following_error_increments());
  dictionary_.set(kActualIncrements, actual);
  dictionary_.set(kReferenceIncrements, static_cast<std::uint32_t>(actual) + static_cast<std::uint32_t>(difference));
  dictionary_.set(kIncrementDifference, difference);
  dictionary_.set(kActualRpm, static_cast<float>(motion_.controller().measured_velocity_rad_s() / kRpm));
  dictionary_.set(kReferenceRpm, static_cast<float>(motion_.controller().velocity_setpoint_rad_s() / kRpm));
  dictionary_.set(kReferenceTorqueNm, static_cast<float>(motion_.torque_demand_nm()));
  dictionary_.set(kActualTorqueNm, static_cast<float>(motion_.torque_nm()));
}

/// P 33, P 34 and the values that the warnings are about.
void MsdDrive::publish_warnings() noexcept {
  dictionary_.set(kOverloadIntegrator, static_cast<float>(thermal_.overload_percent()));
  dictionary_.set(kMotorTemperature, static_cast<float>(thermal_.motor_c()));
  if (warnings_ == shown_warnings_) return;
  shown_warnings_ = warnings_;
  dictionary_.set(kWarnings, warnings_);
  std::uint16_t slot = warning_text_;
  for (unsigned bit = 0; bit < 32; ++bit) {
    if ((warnings_ >> bit & 1U) != 0) dictionary_.text(slot++) = text(static_cast<Warning>(bit));
  }
  for (; slot < warning_text_ + kWarningTexts; ++slot) dictionary_.text(slot).clear();
}

}  // namespace driveline::slaves::msd
