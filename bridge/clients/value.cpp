#include "value.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <bit>

namespace driveline::bridge::clients {
namespace {

constexpr std::size_t kHeader = 4;      // bytes: representation and options
constexpr std::size_t kKeyLength = 16;  // bytes
/// Limit above the bounds of all sequences in use, and low enough not to exhaust the memory.
constexpr std::uint32_t kMaxElements = 1U << 20;

/// Size of a scalar on the wire, which is also its alignment; 0 if the kind is not a scalar.
constexpr std::size_t size_of(Kind kind) noexcept {
  switch (kind) {
    case Kind::kBool:
    case Kind::kUint8:
      return 1;
    case Kind::kInt16:
    case Kind::kUint16:
      return 2;
    case Kind::kInt32:
    case Kind::kUint32:
    case Kind::kFloat:
    case Kind::kEnum:
      return 4;
    case Kind::kInt64:
    case Kind::kUint64:
    case Kind::kDouble:
      return 8;
    case Kind::kString:
    case Kind::kStruct:
      break;
  }
  return 0;
}

/// Reads the bytes of a sample in order. After an error all further reads fail.
class Decoder {
 public:
  explicit Decoder(Bytes sample) {
    if (sample.size() < kHeader || sample[0] != 0 || sample[1] > 1) {
      good_ = false;
      return;
    }
    little_ = sample[1] == 1;
    data_ = sample.subspan(kHeader);
  }

  [[nodiscard]] bool good() const noexcept { return good_; }

  void field(const Field& field, Value& to) {
    to.field = &field;
    to.structure = field.structure;
    if (!field.sequence && field.count == 0) return element(field, to);
    to.sequence = true;
    const auto count = field.sequence ? unsigned_number(4) : field.count;
    // Every element takes at least one byte: this detects a wrong count before memory is allocated for it.
    if (count > kMaxElements || count > data_.size() - at_) good_ = false;
    for (std::uint64_t i = 0; good_ && i < count; ++i) {
      auto& part = to.parts.emplace_back();
      part.field = &field;
      part.structure = field.structure;
      element(field, part);
    }
  }

  void structure(const StructType& type, Value& to) {
    to.structure = &type;
    to.parts.reserve(type.fields.size());
    for (const auto& each : type.fields) {
      if (!good_) return;
      field(each, to.parts.emplace_back());
    }
  }

 private:
  void element(const Field& field, Value& to) {
    if (field.kind == Kind::kStruct) return structure(*field.structure, to);
    if (field.kind == Kind::kString) return string(to);
    const auto size = size_of(field.kind);
    const auto bits = unsigned_number(size);
    switch (field.kind) {
      case Kind::kBool:
        to.scalar = bits != 0;
        break;
      case Kind::kFloat:
        to.scalar = static_cast<double>(std::bit_cast<float>(static_cast<std::uint32_t>(bits)));
        break;
      case Kind::kDouble:
        to.scalar = std::bit_cast<double>(bits);
        break;
      case Kind::kInt16:
      case Kind::kInt32:
      case Kind::kInt64: {
        const auto unused = 64 - 8 * size;
        to.scalar = static_cast<std::int64_t>(bits << unused) >> unused;
        break;
      }
      default:
        to.scalar = bits;
    }
  }

  /// Format: length with the terminating zero, characters, zero.
  void string(Value& to) {
    const auto length = unsigned_number(4);
    if (!good_ || length == 0 || length > data_.size() - at_ || data_[at_ + length - 1] != 0) {
      good_ = false;
      return;
    }
    to.scalar = std::string_view(reinterpret_cast<const char*>(&data_[at_]), length - 1);
    at_ += length;
  }

  std::uint64_t unsigned_number(std::size_t size) {
    const auto begin = (at_ + size - 1) / size * size;
    if (!good_ || begin + size > data_.size()) {
      good_ = false;
      return 0;
    }
    std::uint64_t value = 0;
    for (std::size_t i = 0; i < size; ++i) {
      const auto byte = data_[begin + (little_ ? size - 1 - i : i)];
      value = value << 8 | byte;
    }
    at_ = begin + size;
    return value;
  }

  Bytes data_;
  std::size_t at_ = 0;
  bool little_ = true;
  bool good_ = true;
};

}  // namespace

const Topic* find_topic(std::string_view name) noexcept {
  const auto all = topics();
  const auto found = std::find_if(all.begin(), all.end(), [&](const Topic& topic) { return topic.name == name; });
  return found == all.end() ? nullptr : &*found;
}

const Value* Value::find(std::string_view name) const noexcept {
  const auto found = std::find_if(parts.begin(), parts.end(),
                                  [&](const Value& part) { return part.field != nullptr && part.field->name == name; });
  return sequence || found == parts.end() ? nullptr : &*found;
}

double Value::number() const noexcept {
  if (const auto* real = std::get_if<double>(&scalar)) return *real;
  if (const auto* with_sign = std::get_if<std::int64_t>(&scalar)) return static_cast<double>(*with_sign);
  return static_cast<double>(whole());
}

std::uint64_t Value::whole() const noexcept {
  if (const auto* natural = std::get_if<std::uint64_t>(&scalar)) return *natural;
  if (const auto* with_sign = std::get_if<std::int64_t>(&scalar)) return static_cast<std::uint64_t>(*with_sign);
  if (const auto* truth = std::get_if<bool>(&scalar)) return *truth ? 1 : 0;
  return 0;
}

std::string_view Value::text() const noexcept {
  if (const auto* string = std::get_if<std::string_view>(&scalar)) return *string;
  const bool named = field != nullptr && field->kind == Kind::kEnum && !sequence;
  return named && whole() < field->enumeration->names.size() ? field->enumeration->names[whole()] : std::string_view{};
}

std::string describe(const NotDecoded& error) {
  return fmt::format("{} bytes are not a {} in plain CDR; the line may have another version", error.bytes, error.type);
}

tl::expected<Value, NotDecoded> decode(const StructType& structure, Bytes sample) {
  Decoder decoder(sample);
  Value value;
  decoder.structure(structure, value);
  if (decoder.good()) return value;
  return tl::unexpected(NotDecoded{sample.size(), structure.name});
}

std::optional<std::uint64_t> whole_field(const StructType& structure, Bytes sample, std::string_view name) {
  Decoder decoder(sample);
  for (const auto& field : structure.fields) {
    Value value;
    decoder.field(field, value);
    if (!decoder.good()) return std::nullopt;
    if (field.name == name) return value.whole();
  }
  return std::nullopt;
}

std::optional<std::vector<std::uint8_t>> key_of(const StructType& structure, Bytes sample) {
  std::vector<std::uint8_t> key;
  for (const auto& field : structure.fields) {
    if (!field.key) continue;
    const auto value = whole_field(structure, sample, field.name);
    if (!value) return std::nullopt;
    const auto size = size_of(field.kind);
    key.resize((key.size() + size - 1) / size * size);
    for (auto i = size; i-- > 0;) key.push_back(static_cast<std::uint8_t>(*value >> (8 * i)));
  }
  key.resize(kKeyLength);
  return key;
}

}  // namespace driveline::bridge::clients
