#pragma once

#include "driveline/ecat_master/discovery/discovery.hpp"
#include "driveline/ecat_master/error.hpp"
#include "driveline/ecat_master/mailbox/mailbox_engine.hpp"
#include "driveline/ecat_master/process_data/pdo_configuration.hpp"
#include "driveline/wire/soe.hpp"

namespace driveline::ecat_master {

/// S-0-0016: the operation data that a drive sends in its AT, behind the drive status word.
inline constexpr wire::Idn kAtList{16};
/// S-0-0024: the operation data that a drive takes from its MDT, behind the master control word.
inline constexpr wire::Idn kMdtList{24};
/// S-0-0134: begins every MDT without being in its list.
inline constexpr wire::Idn kMasterControlWord{134};
/// S-0-0135: begins every AT without being in its list.
inline constexpr wire::Idn kDriveStatusWord{135};

/// The drives of the slave name their process data by lists of operation data: it knows SoE and no CoE.
[[nodiscard]] bool maps_by_idn(const esi::DeviceDescription& device) noexcept;

/// In PREOP: the process data of the drives of a slave, by their lists (IEC 61800-7-204, IEC 61800-7-304): one PDO per
/// direction with the number of the list, in it drive after drive; objects have the IDN as index and the drive as
/// sub-index. The lists are read, not written. A slave without these lists has the PDOs of its EEPROM. Errors: those of
/// SoeClient; SoeContent for an operation datum whose length varies.
[[nodiscard]] Result<PdoConfiguration> read_idn_mapping(MailboxEngine& engine, const SlaveInfo& slave);

}  // namespace driveline::ecat_master
