#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <span>
#include <variant>

#include "driveline/motion/drive/cia402_link.hpp"
#include "driveline/motion/drive/probe_trigger.hpp"

namespace driveline::motion {

/// Connection of an axis to its drive: the values of an exchange, and requests with a meaning, which each profile turns
/// into bits, objects or procedures of its own. A closed set of value types, so the cycle makes no virtual call.
///
/// A plain value; used by the real-time thread only once the cycle runs. Everything but the constructor is \rtsafe.
class DriveLink {
 public:
  using HomingProgress = HomingHandshake::State;   ///< see HomingHandshake
  using TargetProgress = ProfileHandshake::State;  ///< see ProfileHandshake
  using TargetChange = ProfileHandshake::Change;   ///< see ProfileHandshake
  using ProbePhase = TouchProbe::Phase;            ///< see TouchProbe

  /// A drive of CiA 402.
  explicit DriveLink(const Cia402Link& link) noexcept : link_(link) {}

  /// \name Exchange
  /// @{

  /// Decodes the inputs of a valid exchange, except positions, which are returned in increments. `fresh` false: they
  /// are those of an earlier exchange.
  [[nodiscard]] DriveCounts read(std::span<const std::byte> image, bool fresh, AxisInputs& inputs) noexcept {
    return std::visit([&](auto& link) { return link.read(image, fresh, inputs); }, link_);
  }
  /// Writes the outputs of an exchange, with what the requests need.
  void write(std::span<std::byte> image, const DriveTargets& targets) noexcept {
    std::visit([&](auto& link) { link.write(image, targets); }, link_);
  }
  /// Sets the inputs of a virtual axis: its ideal drive executes the last outputs at once and has no faults.
  void obey(AxisInputs& inputs) noexcept {
    std::visit([&](auto& link) { link.obey(inputs); }, link_);
  }
  /// Command word of the last write(), for displays.
  [[nodiscard]] std::uint16_t control_word() const noexcept {
    return std::visit([](const auto& link) { return link.control_word(); }, link_);
  }
  /// Whether the last write() commanded the drive to be on and follow setpoints.
  [[nodiscard]] bool commanded_on() const noexcept {
    return std::visit([](const auto& link) { return link.commanded_on(); }, link_);
  }
  /// State in the last valid exchange.
  [[nodiscard]] snapshot::AxisState reported_state() const noexcept {
    return std::visit([](const auto& link) { return link.reported_state(); }, link_);
  }
  /// @}

  /// \name What the process data contain
  /// @{

  /// Whether they have all that the mode needs.
  [[nodiscard]] bool possible(cia402::Mode mode) const noexcept {
    return std::visit([mode](const auto& link) { return link.possible(mode); }, link_);
  }
  /// Whether the mode can be changed and the change be seen.
  [[nodiscard]] bool changes_mode() const noexcept {
    return std::visit([](const auto& link) { return link.changes_mode(); }, link_);
  }
  /// Whether AxisInputs::mode is that of the drive.
  [[nodiscard]] bool shows_mode() const noexcept {
    return std::visit([](const auto& link) { return link.shows_mode(); }, link_);
  }
  /// Whether AxisInputs::torque is that of the drive.
  [[nodiscard]] bool reports_torque() const noexcept {
    return std::visit([](const auto& link) { return link.reports_torque(); }, link_);
  }
  /// Whether AxisInputs::drive_following_error is that of the drive.
  [[nodiscard]] bool reports_following_error() const noexcept {
    return std::visit([](const auto& link) { return link.reports_following_error(); }, link_);
  }
  /// Whether DriveTargets::velocity_offset reaches the drive.
  [[nodiscard]] bool takes_velocity_offset() const noexcept {
    return std::visit([](const auto& link) { return link.takes_velocity_offset(); }, link_);
  }
  /// Whether DriveTargets::torque_offset reaches the drive.
  [[nodiscard]] bool takes_torque_offset() const noexcept {
    return std::visit([](const auto& link) { return link.takes_torque_offset(); }, link_);
  }
  /// @}

  /// \name Motions that the drive generates itself, in a mode that does so
  /// A request replaces the previous one. Times count from the start of the request.
  /// @{

  /// Starts homing.
  void begin_homing() noexcept {
    std::visit([](auto& link) { link.begin_homing(); }, link_);
  }
  /// Evaluates the last exchange; to be called for each exchange.
  [[nodiscard]] HomingProgress homing_progress(std::chrono::nanoseconds since) noexcept {
    return std::visit([since](auto& link) { return link.homing_progress(since); }, link_);
  }
  /// Starts the movement to the target position.
  void begin_positioning(TargetChange change) noexcept {
    std::visit([change](auto& link) { link.begin_positioning(change); }, link_);
  }
  /// Starts the movement with the target velocity (profile velocity mode).
  void begin_velocity() noexcept {
    std::visit([](auto& link) { link.begin_velocity(); }, link_);
  }
  /// Starts the movement with this velocity, rad/s or m/s, along the drive's ramp (velocity mode).
  void begin_velocity_on_ramp(double velocity) noexcept {
    std::visit([velocity](auto& link) { link.begin_velocity_on_ramp(velocity); }, link_);
  }
  /// Evaluates the last exchange and continues the handover of the target; to be called for each exchange.
  [[nodiscard]] TargetProgress target_progress(std::chrono::nanoseconds since) noexcept {
    return std::visit([since](auto& link) { return link.target_progress(since); }, link_);
  }
  /// Whether the drive has taken the last target and started its movement.
  [[nodiscard]] bool target_under_way() const noexcept {
    return std::visit([](const auto& link) { return link.target_under_way(); }, link_);
  }
  /// Forgets the handover of earlier targets: the next one is the first in its mode.
  void forget_target() noexcept {
    std::visit([](auto& link) { link.forget_target(); }, link_);
  }
  /// Stops the movement; it would continue after end_request().
  void halt() noexcept {
    std::visit([](auto& link) { link.halt(); }, link_);
  }
  /// Ends the request; homing stops.
  void end_request() noexcept {
    std::visit([](auto& link) { link.end_request(); }, link_);
  }
  /// Whether the drive reported in the last exchange that the axis stands still, after halt() or during homing.
  [[nodiscard]] bool stands_still() const noexcept {
    return std::visit([](const auto& link) { return link.stands_still(); }, link_);
  }
  /// Velocity and ramps of these movements.
  [[nodiscard]] ProfileObjects& profile() noexcept {
    return std::visit([](auto& link) -> ProfileObjects& { return link.profile(); }, link_);
  }
  /// Read only.
  [[nodiscard]] const ProfileObjects& profile() const noexcept {
    return std::visit([](const auto& link) -> const ProfileObjects& { return link.profile(); }, link_);
  }
  /// @}

  /// \name Touch probe, see TouchProbe
  /// @{

  /// Whether the drive can report such an event.
  [[nodiscard]] bool probe_possible(ProbeTrigger trigger) const noexcept {
    return std::visit([trigger](const auto& link) { return link.probe().possible(trigger); }, link_);
  }
  /// Starts to latch the next event; discards an earlier one.
  void arm_probe(ProbeTrigger trigger) noexcept {
    std::visit([trigger](auto& link) { link.probe().arm(trigger); }, link_);
  }
  /// Switches the probe off.
  void disarm_probe() noexcept {
    std::visit([](auto& link) { link.probe().disarm(); }, link_);
  }
  /// Phase as of the last exchange.
  [[nodiscard]] ProbePhase probe_phase() const noexcept {
    return std::visit([](const auto& link) { return link.probe().phase(); }, link_);
  }
  /// Position at the event, increments; valid in ProbePhase::kLatched.
  [[nodiscard]] std::int32_t probe_value() const noexcept {
    return std::visit([](const auto& link) { return link.probe().value(); }, link_);
  }
  /// @}

 private:
  std::variant<Cia402Link> link_;
};

}  // namespace driveline::motion
