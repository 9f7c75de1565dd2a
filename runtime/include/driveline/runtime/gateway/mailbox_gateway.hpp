#pragma once

#include <sys/types.h>

#include <chrono>
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
  /// Users of this machine who may change parameters and files of slaves; over TCP only, because the user behind a
  /// datagram is not known. Without users and addresses, clients can only read.
  std::vector<uid_t> write_users{};
  std::vector<wire::IpV4Address> write_addresses{};  ///< addresses whose clients may change parameters and files
  /// Time after which a silent TCP client may lose its connection to a new one. A client whose message is incomplete
  /// for that long is disconnected.
  std::chrono::nanoseconds silence = std::chrono::seconds{3};
};

/// Figures of a client since it connected.
struct GatewayClient {
  std::string name;             ///< "udp 127.0.0.1:40112"
  std::uint64_t requests = 0;   ///< mailbox messages for slaves
  std::uint64_t answers = 0;    ///< mailbox messages from slaves
  std::uint64_t refused = 0;    ///< messages without an answer from a slave, most of them answered with a mailbox error
  std::uint64_t malformed = 0;  ///< invalid messages; a TCP client is disconnected then
};

/// A message of a client that changes a slave.
struct GatewayWrite {
  std::string client;       ///< name of the client
  std::uint16_t slave = 0;  ///< position
  std::string what;         ///< "607Dh:1 = 0x80000000", "file firmware.bin", "S-0-0047"
  bool refused = false;     ///< the client may only read
};

/// Access of vendor tools to the mailboxes (ETG.8200). Clients read; changes are for the users and addresses that the
/// settings name. Mailbox messages arrive over UDP or TCP, each after an EtherCAT
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

  /// Ends the service; clients() and take_writes() remain available.
  void stop();
  /// Returns the port on which the gateway listens.
  [[nodiscard]] std::uint16_t port() const noexcept;
  /// Returns the clients so far, at most the newest 64. Any thread.
  [[nodiscard]] std::vector<GatewayClient> clients() const;
  /// Returns the changes since the last call: every one that was passed on to a slave, and the first one that was
  /// refused since the gateway opened. Any thread.
  [[nodiscard]] std::vector<GatewayWrite> take_writes();

 private:
  class Service;
  explicit MailboxGateway(std::unique_ptr<Service> service);

  std::unique_ptr<Service> service_;
};

}  // namespace driveline::runtime
