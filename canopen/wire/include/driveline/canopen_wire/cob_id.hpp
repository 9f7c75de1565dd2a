#pragma once

#include "driveline/canopen_wire/frame.hpp"

namespace driveline::canopen {

/// Highest node-ID; the lowest is 1.
inline constexpr std::uint8_t kMaxNodeId = 127;

/// The predefined connection set (CiA 301 7.3.3): identifiers of broadcast objects, and bases to which a node adds its
/// node-ID.
namespace predefined {
inline constexpr std::uint32_t kNmt = 0x000;                                       ///< network management
inline constexpr std::uint32_t kSync = 0x080;                                      ///< synchronisation
inline constexpr std::uint32_t kEmergency = 0x080;                                 ///< plus node-ID
inline constexpr std::uint32_t kTime = 0x100;                                      ///< time stamp
inline constexpr std::array<std::uint32_t, 4> kTxPdo{0x180, 0x280, 0x380, 0x480};  ///< plus node-ID
inline constexpr std::array<std::uint32_t, 4> kRxPdo{0x200, 0x300, 0x400, 0x500};  ///< plus node-ID
inline constexpr std::uint32_t kSdoServerToClient = 0x580;                         ///< plus node-ID
inline constexpr std::uint32_t kSdoClientToServer = 0x600;                         ///< plus node-ID
inline constexpr std::uint32_t kErrorControl = 0x700;                              ///< plus node-ID
}  // namespace predefined

/// COB-ID as objects of the dictionary hold it (CiA 301 7.5.2.5, .17, .35, .37): identifier in bits 0-28, and three
/// bits. The meaning of bits 30 and 31 depends on the object.
struct CobId {
  std::uint32_t raw = 0;  ///< value of the object

  static constexpr std::uint32_t kExtended = 1U << 29;  ///< the identifier has 29 bits
  static constexpr std::uint32_t kProducer = 1U << 30;  ///< SYNC, TIME: the device produces it
  static constexpr std::uint32_t kNoRemote = 1U << 30;  ///< TPDO: remote frames are not answered
  static constexpr std::uint32_t kInvalid = 1U << 31;   ///< PDO, EMCY, SDO: does not exist
  static constexpr std::uint32_t kConsumer = 1U << 31;  ///< TIME: the device consumes it

  /// The identifier of the message. \rtsafe
  [[nodiscard]] constexpr Identifier identifier() const noexcept {
    const bool extended = (raw & kExtended) != 0;
    return {raw & (extended ? Identifier::kExtendedMask : Identifier::kBaseMask), extended};
  }
  /// Whether bit 31 is set. \rtsafe
  [[nodiscard]] constexpr bool invalid() const noexcept { return (raw & kInvalid) != 0; }
  /// Whether bits 11-28 are zero where the identifier has only 11 bits. \rtsafe
  [[nodiscard]] constexpr bool well_formed() const noexcept {
    return (raw & kExtended) != 0 || (raw & (Identifier::kExtendedMask & ~Identifier::kBaseMask)) == 0;
  }
  constexpr bool operator==(const CobId&) const = default;
};

/// Whether a configurable COB-ID must not have this identifier, because NMT, SDO, error control or reserved messages
/// have it (CiA 301 Table 40: 000h-07Fh, 101h-180h, 581h-5FFh, 601h-67Fh, 6E0h-6FFh, 701h-77Fh, 780h-7FFh). \rtsafe
[[nodiscard]] constexpr bool is_restricted(Identifier identifier) noexcept {
  if (identifier.extended) return false;
  constexpr std::array<std::array<std::uint32_t, 2>, 7> kRanges{
      {{0x000, 0x07F}, {0x101, 0x180}, {0x581, 0x5FF}, {0x601, 0x67F}, {0x6E0, 0x6FF}, {0x701, 0x77F}, {0x780, 0x7FF}}};
  return std::any_of(kRanges.begin(), kRanges.end(),
                     [&](const auto& range) { return identifier.value >= range[0] && identifier.value <= range[1]; });
}

}  // namespace driveline::canopen
