#pragma once

#include <chrono>
#include <memory>
#include <optional>
#include <vector>

#include "driveline/slaves/device.hpp"
#include "driveline/slaves/esc/al_state_machine.hpp"
#include "driveline/slaves/esc/esc.hpp"
#include "driveline/slaves/esc/mailbox_transport.hpp"

namespace driveline::slaves {

/// Behaviour of an emulated slave where the standard leaves it to the device.
struct SlaveOptions {
  AlOptions al;        ///< times of the state machine
  SiiOptions sii;      ///< behaviour of the EEPROM
  ClockOptions clock;  ///< oscillator and time stamps
  /// EEPROM content that replaces the device's own (see SiiFile); empty: the device's.
  std::vector<std::byte> sii_image;
};

/// A complete emulated slave: controller, state machine, mailbox transport and device.
///
/// It is driven by time, not by frames: advance() runs it up to a time, in steps of the device's process data period;
/// the watchdog expires and delayed transitions occur at their own times in between. From the first SYNC0 in SAFEOP or
/// OP, process data are transferred at SYNC0 instead. Not thread-safe; the thread that drives the line calls all
/// functions.
class Slave {
 public:
  /// Times are on the line's clock.
  using Nanoseconds = std::chrono::nanoseconds;

  /// Powered on at time 0, in INIT. `device` must not be null.
  explicit Slave(std::unique_ptr<Device> device, const SlaveOptions& options = {});

  /// Runs the slave up to `now`. Cheap when there is nothing to do. \rtsafe unless a mailbox message is transferred.
  void advance(Nanoseconds now) {
    if (now >= due_ || esc_.events().firmware_called()) run(now);
  }

  /// Switches the power supply; switching on starts the slave in INIT.
  void set_power(bool on, Nanoseconds now) noexcept;
  /// Returns the state of set_power().
  [[nodiscard]] bool powered() const noexcept { return powered_; }

  /// Fault: the application stops for `duration` from `now` on, like a processor that hangs. The controller answers
  /// frames alone; AL control and mailboxes are not handled, the PDI watchdog expires. An application that continues
  /// after more than kBackgroundWatchdog in SAFEOP or OP reports its own background watchdog (0x002A).
  void stall(Nanoseconds now, Nanoseconds duration) noexcept;
  /// Longest stop that the application does not report.
  static constexpr Nanoseconds kBackgroundWatchdog = std::chrono::milliseconds{100};

  /// Returns the slave controller: registers, ports, EEPROM, clock.
  [[nodiscard]] Esc& esc() noexcept { return esc_; }
  /// Returns the slave controller, read only.
  [[nodiscard]] const Esc& esc() const noexcept { return esc_; }
  /// Returns the device that was passed to the constructor.
  [[nodiscard]] Device& device() noexcept { return *device_; }
  /// Returns the state machine, also for its faults.
  [[nodiscard]] AlStateMachine& al() noexcept { return al_; }
  /// Returns the state machine, read only.
  [[nodiscard]] const AlStateMachine& al() const noexcept { return al_; }
  /// Returns the mailbox transport, for its faults.
  [[nodiscard]] MailboxTransport& mailbox() noexcept { return mailbox_; }
  /// Returns the AL state; INIT while the slave is off.
  [[nodiscard]] wire::AlState state() const noexcept { return al_.state(); }

 private:
  void run(Nanoseconds now);
  void restart(Nanoseconds now) noexcept;
  void tell_eeprom() noexcept;
  void run_application(Nanoseconds now);
  void skip_pulses_long_past(Nanoseconds now) noexcept;
  void happen(Nanoseconds time, Nanoseconds now);
  void step(Nanoseconds time, Nanoseconds now);
  void step_alone(Nanoseconds time, Nanoseconds now);
  void controller_event(Nanoseconds time) noexcept;
  void wake_up(Nanoseconds time) noexcept;
  void after_state_change(Nanoseconds time) noexcept;
  void sync_pulse(Nanoseconds time);
  void hand_over_outputs(Nanoseconds time) noexcept;
  void publish_inputs(Nanoseconds time) noexcept;
  [[nodiscard]] Nanoseconds next_event() const noexcept;
  /// The first step of the device after `time`. The firmware counts its steps from its start: a change of state does
  /// not move them, so that how long a bring-up took does not decide where in the period the device exchanges process
  /// data.
  [[nodiscard]] Nanoseconds own_step_after(Nanoseconds time) const noexcept;

  std::unique_ptr<Device> device_;
  Nanoseconds period_;
  Esc esc_;
  AlStateMachine al_;
  MailboxTransport mailbox_;
  std::uint64_t eeprom_loads_ = 0;  ///< EEPROM loads that the device has been notified of
  bool powered_ = true;
  bool sync_driven_ = false;  ///< process data are transferred at SYNC0, not in steps of the device
  bool exchanging_ = false;   ///< inputs have been published since SAFEOP was entered
  Nanoseconds next_step_{0};
  Nanoseconds first_exchange_;  ///< a quarter of a period after the device's start
  std::optional<Nanoseconds> stalled_until_;
  Nanoseconds stalled_since_{0};
  Nanoseconds due_{0};
};

}  // namespace driveline::slaves
