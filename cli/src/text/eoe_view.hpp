#pragma once

#include <nlohmann/json_fwd.hpp>
#include <span>
#include <string>
#include <vector>

#include "driveline/runtime/eoe/eoe_report.hpp"
#include "driveline/runtime/gateway/mailbox_gateway.hpp"

namespace driveline::cli {

/// EoE parameters of a slave.
struct EoeAddressView {
  std::size_t position = 0;
  std::string name;
  bool eoe = false;                    ///< the EEPROM lists EoE as a mailbox protocol
  wire::EoeIpParameters parameters{};  ///< parameters as stored in the slave
  std::string trouble;                 ///< why the parameters are unknown; empty: they are known
};

/// The ports of a running line: as a table and as a document.
[[nodiscard]] std::string to_text(const runtime::EoeReport& report);
[[nodiscard]] nlohmann::json to_json(const runtime::EoeReport& report);

/// The addresses of the slaves of a line that does not run: as a table and as a document.
[[nodiscard]] std::string to_text(std::span<const EoeAddressView> slaves);
[[nodiscard]] nlohmann::json to_json(std::span<const EoeAddressView> slaves);

/// The clients of the mailbox gateway: one line each, and as a document.
[[nodiscard]] std::string to_text(std::span<const runtime::GatewayClient> clients);
[[nodiscard]] nlohmann::json to_json(std::span<const runtime::GatewayClient> clients);

}  // namespace driveline::cli
