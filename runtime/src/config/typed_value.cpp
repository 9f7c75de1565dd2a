#include "driveline/runtime/config/typed_value.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <algorithm>
#include <array>
#include <bit>
#include <charconv>
#include <cstdint>
#include <limits>

#include "driveline/bytes/endian.hpp"
#include "driveline/esi/device_description.hpp"

namespace driveline::runtime {
namespace {

struct TypeRow {
  std::string_view name;
  ValueType type;
  std::size_t bytes;  ///< bytes of a value; 0: any number
  bool is_signed = false;
};

constexpr std::array kTypes = {
    TypeRow{"", ValueType::kRaw, 0},
    TypeRow{"raw", ValueType::kRaw, 0},
    TypeRow{"octet_string", ValueType::kRaw, 0},
    TypeRow{"bool", ValueType::kBool, 1},
    TypeRow{"uint8", ValueType::kUint8, 1},
    TypeRow{"uint16", ValueType::kUint16, 2},
    TypeRow{"uint32", ValueType::kUint32, 4},
    TypeRow{"uint64", ValueType::kUint64, 8},
    TypeRow{"int8", ValueType::kInt8, 1, true},
    TypeRow{"int16", ValueType::kInt16, 2, true},
    TypeRow{"int32", ValueType::kInt32, 4, true},
    TypeRow{"int64", ValueType::kInt64, 8, true},
    TypeRow{"float", ValueType::kFloat, 4},
    TypeRow{"double", ValueType::kDouble, 8},
    TypeRow{"string", ValueType::kString, 0},
    TypeRow{"unicode_string", ValueType::kUnicode, 0},
};

const TypeRow& row_of(ValueType type) {
  for (const auto& row : kTypes) {
    if (row.type == type && !row.name.empty()) return row;
  }
  return kTypes[0];
}

std::uint64_t load(std::span<const std::byte> data) {
  std::uint64_t value = 0;
  for (std::size_t i = 0; i < data.size(); ++i) value |= std::to_integer<std::uint64_t>(data[i]) << (8 * i);
  return value;
}

std::vector<std::byte> store(std::uint64_t value, std::size_t bytes) {
  std::vector<std::byte> data;
  for (std::size_t i = 0; i < bytes; ++i) data.push_back(static_cast<std::byte>(value >> (8 * i)));
  return data;
}

std::string hex(std::span<const std::byte> data) {
  std::string text;
  for (const auto byte : data)
    text += fmt::format("{}{:02x}", text.empty() ? "" : " ", std::to_integer<unsigned>(byte));
  return text;
}

std::int64_t sign_extend(std::uint64_t value, std::size_t bytes) {
  const auto shift = 64 - 8 * std::clamp<std::size_t>(bytes, 1, 8);
  return static_cast<std::int64_t>(value << shift) >> shift;
}

/// Converts UTF-16 little endian, as in UNICODE_STRING objects (ETG.1000.6 Table 64), to UTF-8; invalid units become
/// U+FFFD.
std::string utf8_from_utf16(std::span<const std::byte> data) {
  std::string text;
  for (std::size_t i = 0; i + 1 < data.size(); i += 2) {
    std::uint32_t code = bytes::load_le<std::uint16_t>(data.subspan(i, 2));
    if (code == 0) break;
    const bool pair = code >= 0xD800 && code < 0xDC00 && i + 3 < data.size();
    const std::uint32_t low = pair ? bytes::load_le<std::uint16_t>(data.subspan(i + 2, 2)) : 0;
    if (pair && low >= 0xDC00 && low < 0xE000) {
      code = 0x10000 + ((code - 0xD800) << 10) + (low - 0xDC00);
      i += 2;
    } else if (code >= 0xD800 && code < 0xE000) {
      code = 0xFFFD;
    }
    const auto add = [&text](std::uint32_t byte) { text += static_cast<char>(byte); };
    if (code < 0x80) {
      add(code);
    } else if (code < 0x800) {
      add(0xC0 | code >> 6);
    } else if (code < 0x10000) {
      add(0xE0 | code >> 12);
    } else {
      add(0xF0 | code >> 18);
      add(0x80 | (code >> 12 & 0x3F));
    }
    if (code >= 0x800) add(0x80 | (code >> 6 & 0x3F));
    if (code >= 0x80) add(0x80 | (code & 0x3F));
  }
  return text;
}

tl::unexpected<Error> not_a(std::string_view text, const TypeRow& row) {
  return fail(ErrorKind::kSetting, fmt::format("value \"{}\": {} is expected", text, row.name));
}

template <typename T>
Result<T> parse_real(std::string_view text, const TypeRow& row) {
  T value{};
  const auto result = std::from_chars(text.data(), text.data() + text.size(), value);
  if (result.ec != std::errc{} || result.ptr != text.data() + text.size()) return not_a(text, row);
  return value;
}

Result<std::vector<std::byte>> parse_integer(std::string_view text, const TypeRow& row) {
  std::string_view digits = text;
  const bool negative = row.is_signed && !digits.empty() && digits.front() == '-';
  if (negative) digits.remove_prefix(1);
  const bool hexadecimal = digits.size() > 2 && digits[0] == '0' && (digits[1] == 'x' || digits[1] == 'X');
  if (hexadecimal) digits.remove_prefix(2);
  std::uint64_t magnitude = 0;
  const auto result = std::from_chars(digits.data(), digits.data() + digits.size(), magnitude, hexadecimal ? 16 : 10);
  if (result.ec == std::errc::invalid_argument || result.ptr != digits.data() + digits.size()) return not_a(text, row);
  const auto bits = 8 * row.bytes;
  const std::uint64_t all = bits == 64 ? std::numeric_limits<std::uint64_t>::max() : (std::uint64_t{1} << bits) - 1;
  // A hexadecimal number is a bit pattern: 0xFFFF is -1 as an int16.
  const bool half = row.is_signed && (negative || !hexadecimal);
  const std::uint64_t limit = half ? (all >> 1) + (negative ? 1 : 0) : all;
  if (result.ec != std::errc{} || magnitude > limit) {
    return fail(ErrorKind::kSetting, fmt::format("value \"{}\": out of the range of {}", text, row.name));
  }
  return store(negative ? 0 - magnitude : magnitude, row.bytes);
}

Result<std::vector<std::byte>> parse_raw(const std::string_view value) {
  auto text = value;
  std::vector<std::byte> data;
  while (!text.empty()) {
    if (text.front() == ' ') {
      text.remove_prefix(1);
      continue;
    }
    if (text.starts_with("0x") || text.starts_with("0X")) text.remove_prefix(2);
    unsigned byte = 0;
    const auto* end = text.data() + std::min<std::size_t>(2, text.size());
    const auto result = std::from_chars(text.data(), end, byte, 16);
    if (result.ec != std::errc{} || result.ptr != end || text.size() < 2) {
      return fail(ErrorKind::kSetting,
                  fmt::format("value \"{}\": bytes of two hex digits are expected, or a --type", value));
    }
    data.push_back(static_cast<std::byte>(byte));
    text.remove_prefix(2);
  }
  return data;
}

}  // namespace

Result<ValueType> parse_type(std::string_view name) {
  for (const auto& row : kTypes) {
    if (row.name == name) return row.type;
  }
  return fail(ErrorKind::kSetting,
              fmt::format("type \"{}\": one of {} is expected", name, fmt::join(type_names(), ", ")));
}

std::vector<std::string_view> type_names() {
  std::vector<std::string_view> names;
  for (const auto& row : kTypes) {
    if (!row.name.empty()) names.push_back(row.name);
  }
  return names;
}

Result<TypedValue> decode_value(std::span<const std::byte> data, ValueType type) {
  const auto& row = row_of(type);
  if (row.bytes != 0 && data.size() != row.bytes) {
    return fail(ErrorKind::kSetting,
                fmt::format("the object has {} bytes, but {} has {}: {}", data.size(), row.name, row.bytes, hex(data)));
  }
  switch (type) {
    case ValueType::kRaw:
      return hex(data);
    case ValueType::kBool:
      return data[0] != std::byte{0};
    case ValueType::kUnicode:
      return utf8_from_utf16(data);
    case ValueType::kString: {
      std::string text;
      for (const auto byte : data) text += static_cast<char>(byte);
      return text.substr(0, text.find('\0'));
    }
    case ValueType::kFloat:
      return std::bit_cast<float>(bytes::load_le<std::uint32_t>(data));
    case ValueType::kDouble:
      return std::bit_cast<double>(bytes::load_le<std::uint64_t>(data));
    default:
      break;
  }
  if (row.is_signed) return sign_extend(load(data), row.bytes);
  return load(data);
}

Result<std::string> format_value(std::span<const std::byte> data, ValueType type) {
  const auto value = decode_value(data, type);
  if (!value) return tl::unexpected(value.error());
  switch (type) {
    case ValueType::kRaw: {
      std::string text;
      for (const auto byte : data) {
        text += fmt::format("{}0x{:02x}", text.empty() ? "" : " ", std::to_integer<unsigned>(byte));
      }
      return text;
    }
    case ValueType::kString:
    case ValueType::kUnicode:
      return std::get<std::string>(*value);
    case ValueType::kBool:
      return std::string(data[0] != std::byte{0} ? "1" : "0");
    case ValueType::kFloat:
      return fmt::format("{}", std::get<float>(*value));
    case ValueType::kDouble:
      return fmt::format("{}", std::get<double>(*value));
    default:
      break;
  }
  const auto& row = row_of(type);
  const auto pattern = fmt::format("0x{:0{}x}", load(data), 2 * row.bytes);
  if (row.is_signed) return fmt::format("{} {}", pattern, std::get<std::int64_t>(*value));
  return fmt::format("{} {}", pattern, load(data));
}

std::string_view type_name(ValueType type) noexcept {
  return row_of(type).name;
}

std::optional<ValueType> value_type_of(std::uint16_t data_type) noexcept {
  switch (static_cast<esi::DataType>(data_type)) {
    using enum esi::DataType;
    case kBoolean:
      return ValueType::kBool;
    case kInteger8:
      return ValueType::kInt8;
    case kInteger16:
      return ValueType::kInt16;
    case kInteger32:
      return ValueType::kInt32;
    case kInteger64:
      return ValueType::kInt64;
    case kUnsigned8:
      return ValueType::kUint8;
    case kUnsigned16:
      return ValueType::kUint16;
    case kUnsigned32:
      return ValueType::kUint32;
    case kUnsigned64:
      return ValueType::kUint64;
    case kReal32:
      return ValueType::kFloat;
    case kReal64:
      return ValueType::kDouble;
    case kVisibleString:
      return ValueType::kString;
    case kOctetString:
      return ValueType::kRaw;
    default:
      break;
  }
  constexpr std::uint16_t kUnicodeString = 0x000B;
  if (data_type == kUnicodeString) return ValueType::kUnicode;
  return std::nullopt;
}

std::size_t type_bytes(ValueType type) noexcept {
  return row_of(type).bytes;
}

Result<std::vector<std::byte>> parse_value(std::string_view text, ValueType type) {
  const auto& row = row_of(type);
  switch (type) {
    case ValueType::kRaw:
      return parse_raw(text);
    case ValueType::kString: {
      std::vector<std::byte> data;
      for (const char c : text) data.push_back(static_cast<std::byte>(c));
      return data;
    }
    case ValueType::kBool:
      if (text != "0" && text != "1") return not_a(text, row);
      return store(text == "1" ? 1 : 0, 1);
    case ValueType::kUnicode:
      return fail(ErrorKind::kSetting, "unicode_string can only be read; write its bytes as raw");
    case ValueType::kFloat:
      return parse_real<float>(text, row).map([](float v) { return store(std::bit_cast<std::uint32_t>(v), 4); });
    case ValueType::kDouble:
      return parse_real<double>(text, row).map([](double v) { return store(std::bit_cast<std::uint64_t>(v), 8); });
    default:
      return parse_integer(text, row);
  }
}

}  // namespace driveline::runtime
