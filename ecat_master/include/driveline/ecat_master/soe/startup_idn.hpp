#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <variant>
#include <vector>

#include "driveline/ecat_master/error/facts.hpp"
#include "driveline/motion/cia301/startup_sdo.hpp"

namespace driveline::ecat_master {

/// A value of an operation datum to be written to a drive at start-up. Its format is known only to the drive: its
/// attribute is read before the write.
struct StartupIdn {
  /// A number, an IDN or a text.
  using Single = std::string;
  /// Elements of a list: numbers or IDNs.
  using List = std::vector<std::string>;
  /// The value as in a mailbox message: bytes in wire order, a list behind its header.
  using Raw = std::vector<std::byte>;

  facts::SoeDatum at{};                                             ///< drive and operation datum
  motion::StartupState in = motion::StartupState::kPreOperational;  ///< state in which it is written
  std::variant<Single, List, Raw> value{};  ///< 3 starts a procedure command, and awaits its end
  bool read_back = true;                    ///< it is read again after the write and must be the same; commands are not
  std::string place{};  ///< where it is planned, for messages: "line.toml:12: [slave.idn] number"; may be empty
};

}  // namespace driveline::ecat_master
