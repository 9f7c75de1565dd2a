#pragma once

#include <array>
#include <bit>
#include <vector>

#include "driveline/ecat_master/bus/datagram_exchange.hpp"
#include "driveline/ecat_master/bus/sii_cache.hpp"
#include "driveline/wire/registers.hpp"

namespace driveline::ecat_master {

/// Addresses of a slave for acyclic access.
struct SlaveRef {
  std::uint16_t position = 0;  ///< position on the line, 0 = first; used in messages
  std::uint16_t station = 0;   ///< configured station address
};

/// Bytes to be written to registers or memory of a slave.
struct RegisterWrite {
  SlaveRef slave;               ///< the slave to write to
  std::uint16_t address = 0;    ///< address of the first byte
  std::vector<std::byte> data;  ///< bytes to be written
};

/// Typed single-datagram access to registers and memory of slaves, with the working counter checked.
/// Not real-time safe. Errors of all functions: those of the exchange, and WorkingCounter.
class Bus {
 public:
  /// `exchange` must outlive the bus.
  explicit Bus(DatagramExchange& exchange) noexcept : exchange_(exchange) {}

  /// The exchange that carries the datagrams.
  [[nodiscard]] DatagramExchange& exchange() noexcept { return exchange_; }
  /// EEPROM contents read through this bus. Clear the cache when an EEPROM is written by other means than write_sii().
  [[nodiscard]] SiiCache& sii_cache() noexcept { return sii_cache_; }

  /// Reads as many bytes of registers or memory as `data` has, starting at `address`.
  [[nodiscard]] Result<void> read(SlaveRef slave, std::uint16_t address, std::span<std::byte> data);
  /// Writes registers or memory, starting at `address`.
  [[nodiscard]] Result<void> write(SlaveRef slave, std::uint16_t address, std::span<const std::byte> data);
  /// Like read(), but returns false when the slave left the working counter unchanged (empty mailbox).
  [[nodiscard]] Result<bool> try_read(SlaveRef slave, std::uint16_t address, std::span<std::byte> data);
  /// Like write(), but returns false when the slave left the working counter unchanged (full mailbox).
  [[nodiscard]] Result<bool> try_write(SlaveRef slave, std::uint16_t address, std::span<const std::byte> data);

  /// Sends all `writes` in as few frames as possible. The error names the first slave that did not accept its data.
  [[nodiscard]] Result<void> write_all(std::span<RegisterWrite> writes);

  template <typename T>
  /// Reads a register, or one `element` of a register array.
  [[nodiscard]] Result<T> read(SlaveRef slave, const wire::Register<T>& reg, unsigned element = 0) {
    std::array<std::byte, sizeof(T)> data{};
    return read(slave, reg.at(element), data).map([&] { return bytes::load_le<T>(data); });
  }
  template <typename T>
  /// Writes a register, or one `element` of a register array.
  [[nodiscard]] Result<void> write(SlaveRef slave, const wire::Register<T>& reg, std::type_identity_t<T> value,
                                   unsigned element = 0) {
    const auto data = bytes::to_le_bytes(value);
    return write(slave, reg.at(element), data);
  }

  /// Reads from all slaves. Returns how many answered; `data` receives the OR of all answers.
  [[nodiscard]] Result<std::uint16_t> broadcast_read(std::uint16_t address, std::span<std::byte> data);
  /// Writes to all slaves. Returns how many accepted the data.
  [[nodiscard]] Result<std::uint16_t> broadcast_write(std::uint16_t address, std::span<const std::byte> data);
  /// Writes to the slave at a position of the line, before station addresses are assigned.
  [[nodiscard]] Result<void> write_at_position(std::uint16_t position, std::uint16_t address,
                                               std::span<const std::byte> data);

 private:
  DatagramExchange& exchange_;
  SiiCache sii_cache_;
};

}  // namespace driveline::ecat_master
