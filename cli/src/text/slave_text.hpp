#pragma once

#include <nlohmann/json.hpp>
#include <span>
#include <string>

#include "line/line_view.hpp"

namespace driveline::cli {

/// One line per slave as the IgH tool prints them: position, alias:position, AL state, + or E (error flag), name.
[[nodiscard]] std::string slave_table(std::span<const SlaveView> slaves);

/// Facts about a slave besides its EEPROM.
struct SlaveFacts {
  ecat_master::EscInformation controller;
  std::array<std::optional<std::uint16_t>, 4> neighbours{};  ///< position of the slave at each port
};

/// The slaves at the ports of slave `position`; none if the topology has no slaves.
[[nodiscard]] std::array<std::optional<std::uint16_t>, 4> neighbours_of(const ecat_master::Topology& topology,
                                                                        std::size_t position);

/// All facts about a slave.
[[nodiscard]] std::string slave_details(const SlaveView& view, const SlaveFacts& facts);

[[nodiscard]] nlohmann::json slave_json(const SlaveView& view, const SlaveFacts& facts);

/// "PREOP", or "0x5" for an unknown state.
[[nodiscard]] std::string state_text(wire::AlState state);

}  // namespace driveline::cli
