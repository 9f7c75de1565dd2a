#include "eds_value.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <charconv>
#include <cmath>
#include <cstddef>
#include <limits>
#include <span>
#include <vector>

#include "driveline/esi/hex.hpp"
#include "text.hpp"

namespace driveline::esi {
namespace {

constexpr std::string_view kNodeId = "$nodeid";

bool is_signed(DataType type) noexcept {
  return type == DataType::kInteger8 || type == DataType::kInteger16 || type == DataType::kInteger32 ||
         type == DataType::kInteger64;
}

/// Bytes of a value in a data sheet: a single bit and a bit field have one.
std::size_t bytes_of(DataType type) noexcept {
  return (bits_of_number(type) + 7U) / 8U;
}

std::string little_endian(std::uint64_t value, std::size_t bytes) {
  std::vector<std::byte> raw;
  for (std::size_t i = 0; i < bytes; ++i) raw.push_back(static_cast<std::byte>(value >> (8 * i) & 0xFF));
  return to_hex(raw);
}

template <typename Number>
std::optional<Number> whole(std::string_view digits, int base) {
  Number number = 0;
  const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), number, base);
  if (digits.empty() || error != std::errc{} || end != digits.data() + digits.size()) return std::nullopt;
  return number;
}

std::optional<std::uint64_t> parse_magnitude(std::string_view text) {
  if (text.starts_with("0x")) return whole<std::uint64_t>(text.substr(2), 16);
  const bool octal = text.size() > 1 && text.front() == '0' && text.find_first_of("89") == std::string_view::npos;
  return whole<std::uint64_t>(text, octal ? 8 : 10);
}

std::optional<std::string> hex_of_real(DataType type, std::string_view text) {
  const auto bytes = bytes_of(type);
  if (const auto bits = text.starts_with("0x") ? parse_magnitude(text) : std::nullopt) {
    if (bytes == 4 && *bits > 0xFFFFFFFFU) return std::nullopt;
    return little_endian(*bits, bytes);
  }
  double number = 0.0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  if (error != std::errc{} || end != text.data() + text.size()) return std::nullopt;
  if (bytes == 4 && std::isfinite(number) && std::abs(number) > std::numeric_limits<float>::max()) return std::nullopt;
  if (bytes == 4) return little_endian(std::bit_cast<std::uint32_t>(static_cast<float>(number)), bytes);
  return little_endian(std::bit_cast<std::uint64_t>(number), bytes);
}

}  // namespace

std::uint16_t bits_of_number(DataType type) noexcept {
  switch (type) {
    case DataType::kBoolean:
      return 1;
    case DataType::kInteger8:
    case DataType::kUnsigned8:
      return 8;
    case DataType::kInteger16:
    case DataType::kUnsigned16:
      return 16;
    case DataType::kInteger32:
    case DataType::kUnsigned32:
    case DataType::kReal32:
      return 32;
    case DataType::kInteger64:
    case DataType::kUnsigned64:
    case DataType::kReal64:
      return 64;
    case DataType::kVisibleString:
    case DataType::kOctetString:
      return 0;
    default:
      break;
  }
  return static_cast<std::uint16_t>(static_cast<unsigned>(type) - static_cast<unsigned>(DataType::kBit1) + 1);
}

std::optional<EdsNumber> parse_eds_number(std::string_view text) {
  auto compact = lower_case(text);
  std::erase_if(compact, [](char c) { return c == ' ' || c == '\t'; });
  EdsNumber number;
  if (const auto at = compact.find(kNodeId); at != std::string::npos) {
    number.adds_node_id = true;
    compact.erase(at, kNodeId.size());
    if (compact.empty()) return number;
    // The sign of the sum is behind the node-ID that comes first, else in front of it.
    const auto plus = at == 0 ? 0 : compact.size() - 1;
    if (compact[plus] != '+') return std::nullopt;
    compact.erase(plus, 1);
  } else if (!compact.empty() && compact.front() == '-') {
    number.negative = true;
    compact.erase(0, 1);
  }
  const auto magnitude = parse_magnitude(compact);
  if (!magnitude) return std::nullopt;
  number.magnitude = *magnitude;
  return number;
}

std::optional<std::string> hex_of_number(DataType type, const EdsNumber& number) {
  const unsigned bits = bits_of_number(type);
  if (bits == 0 || type == DataType::kReal32 || type == DataType::kReal64) return std::nullopt;
  const auto most = bits == 64 ? ~std::uint64_t{0} : (std::uint64_t{1} << bits) - 1;
  const auto least = is_signed(type) ? std::uint64_t{1} << (bits - 1) : 0;
  if (number.negative ? number.magnitude > least : number.magnitude > most) return std::nullopt;
  return little_endian(number.negative ? ~number.magnitude + 1 : number.magnitude, bytes_of(type));
}

std::optional<std::string> hex_of_value(DataType type, std::string_view text, bool& adds_node_id) {
  switch (type) {
    case DataType::kVisibleString:
      return to_hex(std::as_bytes(std::span(text)));
    case DataType::kOctetString: {
      const auto bytes = parse_hex(text);
      return bytes ? to_hex(*bytes) : to_hex(std::as_bytes(std::span(text)));
    }
    case DataType::kReal32:
    case DataType::kReal64:
      return hex_of_real(type, lower_case(text));
    default:
      break;
  }
  const auto number = parse_eds_number(text);
  if (!number) return std::nullopt;
  adds_node_id = number->adds_node_id;
  return hex_of_number(type, *number);
}

std::string text_of_number(DataType type, const std::string& hex) {
  const auto bytes = parse_hex(hex).value_or(std::vector<std::byte>{});
  if (bytes.empty()) return {};
  std::uint64_t raw = 0;
  for (std::size_t i = bytes.size(); i-- > 0;) raw = raw << 8 | std::to_integer<std::uint64_t>(bytes[i]);
  if (is_signed(type)) {
    const auto unused = 64U - 8U * static_cast<unsigned>(std::min<std::size_t>(bytes.size(), 8));
    return fmt::format("{}", static_cast<std::int64_t>(raw << unused) >> unused);
  }
  const double real =
      type == DataType::kReal64 ? std::bit_cast<double>(raw) : std::bit_cast<float>(static_cast<std::uint32_t>(raw));
  if (type == DataType::kReal64 && std::isfinite(real)) return fmt::format("{}", real);
  if (type == DataType::kReal32 && std::isfinite(real)) return fmt::format("{}", static_cast<float>(real));
  return fmt::format("0x{:0{}X}", raw, 2 * bytes.size());
}

std::string plus(const std::string& hex, std::uint8_t addend) {
  auto bytes = parse_hex(hex).value_or(std::vector<std::byte>{});
  unsigned carry = addend;
  for (auto& byte : bytes) {
    carry += std::to_integer<unsigned>(byte);
    byte = static_cast<std::byte>(carry & 0xFF);
    carry >>= 8;
  }
  return to_hex(bytes);
}

}  // namespace driveline::esi
