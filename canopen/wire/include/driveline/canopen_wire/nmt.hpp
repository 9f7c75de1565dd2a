#pragma once

#include <string_view>

#include "driveline/canopen_wire/cob_id.hpp"

namespace driveline::canopen {

/// NMT services of a master (CiA 301 7.2.8.2.1). Other values may arrive and are retained.
enum class NmtCommand : std::uint8_t {
  kStart = 1,
  kStop = 2,
  kEnterPreOperational = 0x80,
  kResetNode = 0x81,
  kResetCommunication = 0x82,
};

/// NMT states as error control transmits them (CiA 301 7.2.8.2.2). Other values may arrive and are retained.
enum class NmtState : std::uint8_t {
  kInitialising = 0,  ///< on the wire the boot-up message
  kStopped = 4,
  kOperational = 5,
  kPreOperational = 127,
};

/// The name of a state for users; "unknown" for any other value. \rtsafe
[[nodiscard]] constexpr std::string_view to_text(NmtState state) noexcept {
  switch (state) {
    case NmtState::kInitialising:
      return "Initialising";
    case NmtState::kStopped:
      return "Stopped";
    case NmtState::kOperational:
      return "Operational";
    case NmtState::kPreOperational:
      return "Pre-operational";
  }
  return "unknown";
}

/// An NMT request, 2 bytes on identifier 0.
struct NmtRequest {
  static constexpr std::size_t kSize = 2;   ///< size on the wire, in bytes
  NmtCommand command = NmtCommand::kStart;  ///< requested service
  std::uint8_t node = 0;                    ///< node-ID; 0: all nodes

  /// The frame of this request. \rtsafe
  [[nodiscard]] constexpr Frame frame() const noexcept {
    return Frame::of(predefined::kNmt, std::array{static_cast<std::byte>(command), static_cast<std::byte>(node)});
  }
  /// Empty unless the payload has exactly two bytes. \rtsafe
  [[nodiscard]] static constexpr std::optional<NmtRequest> decode(std::span<const std::byte> in) noexcept {
    if (in.size() != kSize) return std::nullopt;
    return NmtRequest{static_cast<NmtCommand>(in[0]), std::to_integer<std::uint8_t>(in[1])};
  }
  constexpr bool operator==(const NmtRequest&) const = default;
};

/// The byte of boot-up, heartbeat and guarding (CiA 301 7.2.8.2.2): state in bits 0-6, toggle bit of guarding in bit 7.
struct ErrorControl {
  static constexpr std::size_t kSize = 1;    ///< size on the wire, in bytes
  NmtState state = NmtState::kInitialising;  ///< state of the sender
  bool toggle = false;                       ///< alternates between guarding answers; false in heartbeats

  /// The byte on the wire. \rtsafe
  [[nodiscard]] constexpr std::byte encode() const noexcept {
    return static_cast<std::byte>((static_cast<unsigned>(state) & 0x7FU) | (toggle ? 0x80U : 0U));
  }
  /// Empty unless the payload has exactly one byte. \rtsafe
  [[nodiscard]] static constexpr std::optional<ErrorControl> decode(std::span<const std::byte> in) noexcept {
    if (in.size() != kSize) return std::nullopt;
    const auto raw = std::to_integer<unsigned>(in[0]);
    return ErrorControl{static_cast<NmtState>(raw & 0x7FU), (raw & 0x80U) != 0};
  }
  constexpr bool operator==(const ErrorControl&) const = default;
};

}  // namespace driveline::canopen
