#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "driveline/wire/registers.hpp"
#include "failure.hpp"

namespace driveline::cli {

/// A register named on the command line.
struct RegisterAddress {
  std::uint16_t address = 0;
  std::uint16_t bytes = 0;                 ///< size of an element; 0: the address is not in the register table
  const wire::RegisterRow* row = nullptr;  ///< null: the address is not in the register table
};

/// Finds a register in the register table (wire/registers.hpp): by address (0x0130, 0130h, 304) or by name, ignoring
/// case, blanks, underscores and dashes: "AL status", al_status. An unambiguous part of a name is sufficient. [n]
/// selects an element of an array: "FMMU[1]". Failure: status 2, lists the candidates.
[[nodiscard]] Outcome<RegisterAddress> find_register(std::string_view text);

/// Bytes of an element; for FMMUs and sync managers the whole channel.
[[nodiscard]] std::uint16_t element_bytes(const wire::RegisterRow& row) noexcept;

/// The register table as text: address, bytes, elements, access by EtherCAT, name.
[[nodiscard]] std::string register_table();

}  // namespace driveline::cli
