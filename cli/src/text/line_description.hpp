#pragma once

#include <map>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "driveline/runtime/setup/drive_facts.hpp"
#include "line/line_view.hpp"

namespace driveline::cli {

/// Scaling of a CiA 402 drive, as far as its objects report it.
struct FoundDrive {
  std::optional<std::uint32_t> supported_modes;     ///< 6502h, bit n: mode n + 1
  std::optional<double> increments_per_revolution;  ///< position units per motor turn
  std::optional<double> rated_torque_nm;            ///< 6076h
  std::optional<double> max_velocity_rad_s;         ///< 6080h
  unsigned number = 0;                              ///< number in the slave, see motion::object_of_drive()
  /// Reads the objects of one drive.
  [[nodiscard]] static FoundDrive read(const runtime::ReadObject& read, unsigned number);
  /// Reads the objects of all drives of a slave; empty: the slave is no CiA 402 drive.
  [[nodiscard]] static std::vector<FoundDrive> read_all(LineView& line, ecat_master::MailboxClient& mailbox);
};

/// A slave to be described.
struct FoundSlave {
  SlaveView view;
  std::optional<std::uint16_t> device_id;  ///< explicit device identification; none: the slave has none
  std::vector<FoundDrive> drives;          ///< in the order of their numbers
  /// File for its EEPROM image, for a simulation of the line, beside the description; empty: no file.
  std::string image_file;
};

/// The input of a line description.
struct FoundLine {
  std::vector<FoundSlave> slaves;
  std::optional<std::string> interface;  ///< interface of the line; none: simulated in this process
  std::string tree;                      ///< connections of the slaves, for a comment; empty: a plain chain, or unknown
  std::string path_file;                 ///< file of gentle_path() beside the description; empty: no motion
};

/// Creates a line description (TOML) of slaves that have been found, which `run` can use unchanged. Every slave is
/// expected by vendor, product, revision and, if it has one, serial number; it is found by alias or device
/// identification if that is unique on the line, else by its position. CiA 402 drives get an [[axis]] with the drive's
/// scaling; if that is incomplete, the [[axis]] is a comment with the reason. Without `path_file` nothing moves: the
/// axes are enabled and hold their positions. Failure: a slave whose EEPROM cannot be read has no identity to expect.
[[nodiscard]] Outcome<std::string> describe_line(const FoundLine& line);

/// Makes a text of a slave or a user's name safe for a comment or a basic string of TOML.
[[nodiscard]] std::string plain_toml(std::string_view text);
/// Whether an [[axis]] may have a rated torque or a velocity of this value.
[[nodiscard]] std::optional<double> usable_limit(const std::optional<double>& value);
/// Why a drive cannot be an axis with the scale that it reports; empty: it can.
[[nodiscard]] std::string scale_obstacle(const std::optional<double>& increments_per_revolution);

/// A path (CSV) on which the motors of these axes make `turns` revolutions and return, as below. Empty: no axes.
[[nodiscard]] std::string gentle_path(std::span<const std::string> axes, double turns);
/// A path (CSV) on which the motor of every axis of `line` makes `turns` revolutions and returns, at one revolution per
/// second at most. Positions are relative to the start. Empty: there is no axis.
[[nodiscard]] std::string gentle_path(const FoundLine& line, double turns);

/// Whether a simulation of the line needs the EEPROM image of this slave: the program cannot simulate the device, or
/// its identity differs from that of the simulated device.
[[nodiscard]] bool needs_image(const SlaveView& view);

}  // namespace driveline::cli
