#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

#include "driveline/motion/cia301/image_place.hpp"
#include "driveline/motion/cia301/pdo_configuration.hpp"
#include "driveline/motion/cia301/pdo_entry.hpp"
#include "driveline/motion/cia402/cia402.hpp"
#include "driveline/motion/drive/axis_inputs.hpp"
#include "driveline/motion/drive/drive_exchange.hpp"
#include "driveline/motion/drive/homing_handshake.hpp"
#include "driveline/motion/drive/profile_handshake.hpp"
#include "driveline/motion/drive/profile_objects.hpp"
#include "driveline/motion/drive/touch_probe.hpp"

namespace driveline::motion {

/// A drive of CiA 402 (IEC 61800-7-201) with its objects in the process data: DriveLink describes the functions.
/// Objects that are not mapped are skipped on output and read as zero.
class Cia402Link {
 public:
  /// Facts of the drive and its axis that the link needs.
  struct Settings {
    DriveScales scales{};              ///< units of the drive
    ProfileObjects::Limits profile{};  ///< until ProfileObjects::set()
    bool needs_torque_offset = false;  ///< CSP and CSV are possible only with 60B2h
    /// 607Ah and 60FFh are written only in the profile modes that use them: the drive has no cyclic mode, and their
    /// PDOs are sent on change.
    bool profile_targets_only = false;
  };

  /// `place` and `pdos` say where the objects lie in the image.
  Cia402Link(const ImagePlace& place, const PdoConfiguration& pdos, const Settings& settings);

  /// \name Exchange, see DriveLink
  /// @{

  /// Decodes the inputs. \rtsafe
  [[nodiscard]] DriveCounts read(std::span<const std::byte> image, bool fresh, AxisInputs& inputs) noexcept;
  /// Writes the outputs. \rtsafe
  void write(std::span<std::byte> image, const DriveTargets& targets) noexcept;
  /// Sets the inputs of a virtual axis. \rtsafe
  void obey(AxisInputs& inputs) noexcept;
  /// 6040h of the last write(). \rtsafe
  [[nodiscard]] std::uint16_t control_word() const noexcept { return control_word_; }
  /// Whether 6040h is Enable operation. \rtsafe
  [[nodiscard]] bool commanded_on() const noexcept {
    return (control_word_ & cia402::command::kEnableOperation) == cia402::command::kEnableOperation;
  }
  /// State in the last 6041h. \rtsafe
  [[nodiscard]] snapshot::AxisState reported_state() const noexcept { return cia402::decode_state(status_word_); }
  /// @}

  /// \name What the process data contain, see DriveLink
  /// @{

  /// Whether missing_objects() of the mode is empty. \rtsafe
  [[nodiscard]] bool possible(cia402::Mode mode) const noexcept {
    return (possible_modes_ >> static_cast<unsigned>(mode) & 1U) != 0;
  }
  /// Whether 6060h and 6061h are mapped. \rtsafe
  [[nodiscard]] bool changes_mode() const noexcept { return mode_ && mode_display_; }
  /// Whether 6061h is mapped. \rtsafe
  [[nodiscard]] bool shows_mode() const noexcept { return mode_display_.has_value(); }
  /// Whether 6077h is mapped. \rtsafe
  [[nodiscard]] bool reports_torque() const noexcept { return actual_torque_.has_value(); }
  /// Whether 60F4h is mapped. \rtsafe
  [[nodiscard]] bool reports_following_error() const noexcept { return following_error_.has_value(); }
  /// Whether 60B1h is mapped. \rtsafe
  [[nodiscard]] bool takes_velocity_offset() const noexcept { return velocity_offset_.has_value(); }
  /// Whether 60B2h is mapped. \rtsafe
  [[nodiscard]] bool takes_torque_offset() const noexcept { return torque_offset_.has_value(); }
  /// @}

  /// \name Requests, see DriveLink
  /// @{

  /// Sets bit 4 in homing mode. \rtsafe
  void begin_homing() noexcept;
  /// Evaluates bits 10, 12 and 13. \rtsafe
  [[nodiscard]] HomingHandshake::State homing_progress(std::chrono::nanoseconds since) noexcept {
    return homing_.judge(status_word_, since);
  }
  /// Starts the handover by bits 4 and 5. \rtsafe
  void begin_positioning(ProfileHandshake::Change change) noexcept;
  /// The target velocity takes effect without a bit. \rtsafe
  void begin_velocity() noexcept;
  /// Writes 6042h and sets bits 4 to 6. \rtsafe
  void begin_velocity_on_ramp(double velocity) noexcept;
  /// Evaluates bits 10 and 12, and sets or clears bit 4. \rtsafe
  [[nodiscard]] ProfileHandshake::State target_progress(std::chrono::nanoseconds since) noexcept;
  /// Whether the handover is complete. \rtsafe
  [[nodiscard]] bool target_under_way() const noexcept { return target_.under_way(); }
  /// Forgets the handover. \rtsafe
  void forget_target() noexcept { target_ = {}; }
  /// Sets bit 8. \rtsafe
  void halt() noexcept { request_bits_ = cia402::command_bit::kHalt; }
  /// Clears the bits of requests. \rtsafe
  void end_request() noexcept { request_bits_ = 0; }
  /// Whether bit 10 is set. \rtsafe
  [[nodiscard]] bool stands_still() const noexcept { return (status_word_ & cia402::status_bit::kTargetReached) != 0; }
  /// 6042h, 6081h, 6083h and 6084h. \rtsafe
  [[nodiscard]] ProfileObjects& profile() noexcept { return profile_; }
  /// Read only. \rtsafe
  [[nodiscard]] const ProfileObjects& profile() const noexcept { return profile_; }
  /// 60B8h to 60BDh. \rtsafe
  [[nodiscard]] TouchProbe& probe() noexcept { return probe_; }
  /// Read only. \rtsafe
  [[nodiscard]] const TouchProbe& probe() const noexcept { return probe_; }
  /// @}

 private:
  [[nodiscard]] std::uint16_t word_for(const DriveTargets& targets) const noexcept;

  DriveScales scales_;
  bool profile_targets_only_;
  std::uint32_t possible_modes_;  ///< bit n: all objects of mode n are mapped
  std::uint16_t control_word_ = 0;
  std::uint16_t status_word_ = 0;   ///< of the last valid exchange
  std::uint16_t request_bits_ = 0;  ///< of cia402::command_bit: added to the control word of an enabled drive
  HomingHandshake homing_;
  ProfileHandshake target_;
  std::optional<PdoEntry<std::uint16_t>> control_;            // 6040h
  std::optional<PdoEntry<std::int8_t>> mode_;                 // 6060h
  std::optional<PdoEntry<std::int32_t>> target_position_;     // 607Ah
  std::optional<PdoEntry<std::int32_t>> interpolation_data_;  // 60C1h:01
  std::optional<PdoEntry<std::int32_t>> target_velocity_;     // 60FFh
  std::optional<PdoEntry<std::int32_t>> velocity_offset_;     // 60B1h
  std::optional<PdoEntry<std::int16_t>> target_torque_;       // 6071h
  std::optional<PdoEntry<std::int16_t>> torque_offset_;       // 60B2h
  std::optional<PdoEntry<std::uint16_t>> status_;             // 6041h
  std::optional<PdoEntry<std::int8_t>> mode_display_;         // 6061h
  std::optional<PdoEntry<std::int32_t>> actual_position_;     // 6064h
  std::optional<PdoEntry<std::int32_t>> actual_velocity_;     // 606Ch
  std::optional<PdoEntry<std::int32_t>> following_error_;     // 60F4h
  std::optional<PdoEntry<std::int16_t>> actual_torque_;       // 6077h
  std::optional<PdoEntry<std::uint16_t>> error_code_;         // 603Fh
  std::optional<PdoEntry<std::int32_t>> demand_position_;     // 6062h
  std::optional<PdoEntry<std::int32_t>> demand_velocity_;     // 606Bh
  std::optional<PdoEntry<std::int16_t>> demand_torque_;       // 6074h
  std::optional<PdoEntry<std::uint32_t>> digital_inputs_;     // 60FDh
  TouchProbe probe_;                                          // 60B8h to 60BDh
  ProfileObjects profile_;                                    // 6042h, 6081h, 6083h, 6084h
};

}  // namespace driveline::motion
