#pragma once

#include <string>
#include <vector>

#include "driveline/ecat_master/configuration/configurator.hpp"
#include "driveline/ecat_master/error/configuration_finding.hpp"

namespace driveline::ecat_master {

/// Reads back sync managers, FMMUs, watchdogs and assigned PDOs of a slave and compares them with the plan, with each
/// other, and with the EEPROM where a description file replaced it. Findings related to `code` come first; for refused
/// mailboxes (0x0016) only the mailboxes are checked. `image`: the laid-out process image; empty before that. Skips
/// unreadable registers and objects. Not real-time safe.
[[nodiscard]] std::vector<ConfigurationFinding> check_configuration(Bus& bus, const ConfiguredSlave& slave,
                                                                    const ProcessImage& image, wire::AlStatusCode code);

/// Adds the first finding about the slave to a refused transition, for describe(). Returns other errors unchanged.
[[nodiscard]] Error explain_state_error(Bus& bus, std::span<const ConfiguredSlave> slaves, const ProcessImage& image,
                                        const Error& error);

/// Like describe(error), with all findings about the slave for a refused transition.
[[nodiscard]] std::string describe_with_findings(Bus& bus, std::span<const ConfiguredSlave> slaves,
                                                 const ProcessImage& image, const Error& error);

}  // namespace driveline::ecat_master
