#include "driveline/ecat_master/soe/soe_parameter.hpp"

#include "driveline/bytes/endian.hpp"

namespace driveline::ecat_master {
namespace {

using wire::SoeElement;
using wire::SoeListHeader;

/// Reads elements one after another; ok() turns false when an element is missing.
class ElementReader {
 public:
  ElementReader(std::span<const std::byte> rest, std::optional<wire::SoeAttribute> attribute)
      : rest_(rest), attribute_(attribute) {}

  void take(SoeElement element, SoeParameter& parameter) {
    switch (element) {
      case SoeElement::kState:
        if (const auto bytes = fixed(sizeof(std::uint16_t)); ok_)
          parameter.state = bytes::load_le<std::uint16_t>(bytes);
        break;
      case SoeElement::kName:
        parameter.name = text();
        break;
      case SoeElement::kAttribute:
        if (const auto bytes = fixed(wire::SoeAttribute::kSize); ok_) {
          attribute_ = *wire::SoeAttribute::decode(bytes);
          parameter.attribute = attribute_;
        }
        break;
      case SoeElement::kUnit:
        parameter.unit = text();
        break;
      case SoeElement::kMin:
        parameter.min = datum();
        break;
      case SoeElement::kMax:
        parameter.max = datum();
        break;
      case SoeElement::kValue:
        parameter.value = datum();
        break;
      case SoeElement::kDefault:
        parameter.preset = datum();
        break;
    }
  }
  /// Whether all elements were present and no bytes are left.
  [[nodiscard]] bool ok() const noexcept { return ok_ && rest_.empty(); }

 private:
  std::span<const std::byte> fixed(std::size_t size) {
    if (!ok_ || rest_.size() < size) {
      ok_ = false;
      return {};
    }
    const auto bytes = rest_.first(size);
    rest_ = rest_.subspan(size);
    return bytes;
  }
  std::span<const std::byte> list() {
    const auto header = SoeListHeader::decode(fixed(SoeListHeader::kSize));
    return header ? fixed(header->length) : std::span<const std::byte>{};
  }
  std::string text() {
    std::string text;
    for (const auto byte : list()) text += static_cast<char>(byte);
    return text;
  }
  std::vector<std::byte> datum() {
    auto bytes = !attribute_ ? fixed(rest_.size()) : attribute_->list ? list() : fixed(attribute_->element_size());
    return {bytes.begin(), bytes.end()};
  }

  std::span<const std::byte> rest_;
  std::optional<wire::SoeAttribute> attribute_;
  bool ok_ = true;
};

}  // namespace

std::optional<SoeParameter> decode_parameter(const SoeReading& reading, std::optional<wire::SoeAttribute> attribute) {
  SoeParameter parameter;
  ElementReader reader(reading.data, attribute);
  for (const auto element : wire::kSoeElements) {
    if (reading.elements.has(element)) reader.take(element, parameter);
  }
  return reader.ok() ? std::optional(std::move(parameter)) : std::nullopt;
}

std::optional<std::vector<wire::Idn>> idns_of(std::span<const std::byte> list) {
  if (list.size() % sizeof(wire::Idn::raw) != 0) return std::nullopt;
  std::vector<wire::Idn> idns;
  for (; !list.empty(); list = list.subspan(sizeof(wire::Idn::raw))) {
    idns.push_back({bytes::load_le<std::uint16_t>(list)});
  }
  return idns;
}

}  // namespace driveline::ecat_master
