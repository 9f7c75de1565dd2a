#pragma once

#include <string>
#include <vector>

#include "driveline/ecat_master/configuration/configurator.hpp"
#include "driveline/ecat_master/error/configuration_finding.hpp"

namespace driveline::ecat_master {

/// Reads sync managers, FMMUs, watchdogs and assigned PDOs of a slave back and compares them with what was planned,
/// with each other, and with the EEPROM where a description file went before it. Findings that `code` is about come
/// first; for refused mailboxes (0x0016) only these are checked. `image`: as laid out; empty before that. Registers and
/// objects that cannot be read are left out. Not real-time safe.
[[nodiscard]] std::vector<ConfigurationFinding> check_configuration(Bus& bus, const ConfiguredSlave& slave,
                                                                    const ProcessImage& image, wire::AlStatusCode code);

/// Adds the first finding about its slave to a refused transition, for describe(). Returns other errors unchanged.
[[nodiscard]] Error explain_state_error(Bus& bus, std::span<const ConfiguredSlave> slaves, const ProcessImage& image,
                                        const Error& error);

/// describe(error), for a refused transition with all findings about its slave.
[[nodiscard]] std::string describe_with_findings(Bus& bus, std::span<const ConfiguredSlave> slaves,
                                                 const ProcessImage& image, const Error& error);

}  // namespace driveline::ecat_master
