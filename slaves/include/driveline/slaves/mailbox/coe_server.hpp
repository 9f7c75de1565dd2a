#pragma once

#include <array>

#include "driveline/slaves/coe/sdo_information.hpp"
#include "driveline/slaves/coe/sdo_server.hpp"
#include "driveline/slaves/mailbox/mailbox_server.hpp"

namespace driveline::slaves {

/// CANopen over EtherCAT server of a device: SDO, SDO information and the emergency queue (ETG.1000.6 5.6).
class CoeServer : public MailboxProtocol {
 public:
  /// Capacity of the emergency queue.
  static constexpr std::size_t kEmergencyDepth = 8;

  /// Features of the device beyond the single-entry SDO services.
  struct Options {
    bool complete_access = false;  ///< whole objects in one SDO transfer
    bool sdo_information = true;   ///< object list and descriptions
    bool fill_sign = false;        ///< see SdoServer::Options
  };

  /// Both references must outlive this. Allocates memory for the longest transfer of the dictionary.
  CoeServer(ObjectDictionary& dictionary, DictionaryOwner& owner, const Options& options);
  /// Uses the default options.
  CoeServer(ObjectDictionary& dictionary, DictionaryOwner& owner) : CoeServer(dictionary, owner, Options{}) {}

  /// Queues an emergency for the master; a full queue drops and counts the oldest. \rtsafe
  void raise(const wire::Emergency& emergency) noexcept;
  /// Returns the number of emergencies dropped because the master fetched too late. \rtsafe
  [[nodiscard]] std::uint64_t lost_emergencies() const noexcept { return lost_; }

  /// CoE, type 3.
  [[nodiscard]] wire::MailboxType type() const noexcept override { return wire::MailboxType::kCoe; }
  [[nodiscard]] tl::expected<std::size_t, wire::MailboxErrorCode> request(const MailboxRequest& request,
                                                                          std::span<std::byte> out) override;
  [[nodiscard]] std::size_t unsolicited(std::span<std::byte> out) override;
  void stop() noexcept override;

 private:
  bool has_information_;
  SdoServer sdo_;
  SdoInformation information_;
  std::array<wire::Emergency, kEmergencyDepth> emergencies_{};
  std::size_t first_ = 0;
  std::size_t count_ = 0;
  std::uint64_t lost_ = 0;
};

}  // namespace driveline::slaves
