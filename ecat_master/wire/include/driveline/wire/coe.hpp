#pragma once

#include <array>

#include "driveline/bytes/endian.hpp"
#include "driveline/wire/decode_error.hpp"

namespace driveline::wire {

/// CoE services (ETG.1000.6 5.6.1, service field of the CoE header). Other values may arrive and are retained.
enum class CoeService : std::uint8_t {
  kEmergency = 1,
  kSdoRequest = 2,
  kSdoResponse = 3,
  kTxPdo = 4,
  kRxPdo = 5,
  kTxPdoRemoteRequest = 6,
  kRxPdoRemoteRequest = 7,
  kSdoInformation = 8,
};

/// Object access bits of an entry, as the SDO information service reports them (ETG.1000.6 5.6.3.6, Table 54).
namespace entry_access {
inline constexpr std::uint16_t kReadPreOp = 0x0001;    ///< readable in PREOP
inline constexpr std::uint16_t kReadSafeOp = 0x0002;   ///< readable in SAFEOP
inline constexpr std::uint16_t kReadOp = 0x0004;       ///< readable in OP
inline constexpr std::uint16_t kWritePreOp = 0x0008;   ///< writable in PREOP
inline constexpr std::uint16_t kWriteSafeOp = 0x0010;  ///< writable in SAFEOP
inline constexpr std::uint16_t kWriteOp = 0x0020;      ///< writable in OP
inline constexpr std::uint16_t kRxMappable = 0x0040;   ///< may be mapped into an RxPDO
inline constexpr std::uint16_t kTxMappable = 0x0080;   ///< may be mapped into a TxPDO
inline constexpr std::uint16_t kBackup = 0x0100;       ///< saved by "store parameters"
inline constexpr std::uint16_t kSettings = 0x0200;     ///< part of the settings of the device
}  // namespace entry_access

/// CoE header: number (PDO services) and service, 2 bytes (ETG.1000.6 Table 29).
struct CoeHeader {
  static constexpr std::size_t kSize = 2;        ///< size on the wire, in bytes
  std::uint16_t number = 0;                      ///< 9 bits
  CoeService service = CoeService::kSdoRequest;  ///< bits 12-15

  /// Writes the header; number and reserved bits are 0. \rtsafe
  constexpr void encode(std::span<std::byte, kSize> out) const noexcept {
    bytes::store_le(out, static_cast<std::uint16_t>((number & 0x1FFU) | (static_cast<unsigned>(service) << 12)));
  }
  /// Error: kTooShort. Unknown services are retained. \rtsafe
  [[nodiscard]] static constexpr Decoded<CoeHeader> decode(std::span<const std::byte> in) noexcept {
    if (in.size() < kSize) return tl::unexpected(DecodeError::kTooShort);
    const auto raw = bytes::load_le<std::uint16_t>(in);
    return CoeHeader{static_cast<std::uint16_t>(raw & 0x1FFU), static_cast<CoeService>(raw >> 12)};
  }
  constexpr bool operator==(const CoeHeader&) const = default;
};

/// Command specifier of SDO requests, bits 5-7 of the first SDO byte (ETG.1000.6 5.6.2).
enum class SdoRequestCommand : std::uint8_t {
  kDownloadSegment = 0,
  kInitiateDownload = 1,
  kInitiateUpload = 2,
  kUploadSegment = 3,
  kAbort = 4,
};

/// Command specifier of SDO responses.
enum class SdoResponseCommand : std::uint8_t {
  kUploadSegment = 0,
  kDownloadSegment = 1,
  kInitiateUpload = 2,
  kInitiateDownload = 3,
  kAbort = 4,
};

/// The eight bytes that start every SDO initiate and abort message: command, index, sub-index and four bytes that
/// hold expedited data, the complete size, or the abort code.
struct SdoHeader {
  static constexpr std::size_t kSize = 8;  ///< size on the wire, in bytes
  std::uint8_t command = 0;                ///< specifier << 5 | flags
  std::uint16_t index = 0;                 ///< index of the object
  std::uint8_t subindex = 0;               ///< sub-index of the entry; 0 or 1 with complete access
  std::array<std::byte, 4> data{};         ///< size of the object, or the value of an expedited transfer

  static constexpr std::uint8_t kSizeIndicated = 0x01;   ///< command bit 0: `data` holds the size
  static constexpr std::uint8_t kExpedited = 0x02;       ///< command bit 1: `data` is the value
  static constexpr std::uint8_t kCompleteAccess = 0x10;  ///< command bit 4: all sub-indices

  /// Bits 5-7: the command specifier (SdoRequestCommand, SdoResponseCommand). \rtsafe
  [[nodiscard]] constexpr std::uint8_t specifier() const noexcept { return static_cast<std::uint8_t>(command >> 5); }
  /// Whether the value is in the header. \rtsafe
  [[nodiscard]] constexpr bool expedited() const noexcept { return (command & kExpedited) != 0; }
  /// Whether the header states the size of the object or of the expedited value. \rtsafe
  [[nodiscard]] constexpr bool size_indicated() const noexcept { return (command & kSizeIndicated) != 0; }
  /// Whether all sub-indices travel in one transfer. \rtsafe
  [[nodiscard]] constexpr bool complete_access() const noexcept { return (command & kCompleteAccess) != 0; }
  /// Bytes of expedited data: 4 minus the "unused" field when the size is indicated, else 4.
  [[nodiscard]] constexpr std::size_t expedited_size() const noexcept {
    return size_indicated() ? 4U - ((command >> 2) & 3U) : 4U;
  }
  /// `data` as a number: size of the object, or abort code. \rtsafe
  [[nodiscard]] constexpr std::uint32_t data_u32() const noexcept { return bytes::load_le<std::uint32_t>(data); }

  /// Writes all 8 bytes. \rtsafe
  constexpr void encode(std::span<std::byte, kSize> out) const noexcept {
    out[0] = static_cast<std::byte>(command);
    bytes::store_le(out.subspan<1, 2>(), index);
    out[3] = static_cast<std::byte>(subindex);
    for (std::size_t i = 0; i < 4; ++i) out[4 + i] = data[i];
  }
  /// Error: kTooShort. \rtsafe
  [[nodiscard]] static constexpr Decoded<SdoHeader> decode(std::span<const std::byte> in) noexcept {
    if (in.size() < kSize) return tl::unexpected(DecodeError::kTooShort);
    return SdoHeader{bytes::load_le<std::uint8_t>(in),
                     bytes::load_le<std::uint16_t>(in.subspan(1)),
                     bytes::load_le<std::uint8_t>(in.subspan(3)),
                     {in[4], in[5], in[6], in[7]}};
  }
  constexpr bool operator==(const SdoHeader&) const = default;
};

/// Command byte of an initiate download (request) or initiate upload (response) that carries `size` <= 4 bytes.
[[nodiscard]] constexpr std::uint8_t expedited_command(std::uint8_t specifier, std::size_t size) noexcept {
  return static_cast<std::uint8_t>((unsigned{specifier} << 5) | ((4U - size) << 2) | SdoHeader::kExpedited |
                                   SdoHeader::kSizeIndicated);
}

/// First byte of a segment message (download request, upload response): toggle, unused bytes, last flag.
struct SdoSegmentHeader {
  static constexpr std::size_t kSize = 1;  ///< size on the wire, in bytes
  static constexpr std::size_t kMinData =
      7;                       ///< a segment has at least 7 data bytes; `unused` counts those without data
  std::uint8_t specifier = 0;  ///< bits 5-7
  bool toggle = false;         ///< bit 4: alternates from segment to segment, starts with 0
  std::uint8_t unused = 0;     ///< 0..7, bytes of a 7-byte segment without data
  bool last = false;           ///< bit 0: no further segment

  /// The command byte. \rtsafe
  [[nodiscard]] constexpr std::uint8_t raw() const noexcept {
    return static_cast<std::uint8_t>((unsigned{specifier} << 5) | (toggle ? 0x10U : 0U) | ((unused & 7U) << 1) |
                                     (last ? 1U : 0U));
  }
  /// Decodes the command byte. \rtsafe
  [[nodiscard]] static constexpr SdoSegmentHeader from_raw(std::uint8_t raw) noexcept {
    return {static_cast<std::uint8_t>(raw >> 5), (raw & 0x10) != 0, static_cast<std::uint8_t>((raw >> 1) & 7U),
            (raw & 1) != 0};
  }
  constexpr bool operator==(const SdoSegmentHeader&) const = default;
};

/// CoE emergency message (ETG.1000.6 5.6.4): error code, error register, five manufacturer-specific bytes.
struct Emergency {
  static constexpr std::size_t kSize = 8;  ///< size on the wire, in bytes
  std::uint16_t error_code = 0;            ///< error code, CiA 402 for drives; 0: the error has been reset
  std::uint8_t error_register = 0;         ///< object 1001h
  std::array<std::byte, 5> data{};         ///< manufacturer-specific data

  /// Writes all 8 bytes. \rtsafe
  constexpr void encode(std::span<std::byte, kSize> out) const noexcept {
    bytes::store_le(out.subspan<0, 2>(), error_code);
    out[2] = static_cast<std::byte>(error_register);
    for (std::size_t i = 0; i < data.size(); ++i) out[3 + i] = data[i];
  }
  /// Error: kTooShort. \rtsafe
  [[nodiscard]] static constexpr Decoded<Emergency> decode(std::span<const std::byte> in) noexcept {
    if (in.size() < kSize) return tl::unexpected(DecodeError::kTooShort);
    return Emergency{bytes::load_le<std::uint16_t>(in),
                     bytes::load_le<std::uint8_t>(in.subspan(2)),
                     {in[3], in[4], in[5], in[6], in[7]}};
  }
  constexpr bool operator==(const Emergency&) const = default;
};

/// SDO information op-codes (ETG.1000.6 5.6.3). Other values may arrive and are retained.
enum class SdoInfoOpCode : std::uint8_t {
  kListRequest = 1,
  kListResponse = 2,
  kObjectRequest = 3,
  kObjectResponse = 4,
  kEntryRequest = 5,
  kEntryResponse = 6,
  kError = 7,
};

/// SDO information header: op-code, "incomplete" flag, fragments left (ETG.1000.6 5.6.3.2).
struct SdoInfoHeader {
  static constexpr std::size_t kSize = 4;               ///< size on the wire, in bytes
  SdoInfoOpCode op_code = SdoInfoOpCode::kListRequest;  ///< bits 0-6 of the first byte
  bool incomplete = false;                              ///< bit 7 of the first byte: further fragments follow
  std::uint16_t fragments_left = 0;                     ///< number of fragments that follow

  /// Writes the header. \rtsafe
  constexpr void encode(std::span<std::byte, kSize> out) const noexcept {
    out[0] = static_cast<std::byte>((static_cast<unsigned>(op_code) & 0x7FU) | (incomplete ? 0x80U : 0U));
    out[1] = std::byte{0};
    bytes::store_le(out.subspan<2, 2>(), fragments_left);
  }
  /// Error: kTooShort. Unknown operations are retained. \rtsafe
  [[nodiscard]] static constexpr Decoded<SdoInfoHeader> decode(std::span<const std::byte> in) noexcept {
    if (in.size() < kSize) return tl::unexpected(DecodeError::kTooShort);
    const auto raw = bytes::load_le<std::uint8_t>(in);
    return SdoInfoHeader{static_cast<SdoInfoOpCode>(raw & 0x7FU), (raw & 0x80U) != 0,
                         bytes::load_le<std::uint16_t>(in.subspan(2))};
  }
  constexpr bool operator==(const SdoInfoHeader&) const = default;
};

/// Whether a CoE service, header included, asks its receiver for something: an SDO request, except an abort, or an SDO
/// information request. \rtsafe
[[nodiscard]] constexpr bool is_coe_request(std::span<const std::byte> service) noexcept {
  const auto header = CoeHeader::decode(service);
  if (!header || service.size() <= CoeHeader::kSize) return false;
  const auto first = bytes::load_le<std::uint8_t>(service.subspan(CoeHeader::kSize));
  if (header->service == CoeService::kSdoRequest) {
    return first >> 5 != static_cast<std::uint8_t>(SdoRequestCommand::kAbort);
  }
  const auto op_code = static_cast<SdoInfoOpCode>(first & 0x7FU);
  return header->service == CoeService::kSdoInformation &&
         (op_code == SdoInfoOpCode::kListRequest || op_code == SdoInfoOpCode::kObjectRequest ||
          op_code == SdoInfoOpCode::kEntryRequest);
}

}  // namespace driveline::wire
