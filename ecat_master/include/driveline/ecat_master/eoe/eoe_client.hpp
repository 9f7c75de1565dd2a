#pragma once

#include <cstdint>
#include <memory>

#include "driveline/ecat_master/eoe/eoe_service.hpp"
#include "driveline/ecat_master/error.hpp"
#include "driveline/ecat_master/mailbox/mailbox_engine.hpp"
#include "driveline/wire/eoe.hpp"

namespace driveline::ecat_master {

/// The EoE services of one slave for callers that wait. Any ordinary thread; not \rtsafe. Errors: EoeService::result().
class EoeClient {
 public:
  /// Client for the slave at this position; its mailbox is open in `engine`, which must outlive the client.
  EoeClient(MailboxEngine& engine, std::uint16_t position) : engine_(engine), position_(position) {}

  /// Sets those IP parameters that `parameters` has; the others are not changed. Slaves differ in where they look for a
  /// parameter behind one that is missing; so the gaps are filled with what the slave says that it has.
  [[nodiscard]] Result<void> set_ip(const wire::EoeIpParameters& parameters);
  /// The IP parameters that the slave has.
  [[nodiscard]] Result<wire::EoeIpParameters> get_ip();
  /// Sets the address filter.
  [[nodiscard]] Result<void> set_filter(const wire::EoeAddressFilter& filter);
  /// The address filter that the slave has.
  [[nodiscard]] Result<wire::EoeAddressFilter> get_filter();

 private:
  [[nodiscard]] Result<void> run(const std::shared_ptr<EoeService>& service);

  MailboxEngine& engine_;
  std::uint16_t position_;
};

}  // namespace driveline::ecat_master
