#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "driveline/ecat_master/error.hpp"
#include "driveline/ecat_master/mailbox/dialogue.hpp"
#include "driveline/wire/eoe.hpp"

namespace driveline::ecat_master {

/// An EoE service with its answer: sets or reads the IP parameters or the address filter of a slave (ETG.1000.6 5.7).
/// Fragments of Ethernet frames that arrive before the answer go to the port.
class EoeService final : public MailboxDialogue {
 public:
  /// Sets IP parameters, each sent at its fixed offset; parameters missing in `parameters` do not change. Slaves
  /// interpret gaps differently, see EoeClient::set_ip().
  [[nodiscard]] static std::shared_ptr<EoeService> set_ip(const wire::EoeIpParameters& parameters);
  /// Reads IP parameters.
  [[nodiscard]] static std::shared_ptr<EoeService> get_ip();
  /// Sets the address filter.
  [[nodiscard]] static std::shared_ptr<EoeService> set_filter(const wire::EoeAddressFilter& filter);
  /// Reads the address filter.
  [[nodiscard]] static std::shared_ptr<EoeService> get_filter();

  /// After done(): the result of the service. Errors: EoeRefused, Mailbox*, ProcessDataSize, those of the bus.
  [[nodiscard]] const Result<void>& result() const noexcept { return result_; }
  /// After done() without error: the answer to get_ip().
  [[nodiscard]] const wire::EoeIpParameters& ip() const noexcept { return ip_; }
  /// After done() without error: the answer to get_filter().
  [[nodiscard]] const wire::EoeAddressFilter& filter() const noexcept { return filter_; }

  void begin(std::uint16_t position, MailboxRoom room) override;
  [[nodiscard]] std::span<const std::byte> outgoing() const noexcept override { return outgoing_; }
  [[nodiscard]] bool repeatable() const noexcept override { return true; }
  [[nodiscard]] Reaction receive(std::span<const std::byte> service) override;
  void fail(const Error& error) override;

 private:
  EoeService(wire::EoeType request, std::span<const std::byte> data);
  [[nodiscard]] bool take(std::span<const std::byte> data);

  wire::EoeType request_;
  std::vector<std::byte> outgoing_;
  std::uint16_t position_ = Error::kNoSlave;
  Result<void> result_;
  wire::EoeIpParameters ip_;
  wire::EoeAddressFilter filter_;
};

}  // namespace driveline::ecat_master
