#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <map>
#include <stdexcept>
#include <string>
#include <vector>

/// A reader of pcapng files for tests, which is independent of PcapngWriter.
namespace driveline::pcapng_test {

using Bytes = std::vector<std::byte>;

/// A pcapng block.
struct PcapngBlock {
  std::uint32_t type = 0;
  Bytes body;  ///< between the two lengths
};

/// A decoded Enhanced Packet Block.
struct PcapngPacket {
  std::uint64_t time_ns = 0;
  Bytes frame;
  std::map<std::uint16_t, std::uint64_t> options;  ///< code to little-endian value
};

inline std::uint64_t number(const Bytes& bytes, std::size_t offset, std::size_t size) {
  if (offset + size > bytes.size()) throw std::runtime_error{"the file ends within a number"};
  std::uint64_t value = 0;
  for (std::size_t i = size; i-- > 0;) value = value * 256 + std::to_integer<std::uint64_t>(bytes[offset + i]);
  return value;
}

inline Bytes part(const Bytes& bytes, std::size_t offset, std::size_t size) {
  if (offset + size > bytes.size()) throw std::runtime_error{"the file ends within a field"};
  const auto begin = bytes.begin() + static_cast<std::ptrdiff_t>(offset);
  return {begin, begin + static_cast<std::ptrdiff_t>(size)};
}

inline std::size_t padded(std::size_t size) {
  return (size + 3) & ~std::size_t{3};
}

/// Splits a little-endian pcapng file into blocks. Throws std::runtime_error if the file violates the rules: lengths
/// that differ or are no multiple of 4, remaining bytes.
inline std::vector<PcapngBlock> pcapng_blocks(const Bytes& file) {
  std::vector<PcapngBlock> blocks;
  for (std::size_t at = 0; at < file.size();) {
    const std::size_t length = number(file, at + 4, 4);
    if (length < 12 || length % 4 != 0) throw std::runtime_error{"bad block length"};
    if (number(file, at + length - 4, 4) != length) throw std::runtime_error{"the two lengths of a block differ"};
    blocks.push_back({static_cast<std::uint32_t>(number(file, at, 4)), part(file, at + 8, length - 12)});
    at += length;
  }
  return blocks;
}

/// Options that start at `offset` in the body of a block.
inline std::map<std::uint16_t, std::uint64_t> pcapng_options(const PcapngBlock& block, std::size_t offset) {
  std::map<std::uint16_t, std::uint64_t> options;
  while (true) {
    const auto code = static_cast<std::uint16_t>(number(block.body, offset, 2));
    const std::size_t size = number(block.body, offset + 2, 2);
    offset += 4;
    if (code == 0) break;
    options[code] = number(block.body, offset, std::min<std::size_t>(size, 8));
    offset += padded(size);
  }
  if (offset != block.body.size()) throw std::runtime_error{"bytes after the end of the options"};
  return options;
}

inline PcapngPacket pcapng_packet(const PcapngBlock& block) {
  const std::size_t captured = number(block.body, 12, 4);
  if (number(block.body, 16, 4) != captured) throw std::runtime_error{"captured and original length differ"};
  return {.time_ns = (number(block.body, 4, 4) << 32) | number(block.body, 8, 4),
          .frame = part(block.body, 20, captured),
          .options = pcapng_options(block, 20 + padded(captured))};
}

inline std::vector<PcapngPacket> pcapng_packets(const Bytes& file) {
  std::vector<PcapngPacket> packets;
  for (const PcapngBlock& block : pcapng_blocks(file)) {
    if (block.type == 6) packets.push_back(pcapng_packet(block));
  }
  return packets;
}

inline Bytes read_bytes(const std::filesystem::path& file) {
  std::ifstream stream{file, std::ios::binary};
  Bytes bytes;
  std::transform(std::istreambuf_iterator<char>{stream}, {}, std::back_inserter(bytes),
                 [](char character) { return static_cast<std::byte>(character); });
  return bytes;
}

}  // namespace driveline::pcapng_test
