#pragma once

#include <netinet/in.h>
#include <sys/types.h>

#include <optional>
#include <string>

#include "driveline/runtime/gateway/mailbox_gateway.hpp"
#include "gateway/gateway_frame.hpp"

namespace driveline::runtime {

/// What a mailbox message changes in its slave.
struct MailChange {
  std::string what;        ///< "607Dh:1 = 0x80000000", "file firmware.bin", "S-0-0047"
  bool continued = false;  ///< part of a transfer whose first message named the object
};

/// Returns what the message changes; none: it only reads. A message of unknown content counts as a change.
[[nodiscard]] std::optional<MailChange> change_of(const GatewayMail& mail);

/// Returns the refusal of a message that changes something, in its own protocol: an SDO abort (local control), a FoE or
/// SoE error, or a mailbox error.
[[nodiscard]] GatewayMail refusal_of(const GatewayMail& mail);

/// Whether a client may change parameters of slaves. `user`: user of a TCP client on this machine, if known.
[[nodiscard]] bool may_write(const sockaddr_in& client, std::optional<uid_t> user, const GatewaySettings& settings);

}  // namespace driveline::runtime
