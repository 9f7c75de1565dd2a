#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <map>
#include <utility>

#include "driveline/esi/eds_file.hpp"
#include "driveline/esi/hex.hpp"
#include "eds_value.hpp"
#include "ini_file.hpp"
#include "text.hpp"
#include "utf8.hpp"

namespace driveline::esi {
namespace {

constexpr std::array kLists{"mandatoryobjects", "optionalobjects", "manufacturerobjects"};
/// Object codes that EDS have and an object dictionary here has not (CiA 301 Table "Object codes").
constexpr std::uint64_t kNull = 0;
constexpr std::uint64_t kDomain = 2;
constexpr std::uint64_t kDefType = 5;
constexpr std::uint64_t kDefStruct = 6;

/// Parses hex digits of a section's name.
std::optional<unsigned> section_number(std::string_view digits) {
  unsigned number = 0;
  const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), number, 16);
  if (digits.empty() || error != std::errc{} || end != digits.data() + digits.size()) return std::nullopt;
  return number;
}

/// A data type of CiA 301, and what stands for it here.
struct TypeFound {
  DataType type = DataType::kUnsigned8;
  bool replaced = false;  ///< it is an OCTET_STRING here
};

/// None: no type here can hold its values.
std::optional<TypeFound> find_type(std::uint64_t number) {
  constexpr std::array<std::uint64_t, 4> kBytes{0x0B, 0x0C, 0x0D, 0x0F};  // UNICODE_STRING, times, DOMAIN
  if (std::find(kBytes.begin(), kBytes.end(), number) != kBytes.end()) return TypeFound{DataType::kOctetString, true};
  constexpr std::array kKnown{DataType::kBoolean,     DataType::kInteger8,  DataType::kInteger16,
                              DataType::kInteger32,   DataType::kUnsigned8, DataType::kUnsigned16,
                              DataType::kUnsigned32,  DataType::kReal32,    DataType::kVisibleString,
                              DataType::kOctetString, DataType::kReal64,    DataType::kInteger64,
                              DataType::kUnsigned64};
  for (const auto type : kKnown) {
    if (static_cast<std::uint64_t>(type) == number) return TypeFound{type, false};
  }
  return std::nullopt;
}

/// Sorts by `key`; of elements with the same key the last one stays.
template <typename T, typename Key>
void keep_last(std::vector<T>& elements, const Key& key) {
  std::reverse(elements.begin(), elements.end());
  std::stable_sort(elements.begin(), elements.end(), [&](const T& a, const T& b) { return key(a) < key(b); });
  const auto end =
      std::unique(elements.begin(), elements.end(), [&](const T& a, const T& b) { return key(a) == key(b); });
  elements.erase(end, elements.end());
}

class Reader {
 public:
  explicit Reader(const IniFile& ini) : ini_(ini) {
    for (const auto& [name, section] : ini_) sort(name, section);
  }

  [[nodiscard]] bool has_lists() const {
    return std::any_of(kLists.begin(), kLists.end(), [this](const char* list) { return section(list) != nullptr; });
  }

  EdsFile read() {
    read_device();
    read_place();
    for (const auto& [index, line] : listed()) read_object(index, line);
    for (const auto& object : file_.device.objects) add_pdo(object);
    // An entry that replaces a compact one has come a second time.
    auto& formulas = file_.node_id_defaults;
    std::sort(formulas.begin(), formulas.end());
    formulas.erase(std::unique(formulas.begin(), formulas.end()), formulas.end());
    keep_last(file_.values, [](const EdsValue& value) { return value.entry; });
    std::sort(file_.notes.begin(), file_.notes.end(), [](const auto& a, const auto& b) { return a.line < b.line; });
    return std::move(file_);
  }

 private:
  [[nodiscard]] const IniSection* section(std::string_view name) const {
    const auto found = ini_.find(name);
    return found == ini_.end() ? nullptr : &found->second;
  }
  void note(std::size_t line, std::string text) {
    if (file_.notes.size() == kMaxNotes) text = "there are more notes: they are left out";
    if (file_.notes.size() <= kMaxNotes) file_.notes.push_back({line, std::move(text)});
  }

  /// Keeps the sections of objects ("1018") and of their sub-indices ("1018sub1").
  void sort(const std::string& name, const IniSection& section) {
    const auto index = name.size() >= 4 ? section_number(std::string_view(name).substr(0, 4)) : std::nullopt;
    if (!index) return;
    const auto rest = std::string_view(name).substr(4);
    if (rest.empty()) objects_[static_cast<std::uint16_t>(*index)] = &section;
    if (!rest.starts_with("sub")) return;
    const auto subindex = section_number(rest.substr(3));
    if (!subindex || *subindex > 0xFF) return;
    entries_[{static_cast<std::uint16_t>(*index), static_cast<std::uint8_t>(*subindex)}] = &section;
  }

  [[nodiscard]] static std::string text(const IniSection* section, std::string_view key) {
    const auto* value = section == nullptr ? nullptr : section->find(key);
    return value == nullptr ? std::string{} : value->text;
  }

  /// The number of a key; `otherwise` if the key is missing or empty, or with a note if it is no number up to `most`.
  std::uint64_t number(const IniSection* section, std::string_view key, std::uint64_t otherwise, std::uint64_t most) {
    const auto* value = section == nullptr ? nullptr : section->find(key);
    if (value == nullptr || value->text.empty()) return otherwise;
    const auto parsed = parse_eds_number(value->text);
    if (parsed && !parsed->negative && !parsed->adds_node_id && parsed->magnitude <= most) return parsed->magnitude;
    note(value->line,
         fmt::format("{} is \"{}\", a number up to {} is expected: it is left out", key, shortened(value->text), most));
    return otherwise;
  }

  void read_device() {
    const auto* info = section("deviceinfo");
    auto& device = file_.device;
    const auto id = [&](std::string_view key) { return static_cast<std::uint32_t>(number(info, key, 0, 0xFFFFFFFF)); };
    device.vendor_name = text(info, "vendorname");
    device.vendor_id = id("vendornumber");
    device.name = text(info, "productname");
    device.product_code = id("productnumber");
    device.revision = id("revisionnumber");
    device.type = text(info, "ordercode");
    if (device.type.empty()) device.type = device.name;
    if (info == nullptr) note(1, "there is no [DeviceInfo]: the identity of the device is not known");
    for (const auto rate : kEdsBitRates) {
      if (number(info, fmt::format("baudrate_{}", rate), 0, 1) == 1) file_.bit_rates.push_back(rate);
    }
    file_.lss = number(info, "lss_supported", 0, 1) == 1;
  }

  void read_place() {
    // CiA 306-1 spells the section with one m.
    const auto* found = section("devicecomissioning");
    if (found == nullptr) found = section("devicecommissioning");
    if (found == nullptr) return;
    const auto node = number(found, "nodeid", 0, 127);
    if (node == 0) {
      note(found->line, "NodeID is missing, 1 to 127 is expected: the place of the device is left out");
      return;
    }
    file_.place = EdsPlace{static_cast<std::uint8_t>(node),
                           static_cast<std::uint16_t>(number(found, "baudrate", 0, 1000)), text(found, "nodename")};
  }

  /// The objects of the lists, and those that have a section only, each with the line that names it.
  std::map<std::uint16_t, std::size_t> listed() {
    std::map<std::uint16_t, std::size_t> found;
    for (const auto* list : kLists) {
      const auto* items = section(list);
      if (items == nullptr) continue;
      for (const auto& [key, value] : items->values) {
        if (key == "supportedobjects" || value.text.empty()) continue;
        const auto index = parse_eds_number(value.text);
        if (index && !index->negative && !index->adds_node_id && index->magnitude <= 0xFFFF) {
          found.emplace(static_cast<std::uint16_t>(index->magnitude), value.line);
        } else {
          note(value.line, fmt::format("\"{}\" is no index of an object: it is left out", shortened(value.text)));
        }
      }
    }
    for (const auto& [index, object] : objects_) {
      if (found.emplace(index, object->line).second)
        note(object->line, fmt::format("{:04X}h is in no list of objects: it is added", index));
    }
    return found;
  }

  void read_object(std::uint16_t index, std::size_t line) {
    const auto found = objects_.find(index);
    if (found == objects_.end()) return note(line, fmt::format("{:04X}h has no section: it is left out", index));
    const auto& keys = *found->second;
    const auto code = number(&keys, "objecttype", static_cast<unsigned>(ObjectCode::kVariable), 0xFF);
    if (code == kNull || code == kDefType || code == kDefStruct) {
      return note(keys.line, fmt::format("{:04X}h has the object type {}: it is left out", index, code));
    }
    Object object{index, text(&keys, "parametername"), ObjectCode::kVariable, {}};
    const auto compact = number(&keys, "compactsubobj", 0, 0xFE);
    const bool has_entries = entries_.lower_bound({index, 0}) != entries_.upper_bound({index, 0xFF});
    if (compact == 0 && !has_entries) {
      add_entry(object, 0, keys, object.name, code == kDomain);
    } else {
      object.code = code == static_cast<unsigned>(ObjectCode::kArray) ? ObjectCode::kArray : ObjectCode::kRecord;
      add_compact(object, keys, static_cast<unsigned>(compact));
      add_entries(object, keys);
    }
    if (!object.entries.empty()) file_.device.objects.push_back(std::move(object));
  }

  /// Adds the entries of CompactSubObj: sub-index 0 with their number, and equal ones (CiA 306-1).
  void add_compact(Object& object, const IniSection& keys, unsigned count) {
    if (count == 0) return;
    ObjectEntry length;
    length.name = "NrOfObjects";
    length.type = DataType::kUnsigned8;
    length.bit_length = 8;
    length.default_hex = fmt::format("{:02X}", count);
    object.entries.push_back(std::move(length));
    const auto* names = section(fmt::format("{:04x}name", object.index));
    const auto* values = section(fmt::format("{:04x}value", object.index));
    for (unsigned n = 1; n <= count; ++n) {
      auto name = text(names, std::to_string(n));
      if (name.empty()) name = fmt::format("{}{}", object.name, n);
      add_entry(object, static_cast<std::uint8_t>(n), keys, std::move(name), false);
      if (values != nullptr) add_compact_value(object, static_cast<std::uint8_t>(n), *values);
    }
  }

  /// Adds the value of the newest entry of an object, if it has this sub-index: a section as [1600Value] lists the
  /// values of compact entries (CiA 306-1).
  void add_compact_value(const Object& object, std::uint8_t subindex, const IniSection& values) {
    if (object.entries.back().subindex != subindex) return;
    bool adds_node_id = false;
    const auto place = fmt::format("{:04X}h:{:02X}", object.index, subindex);
    auto value = value_of(object.entries.back().type, values, std::to_string(subindex), place, adds_node_id);
    if (!value.empty()) file_.values.push_back({{object.index, subindex}, std::move(value), adds_node_id});
  }

  void add_entries(Object& object, const IniSection& keys) {
    const auto before = object.entries.size();
    std::size_t sections = 0;
    for (auto it = entries_.lower_bound({object.index, 0}); it != entries_.upper_bound({object.index, 0xFF}); ++it) {
      add_entry(object, it->first.subindex, *it->second, text(it->second, "parametername"), false);
      ++sections;
    }
    if (before != 0) {
      // A section for an entry replaces the compact one.
      keep_last(object.entries, [](const ObjectEntry& entry) { return entry.subindex; });
      return;
    }
    const auto announced = number(&keys, "subnumber", sections, 0xFFFF);
    if (announced != sections) {
      note(keys.line, fmt::format("{:04X}h announces {} entries and has {}", object.index, announced, sections));
    }
  }

  void add_entry(Object& object, std::uint8_t subindex, const IniSection& keys, std::string name, bool domain) {
    const auto code = number(&keys, "datatype",
                             domain                                                  ? 0x0F
                             : subindex == 0 && object.code != ObjectCode::kVariable ? 5
                                                                                     : 0,
                             0xFFFF);
    const auto type = find_type(code);
    const auto place = fmt::format("{:04X}h:{:02X}", object.index, subindex);
    if (!type) {
      return note(keys.line, fmt::format("{} has the data type 0x{:04X}: it is left out", place, code));
    }
    if (type->replaced) note(keys.line, fmt::format("{} has the data type 0x{:04X}: it is read as bytes", place, code));
    ObjectEntry entry;
    entry.subindex = subindex;
    entry.name = std::move(name);
    entry.type = type->type;
    set_access(entry, keys);
    const EntryAddress address{object.index, subindex};
    bool adds_node_id = false;
    entry.default_hex = value_of(entry.type, keys, "defaultvalue", place, adds_node_id);
    if (adds_node_id) file_.node_id_defaults.push_back(address);
    bool ignored = false;
    entry.minimum_hex = value_of(entry.type, keys, "lowlimit", place, ignored);
    entry.maximum_hex = value_of(entry.type, keys, "highlimit", place, ignored);
    const auto bits = bits_of_number(entry.type);
    entry.bit_length =
        bits != 0 ? bits : static_cast<std::uint16_t>(std::min<std::size_t>(4 * entry.default_hex.size(), 0xFFF8));
    adds_node_id = false;
    auto value = value_of(entry.type, keys, "parametervalue", place, adds_node_id);
    if (!value.empty()) file_.values.push_back({address, std::move(value), adds_node_id});
    object.entries.push_back(std::move(entry));
  }

  void set_access(ObjectEntry& entry, const IniSection& keys) {
    const auto access = lower_case(text(&keys, "accesstype"));
    entry.writable = access.starts_with("rw") || access == "wo";
    entry.readable = access != "wo";
    if (number(&keys, "pdomapping", 0, 1) == 0) return;
    // rwr is an input and rww an output of the process that can also be written by SDO.
    entry.rx_mappable = entry.writable && access != "rwr";
    entry.tx_mappable = entry.readable && access != "rww";
  }

  /// Hex digits of a value; empty: none, or with a note none of this type.
  std::string value_of(DataType type, const IniSection& keys, std::string_view key, const std::string& place,
                       bool& adds_node_id) {
    const auto* value = keys.find(key);
    if (value == nullptr || value->text.empty()) return {};
    const auto hex = hex_of_value(type, value->text, adds_node_id);
    if (hex) return *hex;
    adds_node_id = false;
    note(value->line, fmt::format("{} of {} is \"{}\", which is no value of its type: it is left out", key, place,
                                  shortened(value->text)));
    return {};
  }

  /// Adds the PDO of a mapping object with its default mapping.
  void add_pdo(const Object& object) {
    const bool rx = object.index >= 0x1600 && object.index < 0x1800;
    const bool tx = object.index >= 0x1A00 && object.index < 0x1C00;
    if ((!rx && !tx) || object.entries.empty() || object.entries.front().subindex != 0) return;
    Pdo pdo;
    pdo.index = object.index;
    pdo.name = object.name;
    pdo.fixed = !object.entries.front().writable;
    const auto count = raw_of(object.entries.front());
    for (const auto& entry : object.entries) {
      const auto raw = raw_of(entry);
      if (entry.subindex == 0 || entry.subindex > count || raw == 0) continue;
      pdo.entries.push_back(mapped(raw));
    }
    (rx ? file_.device.rx_pdos : file_.device.tx_pdos).push_back(std::move(pdo));
  }

  [[nodiscard]] static std::uint64_t raw_of(const ObjectEntry& entry) {
    std::uint64_t raw = 0;
    const auto bytes = parse_hex(entry.default_hex).value_or(std::vector<std::byte>{});
    for (std::size_t i = 0; i < std::min<std::size_t>(bytes.size(), 8); ++i) {
      raw |= std::to_integer<std::uint64_t>(bytes[i]) << (8 * i);
    }
    return raw;
  }

  [[nodiscard]] PdoEntry mapped(std::uint64_t raw) const {
    PdoEntry entry;
    entry.index = static_cast<std::uint16_t>(raw >> 16);
    entry.subindex = static_cast<std::uint8_t>(raw >> 8);
    entry.bit_length = static_cast<std::uint8_t>(raw);
    const auto& objects = file_.device.objects;
    const auto object = std::lower_bound(objects.begin(), objects.end(), entry.index,
                                         [](const Object& one, std::uint16_t index) { return one.index < index; });
    if (object == objects.end() || object->index != entry.index) return entry;
    for (const auto& found : object->entries) {
      if (found.subindex != entry.subindex) continue;
      entry.name = found.name;
      entry.type = found.type;
    }
    return entry;
  }

  const IniFile& ini_;
  std::map<std::uint16_t, const IniSection*> objects_;
  std::map<EntryAddress, const IniSection*> entries_;
  EdsFile file_;
};

}  // namespace

std::string describe(const EdsError& error) {
  return fmt::format("{}:{}: {}", error.file, error.line, error.problem);
}

std::string EdsFile::default_hex(EntryAddress entry, std::uint8_t node_id) const {
  const bool adds = std::binary_search(node_id_defaults.begin(), node_id_defaults.end(), entry);
  for (const auto& object : device.objects) {
    if (object.index != entry.index) continue;
    for (const auto& one : object.entries) {
      if (one.subindex == entry.subindex) return adds ? plus(one.default_hex, node_id) : one.default_hex;
    }
  }
  return {};
}

tl::expected<EdsFile, EdsError> read_eds(std::string_view text, std::string_view file_name) {
  const auto ini = read_ini(to_utf8(text));
  if (!ini) {
    return tl::unexpected(EdsError{std::string(file_name), ini.error().line,
                                   fmt::format("\"{}\" is neither [section] nor key=value", ini.error().problem)});
  }
  Reader reader(*ini);
  if (!reader.has_lists()) {
    return tl::unexpected(
        EdsError{std::string(file_name), 1,
                 "there is no list of objects: [MandatoryObjects], [OptionalObjects] or [ManufacturerObjects] is "
                 "expected in an electronic data sheet"});
  }
  return reader.read();
}

}  // namespace driveline::esi
