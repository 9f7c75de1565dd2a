#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <tl/expected.hpp>
#include <vector>

/// Reads capture files for tests: pcapng as Wireshark and dumpcap write it. Written from the file format's
/// specification (IETF draft-ietf-opsawg-pcapng), independent of the product's own capture writer.
namespace driveline::replay {

struct CapturedPacket {
  std::size_t number = 0;            ///< 1-based, as Wireshark counts
  std::chrono::nanoseconds time{0};  ///< since the epoch of the capture's interface (Unix epoch)
  std::uint32_t interface_index = 0;
  std::uint32_t original_length = 0;  ///< bytes on the wire; `bytes` may be shorter (snap length)
  std::vector<std::byte> bytes;
};

/// All packets of a pcapng image in file order, either byte order. The error is a sentence with the byte offset.
[[nodiscard]] tl::expected<std::vector<CapturedPacket>, std::string> parse_pcapng(std::span<const std::byte> image);

/// The same from a file.
[[nodiscard]] tl::expected<std::vector<CapturedPacket>, std::string> read_pcapng(const std::filesystem::path& file);

/// Complete content of a file; nothing if it cannot be read.
[[nodiscard]] std::optional<std::vector<std::byte>> read_file(const std::filesystem::path& file);

/// Folder of the captures from real devices, which are not part of the project: the environment variable
/// DRIVELINE_CAPTURES, else shared/captures beside the source tree.
[[nodiscard]] std::filesystem::path captures_folder();

/// The capture file `name`; nothing if it is missing: skip the test with missing_capture_text().
[[nodiscard]] std::optional<std::filesystem::path> find_capture(std::string_view name);

/// Sentence for GTEST_SKIP: what is missing and how to provide it.
[[nodiscard]] std::string missing_capture_text(std::string_view name);

}  // namespace driveline::replay
