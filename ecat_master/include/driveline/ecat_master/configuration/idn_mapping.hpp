#pragma once

#include "driveline/ecat_master/discovery/discovery.hpp"
#include "driveline/ecat_master/error.hpp"
#include "driveline/ecat_master/mailbox/mailbox_engine.hpp"
#include "driveline/motion/cia301/pdo_configuration.hpp"
#include "driveline/wire/soe.hpp"

namespace driveline::ecat_master {

/// S-0-0016: list of the operation data that a drive sends in its AT, after the drive status word.
inline constexpr wire::Idn kAtList{16};
/// S-0-0024: list of the operation data that a drive receives in its MDT, after the master control word.
inline constexpr wire::Idn kMdtList{24};
/// S-0-0134: first word of every MDT, not in its list.
inline constexpr wire::Idn kMasterControlWord{134};
/// S-0-0135: first word of every AT, not in its list.
inline constexpr wire::Idn kDriveStatusWord{135};

/// Whether the drives of the slave define their process data by lists of operation data: it supports SoE and not CoE.
[[nodiscard]] bool maps_by_idn(const esi::DeviceDescription& device) noexcept;

/// In PREOP: reads the process data of the drives of a slave from their lists (IEC 61800-7-204, IEC 61800-7-304). The
/// result has one PDO per direction with the number of the list, containing drive after drive; objects have the IDN as
/// index and the drive as sub-index. The lists are not written. A slave without these lists has the PDOs of its EEPROM.
/// Errors: those of SoeClient; SoeContent for an operation datum of variable length.
[[nodiscard]] Result<motion::PdoConfiguration> read_idn_mapping(MailboxEngine& engine, const SlaveInfo& slave);

}  // namespace driveline::ecat_master
