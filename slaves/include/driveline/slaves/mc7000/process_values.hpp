#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "driveline/slaves/mc7000/posmod_location.hpp"
#include "driveline/slaves/mc7000/program.hpp"

namespace driveline::slaves::mc7000 {

/// Variables H00 to H99 (parameter 528, POVAR) and flags M00 to M99 (parameter 529, POMER) of a drive. Fields are 0 to
/// 99 in all calls.
class ProcessValues {
 public:
  /// Size of RxPDO21 in bytes.
  static constexpr std::size_t kRxPdo21Size = 8;

  /// Returns a variable. \rtsafe
  [[nodiscard]] std::int32_t variable(std::size_t field) const noexcept { return variables_[field]; }
  /// Stores a variable. \rtsafe
  void set_variable(std::size_t field, std::int32_t value) noexcept { variables_[field] = value; }
  /// Returns the byte of a flag; any value but 0 is set. \rtsafe
  [[nodiscard]] std::uint8_t flag(std::size_t field) const noexcept { return flags_[field]; }
  /// Stores the byte of a flag; no TxPDO is sent. \rtsafe
  void set_flag(std::size_t field, std::uint8_t value) noexcept { flags_[field] = value; }
  /// Returns the number in the text, or the value of the variable that it names. \rtsafe
  [[nodiscard]] std::int32_t value_of(const Operand& operand) const noexcept {
    return operand.variable ? variable(static_cast<std::size_t>(operand.value)) : operand.value;
  }

  /// Writes what an RxPDO21 brings: byte 0 says what (F0h a variable, 0Fh a flag, FFh both, others nothing), byte 1 is
  /// the field of the variable, 2 to 5 its value, 6 the field of the flag, 7 its value (MC7000 manual, lines 225-238).
  /// Returns kIndexOverflow, and writes nothing, when a field that it writes is beyond 99. \rtsafe
  [[nodiscard]] PosModLocation receive_rx_pdo21(std::span<const std::byte, kRxPdo21Size> pdo) noexcept;

 private:
  std::array<std::int32_t, kFields> variables_{};
  std::array<std::uint8_t, kFields> flags_{};
};

}  // namespace driveline::slaves::mc7000
