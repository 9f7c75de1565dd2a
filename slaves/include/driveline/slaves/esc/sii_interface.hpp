#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "driveline/slaves/esc/memory.hpp"
#include "driveline/slaves/esc/register_access.hpp"

namespace driveline::slaves {

/// How the EEPROM of an emulated slave behaves.
struct SiiOptions {
  std::chrono::nanoseconds busy_time{0};  ///< from a command to its result
  bool reads_8_bytes = true;              ///< else 4 bytes per read command
};

/// The EEPROM and its register interface 0x0500-0x050F (ETG.1000.4 6.4): read, write and reload commands in words,
/// ownership of ECAT and PDI. Addresses beyond the image read 0xFFFF and ignore writes. All functions but the
/// constructor are \rtsafe.
class SiiInterface {
 public:
  /// Times are on the line's clock.
  using Nanoseconds = std::chrono::nanoseconds;

  /// Takes over the EEPROM content (whole 16-bit words; an odd last byte gets a companion 0xFF).
  SiiInterface(EscMemory& memory, std::vector<std::byte> image, const SiiOptions& options);

  /// Power-on: loads the configuration area, alias address included.
  void reset() noexcept;

  /// A write of one side to registers at `address`; true when a byte was accepted. Commands start at once.
  bool write_registers(Side side, std::size_t address, std::span<const std::byte> data, Nanoseconds now) noexcept;
  /// Completes a command whose time is up; to be called before the registers are read.
  void refresh(Nanoseconds now) noexcept {
    if (busy_ && now >= done_at_) complete();
  }

  /// Configuration area valid; without it the process data interface does not come up.
  [[nodiscard]] bool loaded() const noexcept { return loaded_; }
  /// Counts how often the configuration area has been loaded.
  [[nodiscard]] std::uint64_t loads() const noexcept { return loads_; }
  /// The EEPROM content as it is now.
  [[nodiscard]] std::span<const std::byte> image() const noexcept { return image_; }
  /// True when a command has changed the content since construction.
  [[nodiscard]] bool modified() const noexcept { return revision_ != 0; }
  /// Counts the words that commands have written.
  [[nodiscard]] std::uint64_t revision() const noexcept { return revision_; }

  /// \name Faults
  /// @{

  /// From a command to its result, 0: at once.
  [[nodiscard]] Nanoseconds busy_time() const noexcept { return options_.busy_time; }
  /// From now on every command keeps the interface busy for `time`.
  void set_busy_time(Nanoseconds time) noexcept { options_.busy_time = time; }
  /// Changes a byte of the content without a command, e.g. to break the checksum before a power cycle.
  void corrupt(std::size_t offset, std::byte value) noexcept {
    if (offset < image_.size()) image_[offset] = value;
  }
  /// @}

 private:
  [[nodiscard]] bool owned_by(Side side) const noexcept;
  bool write_ownership(Side side, std::size_t address, std::byte value) noexcept;
  void start(std::uint16_t control, Nanoseconds now) noexcept;
  void complete() noexcept;
  void load_configuration(bool power_on) noexcept;
  [[nodiscard]] std::uint16_t word(std::size_t address) const noexcept;
  void set_status(std::uint16_t clear, std::uint16_t set) noexcept;

  EscMemory& memory_;
  std::vector<std::byte> image_;
  SiiOptions options_;
  bool loaded_ = false;
  std::uint64_t loads_ = 0;
  std::uint64_t revision_ = 0;
  bool busy_ = false;
  std::uint16_t command_ = 0;
  Nanoseconds done_at_{0};
};

}  // namespace driveline::slaves
