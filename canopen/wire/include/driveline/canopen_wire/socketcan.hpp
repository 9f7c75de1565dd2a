#pragma once

#include "driveline/canopen_wire/frame.hpp"

namespace driveline::canopen {

/// Frames as the kernel and captures have them: `struct can_frame` of linux/can.h, and LINKTYPE_CAN_SOCKETCAN of the
/// register of link types of tcpdump.org. Both are an identifier with flags, the length, three bytes of no use here,
/// and eight bytes of data; the kernel has its identifier in the order of the machine, a capture in big endian.
namespace socketcan {

inline constexpr std::size_t kFrameBytes = 16;    ///< CAN_MTU
inline constexpr std::size_t kFdFrameBytes = 72;  ///< CANFD_MTU
inline constexpr std::size_t kDataOffset = 8;     ///< of the data in both
inline constexpr std::size_t kLengthOffset = 4;   ///< of the length in both

/// Flags beside the identifier.
namespace flag {
inline constexpr std::uint32_t kExtended = 0x8000'0000;  ///< CAN_EFF_FLAG
inline constexpr std::uint32_t kRemote = 0x4000'0000;    ///< CAN_RTR_FLAG
inline constexpr std::uint32_t kError = 0x2000'0000;     ///< CAN_ERR_FLAG
}  // namespace flag

/// Classes of an error frame, in the place of its identifier (linux/can/error.h).
namespace error_class {
inline constexpr std::uint32_t kController = 0x004;  ///< CAN_ERR_CRTL: state of the controller in data[1]
inline constexpr std::uint32_t kBusOff = 0x040;      ///< CAN_ERR_BUSOFF
inline constexpr std::uint32_t kBusError = 0x080;    ///< CAN_ERR_BUSERROR
inline constexpr std::uint32_t kRestarted = 0x100;   ///< CAN_ERR_RESTARTED
inline constexpr std::uint32_t kCounters = 0x200;    ///< CAN_ERR_CNT: error counters in data[6] and data[7]
}  // namespace error_class

inline constexpr std::uint8_t kErrorFrameLength = 8;  ///< CAN_ERR_DLC

/// The identifier with its flags. An error frame, which has no identifier, gets the class of a bus error. \rtsafe
[[nodiscard]] constexpr std::uint32_t raw_identifier(const Frame& frame) noexcept {
  if (frame.kind == FrameKind::kError) return flag::kError | error_class::kBusError;
  return frame.identifier.value | (frame.identifier.extended ? flag::kExtended : 0U) |
         (frame.kind == FrameKind::kRemote ? flag::kRemote : 0U);
}

/// The data or remote frame of an identifier with its flags, a length and eight bytes; an error frame without its
/// details. Empty: identifier or length out of range. \rtsafe
[[nodiscard]] constexpr std::optional<Frame> frame_of(std::uint32_t raw, std::uint8_t length,
                                                      std::span<const std::byte> data) noexcept {
  if ((raw & flag::kError) != 0) return Frame{{}, FrameKind::kError, 0, {}};
  const Identifier identifier{raw & Identifier::kExtendedMask, (raw & flag::kExtended) != 0};
  if (!identifier.valid() || length > Frame::kMaxLength || data.size() < length) return std::nullopt;
  if ((raw & flag::kRemote) != 0) return Frame::remote(identifier, length);
  return Frame::of(identifier, data.first(length));
}

/// The bytes of a frame in a capture with LINKTYPE_CAN_SOCKETCAN. \rtsafe
[[nodiscard]] constexpr std::array<std::byte, kFrameBytes> packet_of(const Frame& frame) noexcept {
  std::array<std::byte, kFrameBytes> packet{};
  const std::uint32_t raw = raw_identifier(frame);
  for (std::size_t i = 0; i < 4; ++i) packet[i] = static_cast<std::byte>(raw >> (24U - 8U * i));
  packet[kLengthOffset] = static_cast<std::byte>(frame.kind == FrameKind::kError ? kErrorFrameLength : frame.length);
  const auto payload = frame.payload();
  std::copy(payload.begin(), payload.end(), packet.begin() + kDataOffset);
  return packet;
}

/// Reads the bytes of a frame in such a capture. Empty: other bytes. \rtsafe
[[nodiscard]] constexpr std::optional<Frame> parse_packet(std::span<const std::byte> packet) noexcept {
  if (packet.size() != kFrameBytes) return std::nullopt;
  std::uint32_t raw = 0;
  for (std::size_t i = 0; i < 4; ++i) raw = raw << 8U | std::to_integer<std::uint32_t>(packet[i]);
  return frame_of(raw, std::to_integer<std::uint8_t>(packet[kLengthOffset]), packet.subspan(kDataOffset));
}

}  // namespace socketcan

}  // namespace driveline::canopen
