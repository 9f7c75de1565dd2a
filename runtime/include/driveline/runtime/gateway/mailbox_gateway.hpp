#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "driveline/ecat_master/mailbox/mailbox_engine.hpp"
#include "driveline/runtime/error.hpp"
#include "driveline/wire/eoe.hpp"

namespace driveline::runtime {

/// Address and permitted protocols of a MailboxGateway.
struct GatewaySettings {
  wire::IpV4Address address = {127, 0, 0, 1};  ///< local address
  std::uint16_t port = 0x88A4;                 ///< UDP and TCP; 0: a free one, the same for both
  /// Permitted protocols; EoE is never among them, because it does not use the gateway.
  std::vector<wire::MailboxType> protocols = {wire::MailboxType::kAoe, wire::MailboxType::kCoe, wire::MailboxType::kFoe,
                                              wire::MailboxType::kSoe, wire::MailboxType::kVoe};
};

/// Figures of a client since it connected.
struct GatewayClient {
  std::string name;             ///< "udp 127.0.0.1:40112"
  std::uint64_t requests = 0;   ///< mailbox messages for slaves
  std::uint64_t answers = 0;    ///< mailbox messages from slaves
  std::uint64_t refused = 0;    ///< messages without an answer from a slave, most of them answered with a mailbox error
  std::uint64_t malformed = 0;  ///< invalid messages; a TCP client is disconnected then
};

/// Access of vendor tools to the mailboxes (ETG.8200). Mailbox messages arrive over UDP or TCP, each after an EtherCAT
/// header of type 5, with the station address of the slave; answers return over the same connection with the counter of
/// the request. Serves its clients in its own thread and steps the engine while a request is in progress.
class MailboxGateway {
 public:
  /// Starts to listen. `slaves`: accessible slaves. Error (kMachine): the address is not available. `engine` must
  /// outlive the gateway.
  [[nodiscard]] static Result<std::unique_ptr<MailboxGateway>> open(ecat_master::MailboxEngine& engine,
                                                                    std::vector<ecat_master::SlaveRef> slaves,
                                                                    const GatewaySettings& settings);
  /// Disconnects the clients.
  ~MailboxGateway();
  MailboxGateway(const MailboxGateway&) = delete;
  MailboxGateway& operator=(const MailboxGateway&) = delete;

  /// Returns the port on which the gateway listens.
  [[nodiscard]] std::uint16_t port() const noexcept;
  /// Returns the clients so far, at most the newest 64. Any thread.
  [[nodiscard]] std::vector<GatewayClient> clients() const;

 private:
  class Service;
  explicit MailboxGateway(std::unique_ptr<Service> service);

  std::unique_ptr<Service> service_;
};

}  // namespace driveline::runtime
