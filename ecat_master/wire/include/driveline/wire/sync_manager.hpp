#pragma once

#include "driveline/bytes/endian.hpp"
#include "driveline/wire/decode_error.hpp"

namespace driveline::wire {

/// Buffer mode of a sync manager (ETG.1000.4 6.6.2, control byte bits 0-1).
enum class SyncManagerMode : std::uint8_t { kThreeBuffer = 0, kMailbox = 2 };
/// Direction as the master sees it (control byte bits 2-3).
enum class SyncManagerDirection : std::uint8_t { kRead = 0, kWrite = 1 };

/// Control byte of a sync manager (register 0x0804 + 8 n).
struct SyncManagerControl {
  SyncManagerMode mode = SyncManagerMode::kThreeBuffer;          ///< bits 0-1
  SyncManagerDirection direction = SyncManagerDirection::kRead;  ///< bits 2-3
  bool interrupt_ecat = false;                                   ///< bit 4: event for the master
  bool interrupt_pdi = false;                                    ///< bit 5: event for the application
  bool watchdog_trigger = false;                                 ///< bit 6: a write restarts the process data watchdog

  /// The value of the control register. \rtsafe
  [[nodiscard]] constexpr std::uint8_t raw() const noexcept {
    return static_cast<std::uint8_t>((static_cast<unsigned>(mode) & 3U) |
                                     ((static_cast<unsigned>(direction) & 3U) << 2) | (interrupt_ecat ? 0x10U : 0U) |
                                     (interrupt_pdi ? 0x20U : 0U) | (watchdog_trigger ? 0x40U : 0U));
  }
  /// Decodes the control register. \rtsafe
  [[nodiscard]] static constexpr SyncManagerControl from_raw(std::uint8_t raw) noexcept {
    return {static_cast<SyncManagerMode>(raw & 3), static_cast<SyncManagerDirection>((raw >> 2) & 3), (raw & 0x10) != 0,
            (raw & 0x20) != 0, (raw & 0x40) != 0};
  }
  constexpr bool operator==(const SyncManagerControl&) const = default;
};

/// Bits of the status byte (register 0x0805 + 8 n).
struct SyncManagerStatus {
  static constexpr std::uint8_t kInterruptWrite = 0x01;  ///< the buffer was written completely
  static constexpr std::uint8_t kInterruptRead = 0x02;   ///< the buffer was read completely
  static constexpr std::uint8_t kMailboxFull = 0x08;     ///< mailbox mode: full
  static constexpr std::uint8_t kBufferMask = 0x30;      ///< last written buffer, 3 = none yet
  static constexpr std::uint8_t kReadInUse = 0x40;       ///< a buffer is being read
  static constexpr std::uint8_t kWriteInUse = 0x80;      ///< a buffer is being written
};

/// Bits of the activate byte (register 0x0806 + 8 n).
struct SyncManagerActivate {
  static constexpr std::uint8_t kEnable = 0x01;         ///< switches the channel on
  static constexpr std::uint8_t kRepeatRequest = 0x02;  ///< a change requests that the last mailbox message be repeated
  static constexpr std::uint8_t kLatchEcat = 0x40;      ///< records time stamps of the master's buffer events
  static constexpr std::uint8_t kLatchPdi = 0x80;       ///< records time stamps of the application's buffer events
};

/// Bits of the PDI control byte (register 0x0807 + 8 n).
struct SyncManagerPdiControl {
  static constexpr std::uint8_t kDeactivate = 0x01;  ///< the application switches the channel off
  static constexpr std::uint8_t kRepeatAck =
      0x02;  ///< set to kRepeatRequest by the application when the message is in the mailbox again
};

/// One sync manager channel as the master writes it: 8 bytes at 0x0800 + 8 n (ETG.1000.4 Table 59).
struct SyncManagerChannel {
  static constexpr std::size_t kSize = 8;  ///< size on the wire, in bytes
  std::uint16_t start_address = 0;         ///< address in the slave's memory
  std::uint16_t length = 0;                ///< size of the buffer, in bytes
  std::uint8_t control = 0;                ///< SyncManagerControl::raw()
  std::uint8_t status = 0;                 ///< read only for the master
  std::uint8_t activate = 0;               ///< SyncManagerActivate bits
  std::uint8_t pdi_control = 0;            ///< read only for the master

  /// Writes all registers of a channel. \rtsafe
  constexpr void encode(std::span<std::byte, kSize> out) const noexcept {
    bytes::store_le(out.subspan<0, 2>(), start_address);
    bytes::store_le(out.subspan<2, 2>(), length);
    bytes::store_le(out.subspan<4, 1>(), control);
    bytes::store_le(out.subspan<5, 1>(), status);
    bytes::store_le(out.subspan<6, 1>(), activate);
    bytes::store_le(out.subspan<7, 1>(), pdi_control);
  }
  /// Error: kTooShort. \rtsafe
  [[nodiscard]] static constexpr Decoded<SyncManagerChannel> decode(std::span<const std::byte> in) noexcept {
    if (in.size() < kSize) return tl::unexpected(DecodeError::kTooShort);
    return SyncManagerChannel{bytes::load_le<std::uint16_t>(in),           bytes::load_le<std::uint16_t>(in.subspan(2)),
                              bytes::load_le<std::uint8_t>(in.subspan(4)), bytes::load_le<std::uint8_t>(in.subspan(5)),
                              bytes::load_le<std::uint8_t>(in.subspan(6)), bytes::load_le<std::uint8_t>(in.subspan(7))};
  }
  constexpr bool operator==(const SyncManagerChannel&) const = default;
};

}  // namespace driveline::wire
