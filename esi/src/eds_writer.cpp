#include <fmt/format.h>

#include <algorithm>
#include <iterator>

#include "driveline/esi/eds_file.hpp"
#include "driveline/esi/hex.hpp"
#include "eds_value.hpp"
#include "text.hpp"

namespace driveline::esi {
namespace {

/// Object lists of CiA 306-1: objects that every device has, manufacturer-specific objects, all others.
enum class ObjectList : unsigned char { kMandatory, kOptional, kManufacturer };

ObjectList list_of(std::uint16_t index) noexcept {
  if (index == 0x1000 || index == 0x1001 || index == 0x1018) return ObjectList::kMandatory;
  return index >= 0x2000 && index < 0x6000 ? ObjectList::kManufacturer : ObjectList::kOptional;
}

/// Converts little-endian hex digits to a value of the file; empty: none, or a text that the file cannot hold.
std::string value_text(DataType type, const std::string& hex, bool adds_node_id) {
  if (type == DataType::kOctetString) return hex;
  if (type != DataType::kVisibleString) return (adds_node_id ? "$NODEID+" : "") + text_of_number(type, hex);
  std::string text;
  for (const auto byte : parse_hex(hex).value_or(std::vector<std::byte>{})) text += static_cast<char>(byte);
  const bool printable = std::all_of(text.begin(), text.end(), [](char c) { return c >= 0x20 && c < 0x7F; });
  return printable && trimmed(text) == text ? text : std::string{};
}

/// rwr and rww can be mapped in one direction only (CiA 306-1).
std::string_view access_type(const ObjectEntry& entry) noexcept {
  if (!entry.writable) return "ro";
  if (!entry.readable) return "wo";
  if (entry.rx_mappable == entry.tx_mappable) return "rw";
  return entry.rx_mappable ? "rww" : "rwr";
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

/// Writes the objects of a file.
class ObjectWriter {
 public:
  ObjectWriter(Writer& to, const EdsFile& file) : to_(to), file_(file) {}

  void write_list(std::string_view name, ObjectList list) {
    to_.section(name);
    const auto& objects = file_.device.objects;
    const auto belongs = [list](const Object& object) { return list_of(object.index) == list; };
    to_.value("SupportedObjects", std::count_if(objects.begin(), objects.end(), belongs));
    int place = 0;
    for (const auto& object : objects) {
      if (belongs(object)) to_.value(fmt::format("{}", ++place), fmt::format("0x{:04X}", object.index));
    }
    for (const auto& object : objects) {
      if (belongs(object)) write_object(object);
    }
  }

 private:
  void write_object(const Object& object) {
    to_.section(fmt::format("{:04X}", object.index));
    if (object.code == ObjectCode::kVariable && object.entries.size() == 1) {
      return write_entry(object.index, object.entries.front(), object.name);
    }
    to_.value("ParameterName", object.name);
    to_.value("ObjectType", fmt::format("0x{:X}", static_cast<unsigned>(object.code)));
    to_.value("SubNumber", object.entries.size());
    for (const auto& entry : object.entries) {
      to_.section(fmt::format("{:04X}sub{:X}", object.index, entry.subindex));
      write_entry(object.index, entry, entry.name);
    }
  }

  void write_entry(std::uint16_t index, const ObjectEntry& entry, std::string_view name) {
    const EntryAddress address{index, entry.subindex};
    const auto& formulas = file_.node_id_defaults;
    const bool adds = std::binary_search(formulas.begin(), formulas.end(), address);
    const auto preset = value_text(entry.type, entry.default_hex, adds);
    const bool text = bits_of_number(entry.type) == 0;
    to_.value("ParameterName", name);
    to_.value("ObjectType", "0x7");
    to_.value("DataType", fmt::format("0x{:04X}", static_cast<unsigned>(entry.type)));
    to_.value("AccessType", access_type(entry));
    if (const auto low = text_of_number(entry.type, entry.minimum_hex); !text && !low.empty())
      to_.value("LowLimit", low);
    if (const auto high = text_of_number(entry.type, entry.maximum_hex); !text && !high.empty())
      to_.value("HighLimit", high);
    if (!text || !preset.empty()) to_.value("DefaultValue", preset);
    to_.value("PDOMapping", entry.rx_mappable || entry.tx_mappable ? 1 : 0);
    const auto value = std::lower_bound(file_.values.begin(), file_.values.end(), address,
                                        [](const EdsValue& one, EntryAddress wanted) { return one.entry < wanted; });
    if (value == file_.values.end() || value->entry != address) return;
    const auto shown = value_text(entry.type, value->hex, value->adds_node_id);
    if (!shown.empty()) to_.value("ParameterValue", shown);
  }

  Writer& to_;
  const EdsFile& file_;
};

void write_device(Writer& to, const EdsFile& file) {
  const auto& device = file.device;
  to.section("DeviceInfo");
  to.value("VendorName", device.vendor_name);
  to.value("VendorNumber", fmt::format("0x{:08X}", device.vendor_id));
  to.value("ProductName", device.name);
  to.value("ProductNumber", fmt::format("0x{:08X}", device.product_code));
  to.value("RevisionNumber", fmt::format("0x{:08X}", device.revision));
  to.value("OrderCode", device.type);
  if (!file.bit_rates.empty()) {
    for (const auto rate : kEdsBitRates) {
      const bool has = std::find(file.bit_rates.begin(), file.bit_rates.end(), rate) != file.bit_rates.end();
      to.value(fmt::format("BaudRate_{}", rate), has ? 1 : 0);
    }
    to.value("SimpleBootUpMaster", 0);
    to.value("SimpleBootUpSlave", 1);
    to.value("Granularity", 8);
  }
  to.value("NrOfRXPDO", device.rx_pdos.size());
  to.value("NrOfTXPDO", device.tx_pdos.size());
  to.value("DynamicChannelsSupported", 0);
  to.value("LSS_Supported", file.lss ? 1 : 0);
  if (!file.place) return;
  to.section("DeviceComissioning");  // spelled as in CiA 306-1
  to.value("NodeID", file.place->node_id);
  to.value("NodeName", file.place->name);
  if (file.place->bit_rate != 0) to.value("Baudrate", file.place->bit_rate);
}

}  // namespace

std::string write_eds(const EdsFile& file, std::string_view file_name) {
  Writer to;
  to.section("FileInfo");
  to.value("FileName", file_name);
  to.value("FileVersion", 1);
  to.value("FileRevision", 0);
  to.value("EDSVersion", "4.0");
  to.value("Description", file.device.name);
  write_device(to, file);
  ObjectWriter objects(to, file);
  objects.write_list("MandatoryObjects", ObjectList::kMandatory);
  objects.write_list("OptionalObjects", ObjectList::kOptional);
  objects.write_list("ManufacturerObjects", ObjectList::kManufacturer);
  return to.take();
}

std::string write_eds(const DeviceDescription& device, std::string_view file_name) {
  EdsFile file;
  file.device = device;
  return write_eds(file, file_name);
}

}  // namespace driveline::esi
