#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <map>
#include <string>
#include <vector>

namespace driveline::port {

using Bytes = std::vector<std::byte>;

/// A pcapng block decoded by a reader of the tests, which is independent of PcapngWriter.
struct PcapngBlock {
  std::uint32_t type = 0;
  Bytes body;  ///< between the two lengths
};

/// Splits a little-endian pcapng file into blocks. Throws std::runtime_error if the file violates the rules: lengths
/// that differ or are no multiple of 4, remaining bytes.
std::vector<PcapngBlock> pcapng_blocks(const Bytes& file);

/// A decoded Enhanced Packet Block.
struct PcapngPacket {
  std::uint64_t time_ns = 0;
  Bytes frame;
  std::map<std::uint16_t, std::uint64_t> options;  ///< code to little-endian value
};

PcapngPacket pcapng_packet(const PcapngBlock& block);
std::vector<PcapngPacket> pcapng_packets(const Bytes& file);

/// Options that start at `offset` in the body of a block.
std::map<std::uint16_t, std::uint64_t> pcapng_options(const PcapngBlock& block, std::size_t offset);

Bytes read_bytes(const std::filesystem::path& file);

}  // namespace driveline::port
