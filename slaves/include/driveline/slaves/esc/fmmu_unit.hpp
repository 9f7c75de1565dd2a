#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "driveline/slaves/esc/memory.hpp"
#include "driveline/wire/fmmu.hpp"

namespace driveline::slaves {

/// A range of logical bits that an FMMU maps in one direction. Ranges of the same direction never overlap: a logical
/// bit that two FMMUs map belongs to the FMMU with the lower number (ESC data sheet I, FMMU).
struct LogicalMapping {
  std::uint64_t begin_bit = 0;     ///< logical bit address
  std::uint64_t end_bit = 0;       ///< logical bit address, exclusive
  std::uint32_t physical_bit = 0;  ///< physical bit address that `begin_bit` is mapped to
  /// Whether whole bytes are mapped to whole bytes, so that copying needs no shift. \rtsafe
  [[nodiscard]] bool byte_aligned() const noexcept {
    return begin_bit % 8 == 0 && end_bit % 8 == 0 && physical_bit % 8 == 0;
  }
};

/// The FMMUs of a slave controller (registers 0x0600-0x06FF, ETG.1000.4 6.5): they map logical to physical bits. All
/// functions except the constructor are \rtsafe.
class FmmuUnit {
 public:
  /// Maximum number of FMMUs in the register space.
  static constexpr unsigned kMaxCount = 16;

  /// Creates `count` FMMUs, at most kMaxCount. Allocates all memory in advance.
  FmmuUnit(EscMemory& memory, unsigned count);

  /// Returns the number of FMMUs; registers of further FMMUs do not exist.
  [[nodiscard]] unsigned count() const noexcept { return count_; }
  /// Resets to the power-on state: nothing is mapped.
  void reset() noexcept { rebuild(); }
  /// Handles an ECAT write to configuration registers (0x0600 and up); returns whether a byte was accepted.
  bool write_registers(std::size_t address, std::span<const std::byte> data) noexcept;

  /// Whether any mapped bit lies in the `length` bytes from `logical` on.
  [[nodiscard]] bool touches(std::uint32_t logical, std::size_t length) const noexcept {
    return logical < end_byte_ && std::uint64_t{logical} + length > begin_byte_;
  }
  /// Returns the mappings for reading, in ascending logical order.
  [[nodiscard]] std::span<const LogicalMapping> reads() const noexcept { return reads_; }
  /// Returns the mappings for writing, in ascending logical order.
  [[nodiscard]] std::span<const LogicalMapping> writes() const noexcept { return writes_; }
  /// Whether any physical bit is mapped both for reading and for writing.
  [[nodiscard]] bool exchanges() const noexcept { return exchanges_; }

 private:
  void rebuild() noexcept;
  void add(std::vector<LogicalMapping>& mappings, LogicalMapping mapping) noexcept;

  EscMemory& memory_;
  unsigned count_;
  std::vector<LogicalMapping> reads_;
  std::vector<LogicalMapping> writes_;
  std::uint64_t begin_byte_ = 0;
  std::uint64_t end_byte_ = 0;
  bool exchanges_ = false;
};

}  // namespace driveline::slaves
