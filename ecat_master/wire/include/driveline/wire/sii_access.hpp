#pragma once

#include <cstddef>
#include <cstdint>

/// Bits of the SII EEPROM interface registers 0x0500-0x050F (ETG.1000.4 6.4, ET1100 data sheet section II).
namespace driveline::wire::sii_access {

/// Size of the control/status, address and data registers 0x0502..0x050F, in bytes.
inline constexpr std::size_t kInterfaceBytes = 14;

/// Word addresses in the EEPROM (ETG.1000.6 Table 16).
inline constexpr std::size_t kAliasWord = 4;
inline constexpr std::size_t kChecksumWord = 7;  ///< low byte: CRC of the words before it

/// EEPROM configuration 0x0500.
inline constexpr std::uint8_t kConfigPdiOwns = 0x01;
inline constexpr std::uint8_t kConfigForceEcat = 0x02;  ///< revokes the application's access to the interface

/// EEPROM control/status 0x0502.
inline constexpr std::uint16_t kWriteEnable = 0x0001;
inline constexpr std::uint16_t kReads8Bytes = 0x0040;       ///< status: 8 bytes per read, else 4
inline constexpr std::uint16_t kTwoByteAddress = 0x0080;    ///< status: EEPROM larger than 16 kbit
inline constexpr std::uint16_t kCommandMask = 0x0700;       ///< bits of the command
inline constexpr std::uint16_t kCommandRead = 0x0100;       ///< reads from the address in 0x0504
inline constexpr std::uint16_t kCommandWrite = 0x0200;      ///< writes a word; needs kWriteEnable in the same frame
inline constexpr std::uint16_t kCommandReload = 0x0400;     ///< reloads the configuration area
inline constexpr std::uint16_t kErrorChecksum = 0x0800;     ///< checksum error in the ESC configuration area
inline constexpr std::uint16_t kErrorNotLoaded = 0x1000;    ///< device information not loaded
inline constexpr std::uint16_t kErrorAcknowledge = 0x2000;  ///< missing acknowledge or invalid command
inline constexpr std::uint16_t kErrorWriteEnable = 0x4000;  ///< write without write enable
inline constexpr std::uint16_t kBusy = 0x8000;              ///< a command is being executed; no other is accepted

}  // namespace driveline::wire::sii_access
