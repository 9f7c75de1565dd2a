#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "driveline/ecat_master/mailbox/mailbox_engine.hpp"
#include "driveline/runtime/error.hpp"
#include "driveline/wire/eoe.hpp"

namespace driveline::runtime {

/// What a MailboxGateway lets through, and where it listens.
struct GatewaySettings {
  wire::IpV4Address address = {127, 0, 0, 1};  ///< local address
  std::uint16_t port = 0x88A4;                 ///< UDP and TCP; 0: one that is free, the same for both
  /// Protocols that pass; EoE never does, it has a way of its own.
  std::vector<wire::MailboxType> protocols = {wire::MailboxType::kAoe, wire::MailboxType::kCoe, wire::MailboxType::kFoe,
                                              wire::MailboxType::kSoe, wire::MailboxType::kVoe};
};

/// One client since it has come.
struct GatewayClient {
  std::string name;             ///< "udp 127.0.0.1:40112"
  std::uint64_t requests = 0;   ///< mails for slaves
  std::uint64_t answers = 0;    ///< mails from slaves
  std::uint64_t refused = 0;    ///< mails without an answer from a slave, most of them answered with a mailbox error
  std::uint64_t malformed = 0;  ///< no mail; a TCP client is sent away then
};

/// The way for tools of vendors to the mailboxes (ETG.8200): mails come in over UDP or TCP, each behind an EtherCAT
/// header of type 5, with the station address of the slave, and their answers go back the same way with the counter of
/// the request. Serves its clients in a thread of its own and steps the engine while something is under way.
class MailboxGateway {
 public:
  /// Listens. `slaves`: those that may be reached. Error (kMachine): the address cannot be had. `engine` must outlive
  /// the gateway.
  [[nodiscard]] static Result<std::unique_ptr<MailboxGateway>> open(ecat_master::MailboxEngine& engine,
                                                                    std::vector<ecat_master::SlaveRef> slaves,
                                                                    const GatewaySettings& settings);
  /// Sends the clients away.
  ~MailboxGateway();
  MailboxGateway(const MailboxGateway&) = delete;
  MailboxGateway& operator=(const MailboxGateway&) = delete;

  /// Port that it listens at.
  [[nodiscard]] std::uint16_t port() const noexcept;
  /// The clients so far, the newest 64 of them. Any thread.
  [[nodiscard]] std::vector<GatewayClient> clients() const;

 private:
  class Service;
  explicit MailboxGateway(std::unique_ptr<Service> service);

  std::unique_ptr<Service> service_;
};

}  // namespace driveline::runtime
