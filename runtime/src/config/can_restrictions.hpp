#pragma once

#include <cstdint>
#include <string>

#include "driveline/motion/cia402/cia402.hpp"
#include "driveline/runtime/toml/toml_reader.hpp"

namespace driveline::runtime {

/// Tables of a line description that have other keys on a CAN line.
enum class CanTable : std::uint8_t {
  kRoot,   ///< the names of tables
  kBus,    ///< [bus]
  kSlave,  ///< [[slave]]
};

/// Refuses the first key of the table that a line of EtherCAT has and a CAN line cannot have, with the reason. Throws
/// ConfigError.
void refuse_ethercat_keys(TomlReader& reader, CanTable table);

/// Returns why axes on a CAN line cannot have a cyclic mode of EtherCAT: "mode 8 is EtherCAT only ...".
[[nodiscard]] std::string why_not_on_can(motion::cia402::Mode mode);

}  // namespace driveline::runtime
