#pragma once

#include <cstdint>
#include <string_view>

namespace driveline::wire {

/// EtherCAT datagram commands (ETG.1000.4 5.4, Table "EtherCAT command types"). Other values may arrive and are kept.
enum class Command : std::uint8_t {
  kNop = 0,    ///< no operation
  kAprd = 1,   ///< auto-increment physical read
  kApwr = 2,   ///< auto-increment physical write
  kAprw = 3,   ///< auto-increment physical read and write
  kFprd = 4,   ///< configured address physical read
  kFpwr = 5,   ///< configured address physical write
  kFprw = 6,   ///< configured address physical read and write
  kBrd = 7,    ///< broadcast read
  kBwr = 8,    ///< broadcast write
  kBrw = 9,    ///< broadcast read and write
  kLrd = 10,   ///< logical read
  kLwr = 11,   ///< logical write
  kLrw = 12,   ///< logical read and write
  kArmw = 13,  ///< auto-increment: the addressed slave reads, all others write
  kFrmw = 14,  ///< configured address: the addressed slave reads, all others write
};

/// True for the 15 commands of the standard.
[[nodiscard]] constexpr bool is_known(Command command) noexcept {
  return static_cast<std::uint8_t>(command) <= 14;
}

/// True when the 32-bit address field is a logical address (LRD, LWR, LRW).
[[nodiscard]] constexpr bool is_logical(Command command) noexcept {
  return command == Command::kLrd || command == Command::kLwr || command == Command::kLrw;
}

/// Mnemonic of the standard, "?" for an unknown value.
[[nodiscard]] constexpr std::string_view to_text(Command command) noexcept {
  constexpr std::string_view kNames[] = {"NOP", "APRD", "APWR", "APRW", "FPRD", "FPWR", "FPRW", "BRD",
                                         "BWR", "BRW",  "LRD",  "LWR",  "LRW",  "ARMW", "FRMW"};
  return is_known(command) ? kNames[static_cast<std::uint8_t>(command)] : "?";
}

}  // namespace driveline::wire
