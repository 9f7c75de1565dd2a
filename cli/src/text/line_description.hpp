#pragma once

#include <map>
#include <optional>
#include <span>
#include <string>

#include "line/line_view.hpp"

namespace driveline::cli {

/// Scaling of a CiA 402 drive, as far as its objects tell it.
struct DriveFacts {
  std::optional<std::uint32_t> supported_modes;     ///< 6502h, bit n: mode n + 1
  std::optional<double> increments_per_revolution;  ///< position units per motor turn
  std::optional<double> rated_torque_nm;            ///< 6076h
  std::optional<double> max_velocity_rad_s;         ///< 6080h
  /// Reads the objects; nothing: no CiA 402 drive.
  [[nodiscard]] static std::optional<DriveFacts> read(LineView& line, ecat_master::MailboxClient& mailbox);
};

/// A slave that is to be described.
struct FoundSlave {
  SlaveView view;
  std::optional<std::uint16_t> device_id;  ///< explicit device identification, when the slave has one
  std::optional<DriveFacts> drive;
  /// Where its EEPROM content is kept for a simulation of the line, beside the description; empty: nowhere.
  std::string image_file;
};

/// Everything a description is made of.
struct FoundLine {
  std::vector<FoundSlave> slaves;
  std::optional<std::string> interface;  ///< where the line is; nothing: simulated in this process
  std::string tree;                      ///< connections of the slaves, for a comment; empty: a plain line or not known
  std::string path_file;                 ///< of gentle_path(), beside the description; empty: the axes hold their place
};

/// A line description (TOML) of slaves that have been found, which `run` can use unchanged. Every slave is expected by
/// vendor, product, revision and, where it has one, serial number; it is found by alias or device identification where
/// that is unique on the line, else by its position. CiA 402 drives get an [[axis]] with the drive's scaling; where
/// that is incomplete the [[axis]] is a comment with the reason. Without `path_file` nothing moves: the axes are
/// enabled and hold their place. Failure: a slave whose EEPROM cannot be read has no identity to expect.
[[nodiscard]] Outcome<std::string> describe_line(const FoundLine& line);

/// A path (CSV) on which every axis of `line` goes `turns` revolutions of its motor and back, at no more than one
/// revolution per second. Relative to where the axes stand. Empty: there is no axis.
[[nodiscard]] std::string gentle_path(const FoundLine& line, double turns);

/// Whether a simulation of the line needs the EEPROM content of this slave: it is no drive that the program can
/// simulate, or its identity differs from that of the simulated one at this place.
[[nodiscard]] bool needs_image(const SlaveView& view);

}  // namespace driveline::cli
