#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <tl/expected.hpp>
#include <vector>

namespace driveline::esi {

/// A value of an operation datum (SoE) that another master writes at start-up.
struct SoeStartEntry {
  std::uint8_t drive = 0;         ///< drive of the slave, 0 to 7
  std::uint16_t idn = 0;          ///< number as in a mailbox message: bit 15 P, bits 12 to 14 parameter set
  bool before_op = false;         ///< written in SAFEOP (SO); else in PREOP (PS)
  std::vector<std::byte> data{};  ///< value as in a mailbox message, a list behind its header
  std::string comment{};          ///< name in the file; may be empty
};

/// A command of the file that cannot be taken over.
struct SoeLeftOut {
  std::size_t line = 0;  ///< line of the command in the file, from 1
  std::string what{};    ///< number and name as in the file
  std::string why{};     ///< reason
};

/// The content of a start-up list.
struct SoeStartList {
  std::vector<SoeStartEntry> entries{};  ///< in the order of the file
  std::vector<SoeLeftOut> left_out{};    ///< the other commands
};

/// Why a file is no start-up list.
struct NoSoeStartList {
  bool xml = false;        ///< it is XML, but has no command with an IDN; else it is no XML
  std::size_t offset = 0;  ///< no XML: byte of the file where it ends
  std::string problem{};   ///< no XML: the problem
};

/// Returns the reason as the end of a sentence that begins with the file.
[[nodiscard]] std::string describe(const NoSoeStartList& error);

/// Reads the SoE start-up list of a slave in XML: all `<InitCmd>` with an `<IDN>` of a file, as TwinCAT exports them
/// and as they are in the mailbox of a slave of an ENI file (ETG.2100). Commands that are no write of a value (OpCode
/// 3, Elements 64), of other transitions than PS and SO, of a drive above 7, with unreadable or no data, and the
/// password S-0-0267 are left out.
[[nodiscard]] tl::expected<SoeStartList, NoSoeStartList> read_soe_start_list(std::string_view text);

}  // namespace driveline::esi
