#pragma once

#include <string>
#include <vector>

#include "driveline/ecat_master/configuration/configurator.hpp"
#include "driveline/ecat_master/error/configuration_finding.hpp"

namespace driveline::ecat_master {

/// Reads sync managers, FMMUs, watchdogs and assigned PDOs of a slave back and compares them with what was planned,
/// with each other, and with the EEPROM where a description file went before it. What `code` is about comes first; for
/// refused mailboxes (0x0016) nothing but these is looked at. `image` as it was laid out; empty before. Registers that
/// cannot be read and objects that the slave does not tell are left out. Not real-time safe.
[[nodiscard]] std::vector<ConfigurationFinding> check_configuration(Bus& bus, const ConfiguredSlave& slave,
                                                                    const ProcessImage& image, wire::AlStatusCode code);

/// A refused transition with the first finding about its slave in it; describe() tells it. Other errors as they are.
[[nodiscard]] Error explain_state_error(Bus& bus, std::span<const ConfiguredSlave> slaves, const ProcessImage& image,
                                        const Error& error);

/// describe(error), for a refused transition with all findings about its slave.
[[nodiscard]] std::string describe_with_findings(Bus& bus, std::span<const ConfiguredSlave> slaves,
                                                 const ProcessImage& image, const Error& error);

}  // namespace driveline::ecat_master
