#pragma once

#include <cstdint>
#include <memory>

#include "driveline/ecat_master/eoe/eoe_service.hpp"
#include "driveline/ecat_master/error.hpp"
#include "driveline/ecat_master/mailbox/mailbox_engine.hpp"
#include "driveline/wire/eoe.hpp"

namespace driveline::ecat_master {

/// The EoE services of a slave as blocking calls. Any ordinary thread; not \rtsafe. Errors: EoeService::result().
class EoeClient {
 public:
  /// For the slave at this position; its mailbox is open in `engine`, which must outlive the client.
  EoeClient(MailboxEngine& engine, std::uint16_t position) : engine_(engine), position_(position) {}

  /// Sets the IP parameters present in `parameters`; the others do not change. Slaves differ in where they expect a
  /// parameter behind a missing one, so missing parameters are filled in with the slave's current values.
  [[nodiscard]] Result<void> set_ip(const wire::EoeIpParameters& parameters);
  /// Reads the IP parameters of the slave.
  [[nodiscard]] Result<wire::EoeIpParameters> get_ip();
  /// Sets the address filter.
  [[nodiscard]] Result<void> set_filter(const wire::EoeAddressFilter& filter);
  /// Reads the address filter of the slave.
  [[nodiscard]] Result<wire::EoeAddressFilter> get_filter();

 private:
  [[nodiscard]] Result<void> run(const std::shared_ptr<EoeService>& service);

  MailboxEngine& engine_;
  std::uint16_t position_;
};

}  // namespace driveline::ecat_master
