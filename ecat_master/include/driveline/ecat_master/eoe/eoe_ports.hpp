#pragma once

#include <chrono>
#include <cstdint>
#include <map>
#include <memory>
#include <mutex>
#include <span>

#include "driveline/ecat_master/bus/bus.hpp"
#include "driveline/ecat_master/eoe/eoe_port.hpp"
#include "driveline/ecat_master/mailbox/mailbox_engine.hpp"

namespace driveline::ecat_master {

/// The EoE ports of a line. A port belongs to the place of its slave: it goes down when the slave's mailboxes are
/// closed and up when they are opened again, as after a recovery. Any ordinary thread; not \rtsafe.
class EoePorts final : public MailboxProtocolHandler {
 public:
  /// `engine` must outlive it or be destroyed without a further step.
  explicit EoePorts(MailboxEngine& engine) : engine_(engine) {}

  /// The port of the slave at `position`, made when there is none; `receiver` must outlive it. From the first port on
  /// EoE is a known protocol on this line. Whether a slave knows EoE is not asked: Master::supports_eoe().
  std::shared_ptr<EoePort> open(std::uint16_t position, EoeReceiver& receiver);
  /// Takes the port of the slave at `position` away.
  void close(std::uint16_t position);
  /// Null: none is open.
  [[nodiscard]] std::shared_ptr<EoePort> port(std::uint16_t position) const;

  void receive(SlaveRef slave, std::span<const std::byte> service, std::chrono::nanoseconds now) override;

 private:
  MailboxEngine& engine_;
  mutable std::mutex mutex_;
  std::map<std::uint16_t, std::shared_ptr<EoePort>> ports_;
};

}  // namespace driveline::ecat_master
