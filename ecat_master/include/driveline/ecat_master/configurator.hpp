#pragma once

#include <memory>
#include <string>
#include <vector>

#include "driveline/ecat_master/coe_client.hpp"
#include "driveline/ecat_master/discovery.hpp"
#include "driveline/ecat_master/pdo_mapping.hpp"
#include "driveline/ecat_master/process_image.hpp"

namespace driveline::ecat_master {

/// An SDO to be written at start-up, in PREOP.
struct StartupSdo {
  std::uint16_t index = 0;
  std::uint8_t subindex = 0;
  std::vector<std::byte> data;
};

/// What is planned for one slave. Zero in an identity field means: any.
struct SlavePlan {
  std::string name;
  std::uint32_t vendor_id = 0;
  std::uint32_t product_code = 0;
  std::vector<StartupSdo> startup_sdos;
  PdoConfiguration pdos;
  std::size_t group = 0;  ///< of the process image
  bool lrw = true;        ///< false: the slave does not take LRW
  /// Known by its alias, wherever it is plugged in again; otherwise its place among the others tells who it is.
  bool hot_connect = false;
};

/// A slave that has been found and is being run.
struct ConfiguredSlave {
  SlaveInfo info;
  SlavePlan plan;
  std::unique_ptr<MailboxClient> mailbox;  ///< none: the slave has no mailbox
};

/// Compares planned and found slaves by position. Errors: kSlaveCountMismatch, kIdentityMismatch. An empty plan
/// accepts anything.
[[nodiscard]] Result<void> compare_identities(std::span<const SlavePlan> plans, std::span<const SlaveInfo> found);

/// What is to be written to a slave over CoE, in PREOP; nothing to do: no steps. Error: kNoMailbox.
[[nodiscard]] Result<SdoScript> coe_script(const ConfiguredSlave& slave);

/// In INIT: writes the sync managers of the mailboxes as the slave's EEPROM has them; nothing without a mailbox.
[[nodiscard]] Result<std::optional<MailboxWindow>> write_mailbox_channels(Bus& bus, const SlaveInfo& slave);

/// Takes all slaves to INIT, sets up sync managers 0 and 1 of those with a mailbox (out of their EEPROM) and takes all
/// to PREOP.
/// Returns one mailbox client per slave, null without a mailbox.
[[nodiscard]] Result<std::vector<std::unique_ptr<MailboxClient>>> enter_pre_op(MailboxEngine& engine,
                                                                               std::span<const SlaveInfo> slaves);

/// In PREOP: writes start-up SDOs and PDO configuration of every slave, lays out the process image, writes process data
/// sync managers and FMMUs. The slaves are ready for SAFEOP afterwards.
[[nodiscard]] Result<ProcessImage> configure_process_data(MailboxEngine& engine, std::span<ConfiguredSlave> slaves,
                                                          const LayoutSettings& layout = {});

/// Adds to a refused transition what the slave says about the sizes behind it: for AL status codes 0x001D and 0x001E
/// the sync manager, the length it was given and the bytes of the PDOs assigned to it.
[[nodiscard]] Error explain_state_error(Bus& bus, std::span<ConfiguredSlave> slaves, Error error);

}  // namespace driveline::ecat_master
