#include "driveline/slaves/esc/slave.hpp"

#include <algorithm>
#include <utility>

namespace driveline::slaves {

using Use = SyncManagerLayout::Use;

namespace {

/// Steps that lie further back are not made up for one by one (the program was stopped, the clock was set).
constexpr std::chrono::nanoseconds kMaxCatchUp = std::chrono::seconds{10};
constexpr std::chrono::nanoseconds kDefaultPeriod = std::chrono::milliseconds{1};

EscOptions esc_options(const DeviceProfile& profile, const SlaveOptions& options) {
  EscOptions result;
  result.fmmu_count = profile.fmmu_count;
  result.sync_manager_count = profile.sync_manager_count;
  result.ram_kib = profile.ram_kib;
  result.distributed_clock = profile.distributed_clock;
  result.distributed_clock_64bit = profile.distributed_clock_64bit;
  result.sii = options.sii;
  result.clock = options.clock;
  return result;
}

}  // namespace

Slave::Slave(std::unique_ptr<Device> device, const SlaveOptions& options)
    : device_(std::move(device)),
      period_(device_->process_data_period() > Nanoseconds{0} ? device_->process_data_period() : kDefaultPeriod),
      esc_(esc_options(device_->profile(), options), device_->profile().sii_image),
      al_(esc_, *device_, options.al),
      mailbox_(esc_, *device_) {}

void Slave::set_power(bool on, Nanoseconds now) noexcept {
  if (on == powered_) return;
  powered_ = on;
  restart(now);
  due_ = on ? now : Nanoseconds::max();
}

void Slave::restart(Nanoseconds now) noexcept {
  const auto from = al_.state();
  esc_.power_on();
  al_.reset();
  mailbox_.reset();
  exchanging_ = false;
  next_step_ = now;
  device_->fall_back(from, wire::AlState::kInit, wire::AlStatusCode::kNoError);
}

void Slave::run(Nanoseconds now) {
  esc_.events().firmware_answered();
  if (!powered_ || !esc_.pdi_operational()) {
    due_ = Nanoseconds::max();
    return;
  }
  if (esc_.reset_requested()) restart(now);
  al_.handle_events(now);
  after_state_change(now);
  if (al_.mailbox_running()) mailbox_.run();
  if (now - next_step_ > kMaxCatchUp) next_step_ += (now - next_step_) / period_ * period_;
  for (Nanoseconds time = next_event(); time <= now; time = next_event()) {
    if (time == esc_.watchdog().expiry()) {
      expire_watchdog();
    } else if (time == al_.due()) {
      al_.on_time(time);
    } else {
      step(time, now);
    }
    after_state_change(time);
  }
  due_ = next_event();
}

Slave::Nanoseconds Slave::next_event() const noexcept {
  return std::min({next_step_, al_.due(), esc_.watchdog().expiry()});
}

void Slave::expire_watchdog() noexcept {
  esc_.watchdog().expire();
  if (al_.outputs_running() && !esc_.device_emulation()) {
    al_.fall_back(wire::AlState::kSafeOp, wire::AlStatusCode::kSyncManagerWatchdog);
  }
}

void Slave::step(Nanoseconds time, Nanoseconds now) {
  if (!al_.inputs_running()) {
    // Nobody exchanges process data: one step up to the next event.
    const auto until = std::min({now, al_.due(), esc_.watchdog().expiry()});
    device_->advance(until);
    next_step_ = until + period_;
  } else {
    if (al_.outputs_running()) hand_over_outputs();
    device_->advance(time);
    publish_inputs();
    next_step_ = time + period_;
    al_.on_step(time);
  }
  if (al_.mailbox_running()) mailbox_.run();
}

void Slave::after_state_change(Nanoseconds time) noexcept {
  if (!al_.mailbox_running()) mailbox_.reset();
  if (al_.inputs_running() == exchanging_) return;
  exchanging_ = al_.inputs_running();
  next_step_ = time + period_;
  if (exchanging_) publish_inputs();
}

void Slave::hand_over_outputs() noexcept {
  const auto& layout = device_->profile().sync_managers;
  for (unsigned n = 0; n < layout.size(); ++n) {
    if (layout[n].use != Use::kOutputs || !esc_.sync_managers().fresh(n)) continue;
    const auto data = esc_.sync_managers().take(n);
    if (!data.empty()) device_->write_outputs(n, data);
  }
}

void Slave::publish_inputs() noexcept {
  const auto& layout = device_->profile().sync_managers;
  for (unsigned n = 0; n < layout.size(); ++n) {
    if (layout[n].use != Use::kInputs) continue;
    const auto buffer = esc_.sync_managers().begin_publish(n);
    if (buffer.empty()) continue;
    device_->read_inputs(n, buffer);
    esc_.sync_managers().end_publish(n);
  }
}

}  // namespace driveline::slaves
