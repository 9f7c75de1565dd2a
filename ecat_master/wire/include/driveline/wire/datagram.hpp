#pragma once

#include <cstddef>
#include <cstdint>

#include "driveline/bytes/endian.hpp"
#include "driveline/wire/command.hpp"
#include "driveline/wire/decode_error.hpp"

namespace driveline::wire {

/// EtherCAT frame header (ETG.1000.4 5.3.3): bits 0-10 length of the datagrams, bit 11 reserved, bits 12-15 type.
struct EtherCatHeader {
  static constexpr std::size_t kSize = 2;             ///< size on the wire, in bytes
  static constexpr std::uint8_t kTypeCommands = 1;    ///< the only type that slave controllers process
  static constexpr std::uint16_t kMaxLength = 0x7FF;  ///< 11 bits
  std::uint16_t length = 0;                           ///< bytes of datagrams that follow, 0..2047
  std::uint8_t type = kTypeCommands;                  ///< 4 bits

  /// Writes the header. \rtsafe
  constexpr void encode(std::span<std::byte, kSize> out) const noexcept {
    bytes::store_le<std::uint16_t>(out, static_cast<std::uint16_t>((length & kMaxLength) | (type << 12)));
  }
  /// The reserved bit is ignored, as slave controllers do. \rtsafe
  [[nodiscard]] static constexpr Decoded<EtherCatHeader> decode(std::span<const std::byte> in) noexcept {
    if (in.size() < kSize) return tl::unexpected(DecodeError::kTooShort);
    const auto raw = bytes::load_le<std::uint16_t>(in);
    return EtherCatHeader{static_cast<std::uint16_t>(raw & kMaxLength), static_cast<std::uint8_t>(raw >> 12)};
  }
  constexpr bool operator==(const EtherCatHeader&) const = default;
};

/// The 32-bit address field: position or station address plus register offset, or one logical address.
struct DatagramAddress {
  std::uint32_t raw = 0;  ///< ADP in the lower word, ADO in the upper one; or a logical address

  /// Address from ADP (auto-increment position, station address) and ADO (memory offset).
  [[nodiscard]] static constexpr DatagramAddress physical(std::uint16_t adp, std::uint16_t ado) noexcept {
    return {static_cast<std::uint32_t>(adp) | (static_cast<std::uint32_t>(ado) << 16)};
  }
  /// Auto-increment address (0, 0xFFFF, 0xFFFE ...) of the slave at `position` (0: first).
  [[nodiscard]] static constexpr DatagramAddress position(std::uint16_t position, std::uint16_t ado) noexcept {
    return physical(static_cast<std::uint16_t>(0U - position), ado);
  }
  /// Logical address, for LRD, LWR and LRW. \rtsafe
  [[nodiscard]] static constexpr DatagramAddress logical(std::uint32_t address) noexcept { return {address}; }
  /// Position or station address. \rtsafe
  [[nodiscard]] constexpr std::uint16_t adp() const noexcept { return static_cast<std::uint16_t>(raw & 0xFFFF); }
  /// Register or memory address. \rtsafe
  [[nodiscard]] constexpr std::uint16_t ado() const noexcept { return static_cast<std::uint16_t>(raw >> 16); }
  constexpr bool operator==(const DatagramAddress&) const = default;
};

/// Datagram header (ETG.1000.4 5.4.1.2): command, index, address, length and flags, IRQ; 10 bytes.
/// `length` counts the data only, not the header and not the working counter.
struct DatagramHeader {
  static constexpr std::size_t kSize = 10;               ///< size of the header on the wire, in bytes
  static constexpr std::size_t kWorkingCounterSize = 2;  ///< size of the working counter behind the data, in bytes
  /// bytes of a datagram in addition to its data
  static constexpr std::size_t kOverhead = kSize + kWorkingCounterSize;
  static constexpr std::uint16_t kMaxLength = 0x7FF;  ///< 11 bits

  Command command = Command::kNop;  ///< kind of access
  std::uint8_t index = 0;           ///< chosen by the master; returned unchanged
  DatagramAddress address;          ///< slave and register, or logical address
  std::uint16_t length = 0;         ///< data bytes, 0..2047
  bool circulating = false;         ///< the frame has already passed a slave with a closed loop on port 0
  bool more = false;                ///< another datagram follows in this frame
  std::uint16_t irq = 0;            ///< ECAT event request of all slaves, OR-ed

  /// Reserved bits 11-13 of the length field are written as zero. \rtsafe
  constexpr void encode(std::span<std::byte, kSize> out) const noexcept {
    out[0] = static_cast<std::byte>(command);
    out[1] = static_cast<std::byte>(index);
    bytes::store_le<std::uint32_t>(out.subspan<2, 4>(), address.raw);
    bytes::store_le<std::uint16_t>(
        out.subspan<6, 2>(),
        static_cast<std::uint16_t>((length & kMaxLength) | (circulating ? 0x4000U : 0U) | (more ? 0x8000U : 0U)));
    bytes::store_le<std::uint16_t>(out.subspan<8, 2>(), irq);
  }
  /// Error: kTooShort. \rtsafe
  [[nodiscard]] static constexpr Decoded<DatagramHeader> decode(std::span<const std::byte> in) noexcept {
    if (in.size() < kSize) return tl::unexpected(DecodeError::kTooShort);
    const auto flags = bytes::load_le<std::uint16_t>(in.subspan(6, 2));
    DatagramHeader header;
    header.command = static_cast<Command>(in[0]);
    header.index = std::to_integer<std::uint8_t>(in[1]);
    header.address = {bytes::load_le<std::uint32_t>(in.subspan(2, 4))};
    header.length = static_cast<std::uint16_t>(flags & kMaxLength);
    header.circulating = (flags & 0x4000U) != 0;
    header.more = (flags & 0x8000U) != 0;
    header.irq = bytes::load_le<std::uint16_t>(in.subspan(8, 2));
    return header;
  }
  constexpr bool operator==(const DatagramHeader&) const = default;
};

}  // namespace driveline::wire
