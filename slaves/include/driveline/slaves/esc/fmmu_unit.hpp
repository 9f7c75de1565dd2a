#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "driveline/slaves/esc/memory.hpp"
#include "driveline/wire/fmmu.hpp"

namespace driveline::slaves {

/// A stretch of logical bits that one FMMU maps in one direction. Stretches of the same direction never overlap: a
/// logical bit that two FMMUs map belongs to the one with the lower number (ESC data sheet I, FMMU).
struct LogicalMapping {
  std::uint64_t begin_bit = 0;     ///< logical
  std::uint64_t end_bit = 0;       ///< logical, exclusive
  std::uint32_t physical_bit = 0;  ///< physical bit of `begin_bit`
  /// Whole bytes to whole bytes: can be copied without shifting. \rtsafe
  [[nodiscard]] bool byte_aligned() const noexcept {
    return begin_bit % 8 == 0 && end_bit % 8 == 0 && physical_bit % 8 == 0;
  }
};

/// The FMMUs of a slave controller (registers 0x0600-0x06FF, ETG.1000.4 6.5): the mapping of logical to physical bits.
/// All functions but the constructor are \rtsafe.
class FmmuUnit {
 public:
  /// Highest number of FMMUs; the registers have room for no more.
  static constexpr unsigned kMaxCount = 16;

  /// `count` FMMUs, at most kMaxCount. Allocates all it will need.
  FmmuUnit(EscMemory& memory, unsigned count);

  /// FMMUs that exist; registers of others are not there.
  [[nodiscard]] unsigned count() const noexcept { return count_; }
  /// Power-on state: nothing mapped.
  void reset() noexcept { rebuild(); }
  /// ECAT writes configuration registers at `address` (0x0600 and up); true when a byte was accepted.
  bool write_registers(std::size_t address, std::span<const std::byte> data) noexcept;

  /// True when some mapped bit lies in the `length` bytes from `logical` on.
  [[nodiscard]] bool touches(std::uint32_t logical, std::size_t length) const noexcept {
    return logical < end_byte_ && std::uint64_t{logical} + length > begin_byte_;
  }
  /// Mappings in ascending logical order.
  [[nodiscard]] std::span<const LogicalMapping> reads() const noexcept { return reads_; }
  /// Mappings for writing, in ascending logical order.
  [[nodiscard]] std::span<const LogicalMapping> writes() const noexcept { return writes_; }
  /// Some physical bit is mapped both for reading and for writing.
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
