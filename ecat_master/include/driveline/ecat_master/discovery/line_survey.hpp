#pragma once

#include <array>
#include <vector>

#include "driveline/ecat_master/bus/bus.hpp"
#include "driveline/ecat_master/state_machine.hpp"
#include "driveline/wire/dl.hpp"

namespace driveline::ecat_master {

/// A slave on a line that another master may be running.
struct SurveyedSlave {
  SlaveRef ref;             ///< position on the line and station address
  std::uint16_t alias = 0;  ///< configured station alias, register 0x0012
  AlReport al;              ///< state and AL status code
};

/// Which slaves a survey may assign station addresses to.
enum class SurveyAddresses : std::uint8_t {
  kComplete,  ///< all slaves, unless each already has a unique address
  kLeave      ///< none, because another master uses the existing addresses; a slave without address is only known by
              ///< position
};

/// Finds the slaves without disturbing the line: no state, error, sync manager or FMMU changes. Usable station
/// addresses stay; if an address is missing, or two slaves have the same, all slaves get new addresses as in
/// discover(), because further access uses station addresses; unless `addresses` is kLeave.
///
/// Errors: NoSlaves, TooManySlaves, WorkingCounter for a slave that does not answer, those of the bus. Not real-time
/// safe.
[[nodiscard]] Result<std::vector<SurveyedSlave>> survey(Bus& bus,
                                                        SurveyAddresses addresses = SurveyAddresses::kComplete);

/// EEPROM content of each slave, or why it could not be read, independent of the other slaves. Not real-time safe.
[[nodiscard]] std::vector<Result<std::vector<std::byte>>> read_each_sii(Bus& bus, std::span<const SlaveRef> slaves);

/// Type, features (registers 0x0000..0x0009) and ports of a slave controller.
struct EscInformation {
  std::uint8_t type = 0;                           ///< register 0x0000, see esc_type_name()
  std::uint8_t revision = 0;                       ///< register 0x0001
  std::uint16_t build = 0;                         ///< register 0x0002
  std::uint8_t fmmus = 0;                          ///< number of FMMUs
  std::uint8_t sync_managers = 0;                  ///< number of sync managers
  std::uint8_t ram_kib = 0;                        ///< process data memory in KiB
  std::uint8_t port_descriptor = 0;                ///< two bits per port, see port_type()
  std::uint16_t features = 0;                      ///< register 0x0008, see esc_feature
  wire::DlStatus dl_status;                        ///< links, loops and communication of the ports
  std::array<std::uint32_t, 4> receive_time_ns{};  ///< receive times as last latched, local time

  /// Kind of a port (register 0x0007).
  enum class PortType : std::uint8_t { kNotImplemented = 0, kNotConfigured = 1, kEbus = 2, kMii = 3 };
  /// Kind of a port, 0 to 3. \rtsafe
  [[nodiscard]] PortType port_type(unsigned port) const noexcept {
    return static_cast<PortType>((port_descriptor >> (2 * port)) & 3U);
  }
};

/// Bits of register 0x0008 (ETG.1000.4 Table 31).
namespace esc_feature {
inline constexpr std::uint16_t kFmmuBytesOnly = 0x0001;  ///< FMMUs map whole bytes
/// The controller has distributed clocks.
inline constexpr std::uint16_t kDistributedClocks = 0x0004;
/// The clocks have 64 bits, else 32.
inline constexpr std::uint16_t kDc64Bit = 0x0008;
inline constexpr std::uint16_t kNoLrw = 0x0200;          ///< LRW not supported
inline constexpr std::uint16_t kFixedChannels = 0x0800;  ///< FMMUs and sync managers are fixed
}  // namespace esc_feature

/// Reads the information of a slave without changing anything. Errors: WorkingCounter, those of the bus. Not real-time
/// safe.
[[nodiscard]] Result<EscInformation> read_esc_information(Bus& bus, SlaveRef slave);

/// Name of the controller by its type register, e.g. "ET1100"; empty for an unknown type (ESC data sheet II, 0x0000).
[[nodiscard]] std::string_view esc_type_name(std::uint8_t type) noexcept;

}  // namespace driveline::ecat_master
