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

/// The EoE ports of a line. A port belongs to the position of its slave: it goes down when the slave's mailboxes are
/// closed and up when they are opened again, for example by a recovery. Any ordinary thread; not \rtsafe.
class EoePorts final : public MailboxProtocolHandler {
 public:
  /// `engine` must outlive this object or be destroyed without a further step.
  explicit EoePorts(MailboxEngine& engine) : engine_(engine) {}

  /// Returns the port of the slave at `position`, creating it if necessary; `receiver` must outlive it. From the first
  /// port on, EoE is a known protocol on this line. Does not check whether the slave supports EoE: see
  /// Master::supports_eoe().
  std::shared_ptr<EoePort> open(std::uint16_t position, EoeReceiver& receiver);
  /// Removes the port of the slave at `position`.
  void close(std::uint16_t position);
  /// The port of the slave at `position`; null: none is open.
  [[nodiscard]] std::shared_ptr<EoePort> port(std::uint16_t position) const;

  void receive(SlaveRef slave, std::span<const std::byte> service, std::chrono::nanoseconds now) override;

 private:
  MailboxEngine& engine_;
  mutable std::mutex mutex_;
  std::map<std::uint16_t, std::shared_ptr<EoePort>> ports_;
};

}  // namespace driveline::ecat_master
