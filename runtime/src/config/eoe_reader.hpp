#pragma once

#include "driveline/runtime/config/line_config.hpp"
#include "driveline/runtime/toml/toml_reader.hpp"

namespace driveline::runtime {

/// Reads `ip` of a [[slave]]; none if it is left out.
[[nodiscard]] std::optional<wire::IpV4Address> read_slave_ip(TomlReader& reader,
                                                             const std::vector<SlaveConfig>& others);

/// Reads [eoe] for the slaves of `config` and checks their addresses.
void read_eoe(TomlReader reader, LineConfig& config);

}  // namespace driveline::runtime
