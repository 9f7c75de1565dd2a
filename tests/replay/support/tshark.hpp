#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <string_view>
#include <tl/expected.hpp>
#include <vector>

/// Wireshark's dissector as the oracle: reads the fields of a capture.
namespace driveline::replay {

/// Whether the program tshark can be run; if not, skip the test with missing_tshark_text().
[[nodiscard]] bool tshark_available();
[[nodiscard]] std::string missing_tshark_text();

/// The values of a field in a packet, in the order of occurrence.
using FieldValues = std::vector<std::string>;

/// One packet: a list of values per requested field.
using DissectedPacket = std::vector<FieldValues>;

/// Runs tshark over `capture` and returns the packets that match `display_filter` (empty: all). The error is tshark's
/// own text. `decode_as` is its option -d, such as `can.subdissector,canopen`.
[[nodiscard]] tl::expected<std::vector<DissectedPacket>, std::string> dissect(const std::filesystem::path& capture,
                                                                              const std::string& display_filter,
                                                                              const std::vector<std::string>& fields,
                                                                              const std::string& decode_as = {});

/// Number in tshark's notation: decimal, 0x hexadecimal, or True/False.
[[nodiscard]] std::uint64_t to_number(std::string_view text);

inline constexpr std::uint32_t kEthernetLink = 1;     ///< link type of Ethernet frames
inline constexpr std::uint32_t kSocketCanLink = 227;  ///< link type of CAN frames with the header of SocketCAN

/// Writes frames as a classic pcap file, one microsecond apart.
void write_pcap(const std::filesystem::path& file, std::span<const std::vector<std::byte>> frames,
                std::uint32_t link_type = kEthernetLink);

}  // namespace driveline::replay
