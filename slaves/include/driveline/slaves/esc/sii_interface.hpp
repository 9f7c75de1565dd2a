#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "driveline/slaves/esc/memory.hpp"
#include "driveline/slaves/esc/register_access.hpp"

namespace driveline::slaves {

/// Behaviour of the EEPROM of an emulated slave.
struct SiiOptions {
  std::chrono::nanoseconds busy_time{0};  ///< from a command to its result
  bool reads_8_bytes = true;              ///< 8 bytes per read command, else 4
};

/// The EEPROM and its register interface 0x0500-0x050F (ETG.1000.4 6.4): read, write and reload commands in words,
/// ownership by ECAT and PDI. Addresses beyond the image read 0xFFFF and ignore writes. All functions except the
/// constructor are \rtsafe.
class SiiInterface {
 public:
  /// Times are on the line's clock.
  using Nanoseconds = std::chrono::nanoseconds;

  /// Takes the EEPROM content (whole 16-bit words; an odd last byte is padded with 0xFF).
  SiiInterface(EscMemory& memory, std::vector<std::byte> image, const SiiOptions& options);

  /// Power-on: loads the configuration area, including the alias address.
  void reset() noexcept;

  /// Handles a write of either side; returns whether a byte was accepted. Commands start at once.
  bool write_registers(Side side, std::size_t address, std::span<const std::byte> data, Nanoseconds now) noexcept;
  /// Completes a command whose time has passed; to be called before the registers are read.
  void refresh(Nanoseconds now) noexcept {
    if (busy_ && now >= done_at_) complete();
  }

  /// Whether the configuration area is valid; else the process data interface does not start.
  [[nodiscard]] bool loaded() const noexcept { return loaded_; }
  /// Returns how often the configuration area has been loaded.
  [[nodiscard]] std::uint64_t loads() const noexcept { return loads_; }
  /// Returns the current EEPROM content.
  [[nodiscard]] std::span<const std::byte> image() const noexcept { return image_; }
  /// Whether a command has changed the content since construction.
  [[nodiscard]] bool modified() const noexcept { return revision_ != 0; }
  /// Returns the number of words that commands have written.
  [[nodiscard]] std::uint64_t revision() const noexcept { return revision_; }

  /// \name Faults
  /// @{

  /// Returns the time from a command to its result; 0: immediate.
  [[nodiscard]] Nanoseconds busy_time() const noexcept { return options_.busy_time; }
  /// Sets the busy time of all further commands.
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
