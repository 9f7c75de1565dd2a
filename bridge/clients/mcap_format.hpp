#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

/// Elements of an MCAP file (mcap.dev/spec, version 0): magic bytes, and records of an opcode, a length and a content.
/// All numbers are little-endian; a string is preceded by its length in 32 bits.
namespace driveline::bridge::clients::mcap {

inline constexpr std::array<std::uint8_t, 8> kMagic{0x89, 'M', 'C', 'A', 'P', '0', '\r', '\n'};

/// Opcode of a record (only those used in recordings).
enum class Opcode : std::uint8_t {
  kHeader = 0x01,
  kFooter = 0x02,
  kSchema = 0x03,
  kChannel = 0x04,
  kMessage = 0x05,
  kChunk = 0x06,
  kMessageIndex = 0x07,
  kChunkIndex = 0x08,
  kStatistics = 0x0B,
  kMetadata = 0x0C,
  kMetadataIndex = 0x0D,
  kSummaryOffset = 0x0E,
  kDataEnd = 0x0F,
};

/// CRC-32 of zlib and Ethernet (polynomial 04C11DB7h, reflected), computed over several pieces.
class Crc {
 public:
  /// Processes the next piece.
  void add(std::span<const std::uint8_t> bytes) noexcept;
  /// CRC of all pieces so far.
  [[nodiscard]] std::uint32_t value() const noexcept { return ~state_; }

 private:
  std::uint32_t state_ = 0xFFFF'FFFF;
};

/// Buffer to which fields and records are appended.
class Writer {
 public:
  Writer() { bytes_.reserve(kUsualSize); }

  /// Appends a number in as many bytes as its type has.
  template <class Number>
  void number(Number value) {
    for (std::size_t i = 0; i < sizeof(Number); ++i) bytes_.push_back(static_cast<std::uint8_t>(value >> (8 * i)));
  }
  /// Appends a string preceded by its length.
  void string(std::string_view text) {
    number(static_cast<std::uint32_t>(text.size()));
    bytes_.insert(bytes_.end(), text.begin(), text.end());
  }
  /// Appends bytes unchanged.
  void bytes(std::span<const std::uint8_t> more) { bytes_.insert(bytes_.end(), more.begin(), more.end()); }

  /// Starts a record; returns its start for end().
  [[nodiscard]] std::size_t begin(Opcode opcode) {
    number(static_cast<std::uint8_t>(opcode));
    number(std::uint64_t{0});
    return bytes_.size();
  }
  /// Enters the length of the record that started at `begun`.
  void end(std::size_t begun) { put(begun - 8, std::uint64_t{bytes_.size() - begun}); }

  /// Overwrites a number.
  template <class Number>
  void put(std::size_t at, Number value) {
    for (std::size_t i = 0; i < sizeof(Number); ++i) bytes_[at + i] = static_cast<std::uint8_t>(value >> (8 * i));
  }

  /// All bytes so far.
  [[nodiscard]] const std::vector<std::uint8_t>& content() const noexcept { return bytes_; }
  [[nodiscard]] std::size_t size() const noexcept { return bytes_.size(); }  ///< size in bytes
  /// Removes all bytes.
  void clear() noexcept { bytes_.clear(); }

 private:
  static constexpr std::size_t kUsualSize = 4096;
  std::vector<std::uint8_t> bytes_;
};

}  // namespace driveline::bridge::clients::mcap
