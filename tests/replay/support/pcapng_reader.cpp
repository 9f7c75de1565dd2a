#include "pcapng_reader.hpp"

#include <algorithm>
#include <array>
#include <cstdlib>
#include <fstream>
#include <iterator>

namespace driveline::replay {
namespace {

constexpr std::uint32_t kSectionHeader = 0x0A0D0D0A;
constexpr std::uint32_t kInterfaceDescription = 1;
constexpr std::uint32_t kSimplePacket = 3;
constexpr std::uint32_t kEnhancedPacket = 6;
constexpr std::uint32_t kByteOrderMagic = 0x1A2B3C4D;
constexpr std::uint16_t kOptionTimeResolution = 9;

struct Interface {
  std::uint8_t time_resolution = 6;  ///< if_tsresol: 10^-n s, or 2^-n s with the top bit set; default microseconds
};

/// Unsigned numbers in the section's byte order.
class Fields {
 public:
  explicit Fields(bool big_endian = false) : big_endian_(big_endian) {}

  [[nodiscard]] std::uint32_t u32(std::span<const std::byte> bytes, std::size_t offset) const {
    return number(bytes.subspan(offset, 4));
  }
  [[nodiscard]] std::uint16_t u16(std::span<const std::byte> bytes, std::size_t offset) const {
    return static_cast<std::uint16_t>(number(bytes.subspan(offset, 2)));
  }

 private:
  [[nodiscard]] std::uint32_t number(std::span<const std::byte> bytes) const {
    std::uint32_t value = 0;
    for (std::size_t i = 0; i < bytes.size(); ++i) {
      const std::size_t from_top = big_endian_ ? i : bytes.size() - 1 - i;
      value = (value << 8) | std::to_integer<std::uint32_t>(bytes[from_top]);
    }
    return value;
  }
  bool big_endian_;
};

std::chrono::nanoseconds to_time(std::uint64_t ticks, std::uint8_t resolution) {
  if ((resolution & 0x80U) != 0) {
    const unsigned shift = std::min(resolution & 0x7FU, 62U);
    const std::uint64_t fraction = ticks & ((std::uint64_t{1} << shift) - 1);
    const auto fraction_ns = static_cast<std::int64_t>(static_cast<long double>(fraction) * 1e9L /
                                                       static_cast<long double>(std::uint64_t{1} << shift));
    return std::chrono::seconds(static_cast<std::int64_t>(ticks >> shift)) + std::chrono::nanoseconds(fraction_ns);
  }
  std::uint64_t nanoseconds = ticks;
  for (unsigned digits = resolution; digits < 9; ++digits) nanoseconds *= 10;
  for (unsigned digits = 9; digits < resolution; ++digits) nanoseconds /= 10;
  return std::chrono::nanoseconds(static_cast<std::int64_t>(nanoseconds));
}

class Parser {
 public:
  explicit Parser(std::span<const std::byte> image) : image_(image) {}

  tl::expected<std::vector<CapturedPacket>, std::string> run() {
    if (image_.size() < 28 || fields_.u32(image_, 0) != kSectionHeader) return error("no pcapng section header");
    while (offset_ < image_.size()) {
      if (auto problem = read_block()) return error(*problem);
    }
    return std::move(packets_);
  }

 private:
  using Problem = std::optional<std::string>;

  tl::unexpected<std::string> error(const std::string& text) const {
    return tl::unexpected("at byte " + std::to_string(offset_) + ": " + text);
  }

  Problem read_block() {
    const auto rest = image_.subspan(offset_);
    if (rest.size() < 12) return "block shorter than 12 bytes";
    // The type of the section header reads the same in both byte orders; its magic number tells the order.
    if (Fields().u32(rest, 0) == kSectionHeader) {
      const bool little = Fields(false).u32(rest, 8) == kByteOrderMagic;
      if (!little && Fields(true).u32(rest, 8) != kByteOrderMagic) return "bad byte-order magic";
      fields_ = Fields(!little);
      interfaces_.clear();
    }
    const std::uint32_t type = fields_.u32(rest, 0);
    const std::uint32_t length = fields_.u32(rest, 4);
    if (length < 12 || length % 4 != 0 || length > rest.size()) return "bad block length " + std::to_string(length);
    if (fields_.u32(rest, length - 4) != length) return "block lengths at both ends differ";
    const auto body = rest.subspan(8, length - 12);
    Problem problem;
    if (type == kInterfaceDescription) problem = read_interface(body);
    if (type == kEnhancedPacket) problem = read_enhanced_packet(body);
    if (type == kSimplePacket) problem = read_simple_packet(body);
    if (!problem) offset_ += length;
    return problem;
  }

  Problem read_interface(std::span<const std::byte> body) {
    if (body.size() < 8) return "interface description too short";
    Interface interface;
    for (std::size_t at = 8; at + 4 <= body.size();) {
      const std::uint16_t code = fields_.u16(body, at);
      const std::size_t length = fields_.u16(body, at + 2);
      if (code == 0) break;
      if (at + 4 + length > body.size()) return "option longer than its block";
      if (code == kOptionTimeResolution && length == 1) {
        interface.time_resolution = std::to_integer<std::uint8_t>(body[at + 4]);
      }
      at += 4 + (length + 3) / 4 * 4;
    }
    interfaces_.push_back(interface);
    return std::nullopt;
  }

  Problem read_enhanced_packet(std::span<const std::byte> body) {
    if (body.size() < 20) return "packet block too short";
    const std::uint32_t interface = fields_.u32(body, 0);
    if (interface >= interfaces_.size()) return "packet of an undeclared interface";
    const std::size_t captured = fields_.u32(body, 12);
    if (captured > body.size() - 20) return "captured length exceeds the block";
    const std::uint64_t ticks = (std::uint64_t{fields_.u32(body, 4)} << 32) | fields_.u32(body, 8);
    add(interface, to_time(ticks, interfaces_[interface].time_resolution), fields_.u32(body, 16),
        body.subspan(20, captured));
    return std::nullopt;
  }

  Problem read_simple_packet(std::span<const std::byte> body) {
    if (interfaces_.empty()) return "packet of an undeclared interface";
    if (body.size() < 4) return "packet block too short";
    const std::uint32_t original = fields_.u32(body, 0);
    add(0, std::chrono::nanoseconds(0), original,
        body.subspan(4, std::min(static_cast<std::size_t>(original), body.size() - 4)));
    return std::nullopt;
  }

  void add(std::uint32_t interface, std::chrono::nanoseconds time, std::uint32_t original,
           std::span<const std::byte> bytes) {
    packets_.push_back({packets_.size() + 1, time, interface, original, {bytes.begin(), bytes.end()}});
  }

  std::span<const std::byte> image_;
  std::size_t offset_ = 0;
  Fields fields_;
  std::vector<Interface> interfaces_;
  std::vector<CapturedPacket> packets_;
};

}  // namespace

tl::expected<std::vector<CapturedPacket>, std::string> parse_pcapng(std::span<const std::byte> image) {
  return Parser(image).run();
}

tl::expected<std::vector<CapturedPacket>, std::string> read_pcapng(const std::filesystem::path& file) {
  const auto image = read_file(file);
  if (!image) return tl::unexpected("cannot read " + file.string());
  return parse_pcapng(*image).map_error([&](const std::string& text) { return file.string() + " " + text; });
}

std::optional<std::vector<std::byte>> read_file(const std::filesystem::path& file) {
  std::ifstream stream(file, std::ios::binary);
  if (!stream) return std::nullopt;
  const std::string text{std::istreambuf_iterator<char>(stream), std::istreambuf_iterator<char>()};
  std::vector<std::byte> bytes(text.size());
  std::transform(text.begin(), text.end(), bytes.begin(), [](char c) { return static_cast<std::byte>(c); });
  return bytes;
}

std::filesystem::path captures_folder() {
  const char* configured = std::getenv("DRIVELINE_CAPTURES");
  if (configured != nullptr && *configured != '\0') return configured;
  return std::filesystem::path(DRIVELINE_SOURCE_FOLDER) / ".." / "shared" / "captures";
}

std::optional<std::filesystem::path> find_capture(std::string_view name) {
  const auto file = captures_folder() / name;
  std::error_code ignored;
  if (!std::filesystem::is_regular_file(file, ignored)) return std::nullopt;
  return file;
}

std::string missing_capture_text(std::string_view name) {
  return "the capture " + std::string(name) + " is not in " + captures_folder().string() +
         "; set DRIVELINE_CAPTURES to the folder that has it";
}

}  // namespace driveline::replay
