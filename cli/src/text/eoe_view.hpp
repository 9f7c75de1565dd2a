#pragma once

#include <nlohmann/json_fwd.hpp>
#include <span>
#include <string>
#include <vector>

#include "driveline/runtime/eoe/eoe_report.hpp"
#include "driveline/runtime/gateway/mailbox_gateway.hpp"

namespace driveline::cli {

/// What a slave says of its EoE port.
struct EoeAddressView {
  std::size_t position = 0;
  std::string name;
  bool eoe = false;                    ///< its EEPROM knows EoE
  wire::EoeIpParameters parameters{};  ///< as the slave has them
  std::string trouble;                 ///< why they are not known; empty: they are
};

/// Ports of a running line: a table, and its document.
[[nodiscard]] std::string to_text(const runtime::EoeReport& report);
[[nodiscard]] nlohmann::json to_json(const runtime::EoeReport& report);

/// Addresses of the slaves of a line that is not run: a table, and its document.
[[nodiscard]] std::string to_text(std::span<const EoeAddressView> slaves);
[[nodiscard]] nlohmann::json to_json(std::span<const EoeAddressView> slaves);

/// Clients of the mailbox gateway, a line each, and their document.
[[nodiscard]] std::string to_text(std::span<const runtime::GatewayClient> clients);
[[nodiscard]] nlohmann::json to_json(std::span<const runtime::GatewayClient> clients);

}  // namespace driveline::cli
