#include <fmt/format.h>

#include <algorithm>
#include <iterator>

#include "driveline/esi/eds_file.hpp"

namespace driveline::esi {
namespace {

/// Object lists of CiA 306-1: objects that every device has, manufacturer-specific objects, all others.
enum class ObjectList : unsigned char { kMandatory, kOptional, kManufacturer };

ObjectList list_of(std::uint16_t index) noexcept {
  if (index == 0x1000 || index == 0x1001 || index == 0x1018) return ObjectList::kMandatory;
  return index >= 0x2000 && index < 0x6000 ? ObjectList::kManufacturer : ObjectList::kOptional;
}

bool is_text(DataType type) noexcept {
  return type == DataType::kVisibleString || type == DataType::kOctetString;
}

/// Converts little-endian hex digits of a description to an EDS number; empty stays empty.
std::string number(const std::string& little_endian) {
  std::string text;
  for (std::size_t at = little_endian.size(); at >= 2; at -= 2) text += little_endian.substr(at - 2, 2);
  return text.empty() ? text : "0x" + text;
}

std::string_view access_type(const ObjectEntry& entry) noexcept {
  if (!entry.writable) return "ro";
  return entry.readable ? "rw" : "wo";
}

class Writer {
 public:
  void section(std::string_view name) { fmt::format_to(out(), "{}[{}]\n", text_.empty() ? "" : "\n", name); }
  template <typename T>
  void value(std::string_view key, const T& what) {
    fmt::format_to(out(), "{}={}\n", key, what);
  }
  [[nodiscard]] std::string take() { return std::move(text_); }

 private:
  std::back_insert_iterator<std::string> out() { return std::back_inserter(text_); }
  std::string text_;
};

void write_entry(Writer& to, const ObjectEntry& entry, std::string_view name) {
  to.value("ParameterName", name);
  to.value("ObjectType", "0x7");
  to.value("DataType", fmt::format("0x{:04X}", static_cast<unsigned>(entry.type)));
  to.value("AccessType", access_type(entry));
  if (!is_text(entry.type)) {
    if (const auto low = number(entry.minimum_hex); !low.empty()) to.value("LowLimit", low);
    if (const auto high = number(entry.maximum_hex); !high.empty()) to.value("HighLimit", high);
    to.value("DefaultValue", number(entry.default_hex));
  }
  to.value("PDOMapping", entry.rx_mappable || entry.tx_mappable ? 1 : 0);
}

void write_object(Writer& to, const Object& object) {
  to.section(fmt::format("{:04X}", object.index));
  if (object.code == ObjectCode::kVariable && object.entries.size() == 1) {
    return write_entry(to, object.entries.front(), object.name);
  }
  to.value("ParameterName", object.name);
  to.value("ObjectType", fmt::format("0x{:X}", static_cast<unsigned>(object.code)));
  to.value("SubNumber", object.entries.size());
  for (const auto& entry : object.entries) {
    to.section(fmt::format("{:04X}sub{:X}", object.index, entry.subindex));
    write_entry(to, entry, entry.name);
  }
}

void write_list(Writer& to, std::string_view name, const DeviceDescription& device, ObjectList list) {
  to.section(name);
  const auto belongs = [list](const Object& object) { return list_of(object.index) == list; };
  to.value("SupportedObjects", std::count_if(device.objects.begin(), device.objects.end(), belongs));
  int place = 0;
  for (const auto& object : device.objects) {
    if (belongs(object)) to.value(fmt::format("{}", ++place), fmt::format("0x{:04X}", object.index));
  }
  for (const auto& object : device.objects) {
    if (belongs(object)) write_object(to, object);
  }
}

}  // namespace

std::string write_eds(const DeviceDescription& device, std::string_view file_name) {
  Writer to;
  to.section("FileInfo");
  to.value("FileName", file_name);
  to.value("FileVersion", 1);
  to.value("FileRevision", 0);
  to.value("EDSVersion", "4.0");
  to.value("Description", device.name);
  to.section("DeviceInfo");
  to.value("VendorName", device.vendor_name);
  to.value("VendorNumber", fmt::format("0x{:08X}", device.vendor_id));
  to.value("ProductName", device.name);
  to.value("ProductNumber", fmt::format("0x{:08X}", device.product_code));
  to.value("RevisionNumber", fmt::format("0x{:08X}", device.revision));
  to.value("OrderCode", device.type);
  to.value("NrOfRXPDO", device.rx_pdos.size());
  to.value("NrOfTXPDO", device.tx_pdos.size());
  to.value("DynamicChannelsSupported", 0);
  to.value("LSS_Supported", 0);
  write_list(to, "MandatoryObjects", device, ObjectList::kMandatory);
  write_list(to, "OptionalObjects", device, ObjectList::kOptional);
  write_list(to, "ManufacturerObjects", device, ObjectList::kManufacturer);
  return to.take();
}

}  // namespace driveline::esi
