#include "driveline/slaves/esc/slave.hpp"

#include <algorithm>
#include <utility>

namespace driveline::slaves {

using Use = SyncManagerLayout::Use;

namespace {

/// Older steps are skipped (the program was stopped, or the clock was set).
constexpr std::chrono::nanoseconds kMaxCatchUp = std::chrono::seconds{10};
/// Maximum number of SYNC0 pulses to catch up.
constexpr std::int64_t kMaxPulses = 100'000;
constexpr std::chrono::nanoseconds kDefaultPeriod = std::chrono::milliseconds{1};

EscOptions esc_options(const DeviceProfile& profile, const SlaveOptions& options) {
  EscOptions result;
  result.fmmu_count = profile.fmmu_count;
  result.sync_manager_count = profile.sync_manager_count;
  result.ram_kib = profile.ram_kib;
  result.distributed_clock = profile.distributed_clock;
  result.distributed_clock_64bit = profile.distributed_clock_64bit;
  result.logical_read_write = profile.logical_read_write;
  result.sii = options.sii;
  result.clock = options.clock;
  return result;
}

}  // namespace

Slave::Slave(std::unique_ptr<Device> device, const SlaveOptions& options)
    : device_(std::move(device)),
      period_(device_->process_data_period() > Nanoseconds{0} ? device_->process_data_period() : kDefaultPeriod),
      esc_(esc_options(device_->profile(), options),
           options.sii_image.empty() ? device_->profile().sii_image : options.sii_image),
      al_(esc_, *device_, options.al),
      mailbox_(esc_, *device_),
      first_exchange_(period_ / 4) {
  tell_eeprom();
}

void Slave::tell_eeprom() noexcept {
  if (eeprom_loads_ == esc_.sii().loads()) return;
  eeprom_loads_ = esc_.sii().loads();
  device_->eeprom_loaded(esc_.sii().image(), esc_.sii().loaded());
}

void Slave::set_power(bool on, Nanoseconds now) noexcept {
  if (on == powered_) return;
  powered_ = on;
  restart(now);
  due_ = on ? now : Nanoseconds::max();
}

void Slave::restart(Nanoseconds now) noexcept {
  esc_.power_on(now);
  al_.reset();
  mailbox_.reset();
  exchanging_ = sync_driven_ = false;
  stalled_until_.reset();
  next_step_ = now;
  first_exchange_ = now + period_ / 4;
  tell_eeprom();
  device_->restart();
}

void Slave::stall(Nanoseconds now, Nanoseconds duration) noexcept {
  if (!stalled_until_) stalled_since_ = now;
  stalled_until_ = now + duration;
  esc_.watchdog().pdi_silent(now);
  due_ = std::min(due_, now);
}

void Slave::run(Nanoseconds now) {
  esc_.events().firmware_answered();
  if (!powered_) {
    due_ = Nanoseconds::max();
    return;
  }
  if (esc_.reset_requested()) restart(now);
  tell_eeprom();
  run_application(now);
  if (now - next_step_ > kMaxCatchUp) next_step_ += (now - next_step_) / period_ * period_;
  skip_pulses_long_past(now);
  for (Nanoseconds time = next_event(); time <= now; time = next_event()) {
    happen(time, now);
    after_state_change(time);
  }
  due_ = next_event();
}

void Slave::skip_pulses_long_past(Nanoseconds now) noexcept {
  auto& clock = esc_.clock();
  const Nanoseconds cycle{clock.sync().cycle()};
  const auto max_backlog = cycle.count() == 0 ? kMaxCatchUp : std::min(kMaxCatchUp, kMaxPulses * cycle);
  if (now - clock.sync_due() > max_backlog) clock.skip_pulses(now);
}

void Slave::run_application(Nanoseconds now) {
  if (stalled_until_ || !esc_.pdi_operational()) return;
  al_.handle_events(now);
  after_state_change(now);
  if (al_.mailbox_running()) mailbox_.run(now);
}

Slave::Nanoseconds Slave::next_event() const noexcept {
  const auto controller = std::min(esc_.due(), esc_.clock().sync_due());
  // Without the process data interface the device still runs, but is invisible to the bus.
  if (!esc_.pdi_operational()) return std::min(controller, next_step_);
  if (stalled_until_) return std::min(controller, *stalled_until_);
  return std::min({next_step_, al_.due(), controller});
}

void Slave::happen(Nanoseconds time, Nanoseconds now) {
  if (time == esc_.due()) return controller_event(time);
  if (time == esc_.clock().sync_due()) return sync_pulse(time);
  if (!esc_.pdi_operational()) return step_alone(time, now);
  if (stalled_until_) return wake_up(time);
  if (time == al_.due()) return al_.on_time(time);
  step(time, now);
}

void Slave::controller_event(Nanoseconds time) noexcept {
  const bool was_expired = esc_.watchdog().expired();
  esc_.on_time(time);
  const bool expires = esc_.watchdog().expired() && !was_expired;
  if (expires && !stalled_until_ && al_.outputs_running() && !esc_.device_emulation()) {
    al_.fall_back(wire::AlState::kSafeOp, wire::AlStatusCode::kSyncManagerWatchdog);
  }
}

void Slave::sync_pulse(Nanoseconds time) {
  const auto pulse = esc_.clock().take_pulse();
  if (!pulse || !esc_.pdi_operational()) return;
  if (stalled_until_) return al_.on_unserved_sync(pulse->signal, time);
  esc_.clock().acknowledge_sync();
  device_->advance(time);
  const bool exchange = pulse->signal == SyncSignal::kSync0 && al_.inputs_running();
  if (exchange && al_.outputs_running()) hand_over_outputs(time);
  device_->sync_event(pulse->signal, time);
  al_.on_sync(pulse->signal, time);
  if (al_.outputs_running()) device_->sync_margin(al_.sync_margin());
  if (!exchange) return;
  publish_inputs(time);
  al_.on_step(time);
  // From now on SYNC0 defines the step; the device's own step occurs only if no SYNC0 comes for 1.5 periods.
  sync_driven_ = true;
  next_step_ = time + period_ + period_ / 2;
}

void Slave::wake_up(Nanoseconds time) noexcept {
  stalled_until_.reset();
  esc_.watchdog().pdi_alive();
  next_step_ = time;
  const bool noticed = time - stalled_since_ > kBackgroundWatchdog;
  if (noticed && al_.inputs_running() && !esc_.device_emulation()) {
    al_.fall_back(wire::AlState::kSafeOp, wire::AlStatusCode::kBackgroundWatchdog);
  }
  device_->sync_margin(al_.sync_margin());
  al_.handle_events(time);
}

/// Runs one step up to the next event, without exchange of process data.
void Slave::step_alone(Nanoseconds time, Nanoseconds now) {
  const auto until = std::max(time, std::min({now, al_.due(), esc_.due(), esc_.clock().sync_due()}));
  device_->advance(until);
  next_step_ = until + period_;
}

void Slave::step(Nanoseconds time, Nanoseconds now) {
  if (!al_.inputs_running()) {
    step_alone(time, now);
  } else {
    sync_driven_ = sync_driven_ && esc_.clock().sync().running();
    if (al_.outputs_running() && !sync_driven_) hand_over_outputs(time);
    device_->advance(time);
    publish_inputs(time);
    next_step_ = time + period_;
    al_.on_step(time);
  }
  if (al_.mailbox_running()) mailbox_.run(time);
}

void Slave::after_state_change(Nanoseconds time) noexcept {
  if (!al_.mailbox_running()) mailbox_.reset();
  if (al_.inputs_running() == exchanging_) return;
  exchanging_ = al_.inputs_running();
  sync_driven_ = false;
  next_step_ = own_step_after(time);
  if (exchanging_) publish_inputs(time);
}

Slave::Nanoseconds Slave::own_step_after(Nanoseconds time) const noexcept {
  return first_exchange_ + ((time - first_exchange_) / period_ + 1) * period_;
}

void Slave::hand_over_outputs(Nanoseconds time) noexcept {
  const auto& layout = device_->profile().sync_managers;
  for (unsigned n = 0; n < layout.size(); ++n) {
    if (layout[n].use != Use::kOutputs || !esc_.sync_managers().fresh(n)) continue;
    const auto data = esc_.sync_managers().take(n);
    if (!data.empty()) device_->write_outputs(n, data);
  }
  if (esc_.sync_managers().take_pdi_buffer_event()) esc_.clock().stamp_pdi_buffer(time);
}

void Slave::publish_inputs(Nanoseconds time) noexcept {
  const auto& layout = device_->profile().sync_managers;
  for (unsigned n = 0; n < layout.size(); ++n) {
    if (layout[n].use != Use::kInputs) continue;
    const auto buffer = esc_.sync_managers().begin_publish(n);
    if (buffer.empty()) continue;
    device_->read_inputs(n, buffer);
    esc_.sync_managers().end_publish(n);
  }
  if (esc_.sync_managers().take_pdi_buffer_event()) esc_.clock().stamp_pdi_buffer(time);
}

}  // namespace driveline::slaves
