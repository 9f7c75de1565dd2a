#include "text/sii_dump.hpp"

#include <fmt/format.h>
#include <algorithm>
#include <string_view>

#include "driveline/bytes/endian.hpp"

namespace driveline::cli {
namespace {

constexpr std::size_t kBytesPerLine = 16;
constexpr std::uint16_t kEnd = 0xFFFF;

/// A part of the fixed words (ETG.1000.6 Table 16).
struct Section {
  std::size_t first_word;
  std::size_t words;
  std::string_view name;
};
constexpr Section kFixed[] = {
    {0x00, 8, "configuration area and checksum"},
    {0x08, 8, "vendor, product, revision, serial number"},
    {0x10, 4, "delays"},
    {0x14, 4, "mailboxes in BOOT"},
    {0x18, 5, "mailboxes and protocols"},
    {0x1D, 33, "reserved"},
    {0x3E, 2, "size and version"},
};
constexpr std::size_t kFirstCategory = 0x40;

/// Name of a category (ETG.1000.6 Table 19, ETG.2010).
std::string_view category_name(std::uint16_t type) {
  switch (type) {
    case 10:
      return "strings";
    case 20:
      return "data types";
    case 30:
      return "general";
    case 40:
      return "FMMU";
    case 41:
      return "sync managers";
    case 42:
      return "FMMU extended";
    case 43:
      return "sync units";
    case 50:
      return "TxPDO";
    case 51:
      return "RxPDO";
    case 60:
      return "distributed clock";
    case kEnd:
      return "end";
    default:
      return type < 0x0800 ? "unknown" : "of the vendor";
  }
}

char printable(std::byte byte) {
  const auto value = std::to_integer<unsigned char>(byte);
  return value >= 0x20 && value < 0x7F ? static_cast<char>(value) : '.';
}

std::string hex_lines(std::span<const std::byte> bytes, std::size_t first_byte) {
  std::string text;
  for (std::size_t at = 0; at < bytes.size(); at += kBytesPerLine) {
    const auto line = bytes.subspan(at, std::min(kBytesPerLine, bytes.size() - at));
    std::string hex;
    std::string letters;
    for (const auto byte : line) {
      hex += fmt::format(" {:02x}", std::to_integer<unsigned>(byte));
      letters += printable(byte);
    }
    text += fmt::format("  {:04x} {:<48}  {}\n", first_byte + at, hex, letters);
  }
  return text;
}

}  // namespace

std::string sii_dump(std::span<const std::byte> image) {
  std::string text;
  const auto word_count = image.size() / 2;
  auto show = [&](std::size_t first_word, std::size_t words, const std::string& name) {
    const auto end = std::min(first_word + words, word_count);
    if (first_word >= end) return;
    text += fmt::format("Word 0x{:04x}: {}\n", first_word, name);
    text += hex_lines(image.subspan(2 * first_word, 2 * (end - first_word)), 2 * first_word);
  };
  for (const auto& section : kFixed) show(section.first_word, section.words, std::string(section.name));
  auto word = [&](std::size_t at) { return bytes::load_le<std::uint16_t>(image.subspan(2 * at, 2)); };
  std::size_t at = kFirstCategory;
  while (at + 1 < word_count && word(at) != kEnd) {
    const std::size_t length = word(at + 1);
    if (at + 2 + length > word_count) break;
    show(at, 2 + length, fmt::format("category {} ({}), {} words", word(at), category_name(word(at)), length));
    at += 2 + length;
  }
  if (at < word_count) {
    const bool ends = word(at) == kEnd;
    show(at, word_count - at, ends ? "end, and bytes read after it" : "remaining bytes without category");
  }
  return text;
}

}  // namespace driveline::cli
