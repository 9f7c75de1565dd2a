#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "driveline/wire/registers.hpp"
#include "failure.hpp"

namespace driveline::cli {

/// A register as the command line names it.
struct RegisterAddress {
  std::uint16_t address = 0;
  std::uint16_t bytes = 0;                 ///< of one element; 0: the address is no register of the table
  const wire::RegisterRow* row = nullptr;  ///< nothing: the address is no register of the table
};

/// Finds a register of the one table (wire/registers.hpp): by address (0x0130, 0130h, 304) or by name, in which case,
/// blanks, underscores and dashes do not count: "AL status", al_status. An unambiguous part of a name will do. An
/// element of an array is chosen with [n]: "FMMU[1]". Failure: status 2, lists the candidates.
[[nodiscard]] Outcome<RegisterAddress> find_register(std::string_view text);

/// Bytes of one element: of FMMUs and sync managers the whole channel.
[[nodiscard]] std::uint16_t element_bytes(const wire::RegisterRow& row) noexcept;

/// The table for people: address, bytes, elements, access by EtherCAT, name.
[[nodiscard]] std::string register_table();

}  // namespace driveline::cli
