#include <fmt/format.h>

#include <algorithm>
#include <map>

#include "data_type_name.hpp"
#include "esi_dictionary.hpp"
#include "xml_writer.hpp"

namespace driveline::esi {
namespace {

constexpr std::uint32_t kFirstElementBit = 16;  ///< sub-index 0 has 8 bits, followed by 8 unused bits

/// Form of an object in the file: a variable, an array type (elements all alike), or a structure of sub-indices.
enum class Shape { kVariable, kArray, kRecord };

/// Whether two elements may belong to the same array: they may differ only in name, values and bit offset.
bool alike(const ObjectEntry& a, const ObjectEntry& b) {
  return a.type == b.type && a.bit_length == b.bit_length && a.readable == b.readable && a.writable == b.writable &&
         a.rx_mappable == b.rx_mappable && a.tx_mappable == b.tx_mappable;
}

Shape shape_of(const Object& object) {
  const auto& entries = object.entries;
  if (object.code == ObjectCode::kVariable && entries.size() == 1 && entries[0].subindex == 0) return Shape::kVariable;
  if (object.code != ObjectCode::kArray || entries.size() < 2) return Shape::kRecord;
  for (std::size_t i = 0; i < entries.size(); ++i) {
    const bool placed = entries[i].bit_offset.has_value();
    if (entries[i].subindex != i || placed || (i > 1 && !alike(entries[i], entries[1]))) return Shape::kRecord;
  }
  return Shape::kArray;
}

std::string type_name(const Object& object) {
  return fmt::format("DT{:04X}", object.index);
}
std::string array_type_name(const Object& object) {
  return type_name(object) + "ARR";
}

std::uint32_t total_bits(const Object& object, Shape shape) {
  if (shape == Shape::kVariable) return object.entries[0].bit_length;
  std::uint32_t bits = 0;
  for (const auto& entry : object.entries) {
    bits = entry.subindex == 0 ? kFirstElementBit : entry.bit_offset.value_or(bits) + entry.bit_length;
  }
  return bits;
}

void append_number(pugi::xml_node parent, const char* name, std::uint32_t value) {
  append_text(parent, name, std::to_string(value));
}

void append_flags(pugi::xml_node parent, const ObjectEntry& entry) {
  auto flags = parent.append_child("Flags");
  append_text(flags, "Access", !entry.writable ? "ro" : entry.readable ? "rw" : "wo");
  const std::string mapping = std::string(entry.rx_mappable ? "R" : "") + (entry.tx_mappable ? "T" : "");
  if (!mapping.empty()) append_text(flags, "PdoMapping", mapping);
}

void append_values(pugi::xml_node parent, const ObjectEntry& entry) {
  if (entry.default_hex.empty() && entry.minimum_hex.empty() && entry.maximum_hex.empty()) return;
  auto info = parent.append_child("Info");
  if (!entry.minimum_hex.empty()) append_text(info, "MinData", entry.minimum_hex);
  if (!entry.maximum_hex.empty()) append_text(info, "MaxData", entry.maximum_hex);
  if (!entry.default_hex.empty()) append_text(info, "DefaultData", entry.default_hex);
}

void append_sub_item(pugi::xml_node type, const ObjectEntry& entry, std::uint32_t bit_offset) {
  auto item = type.append_child("SubItem");
  append_number(item, "SubIdx", entry.subindex);
  append_text(item, "Name", entry.name);
  append_text(item, "Type", data_type_name(entry.type, entry.bit_length));
  append_number(item, "BitSize", entry.bit_length);
  append_number(item, "BitOffs", bit_offset);
  append_flags(item, entry);
}

void append_array_type(pugi::xml_node types, const Object& object) {
  const auto& element = object.entries[1];
  const auto count = static_cast<std::uint32_t>(object.entries.size() - 1);
  auto type = types.append_child("DataType");
  append_text(type, "Name", array_type_name(object));
  append_text(type, "BaseType", data_type_name(element.type, element.bit_length));
  append_number(type, "BitSize", count * element.bit_length);
  auto info = type.append_child("ArrayInfo");
  append_number(info, "LBound", 1);
  append_number(info, "Elements", count);
}

void append_elements_item(pugi::xml_node type, const Object& object) {
  const auto& element = object.entries[1];
  auto item = type.append_child("SubItem");
  append_text(item, "Name", "Elements");
  append_text(item, "Type", array_type_name(object));
  append_number(item, "BitSize", static_cast<std::uint32_t>(object.entries.size() - 1) * element.bit_length);
  append_number(item, "BitOffs", kFirstElementBit);
  append_flags(item, element);
}

void append_own_type(pugi::xml_node types, const Object& object, Shape shape) {
  if (shape == Shape::kArray) append_array_type(types, object);
  auto type = types.append_child("DataType");
  append_text(type, "Name", type_name(object));
  append_number(type, "BitSize", total_bits(object, shape));
  if (shape == Shape::kArray) {
    append_sub_item(type, object.entries[0], 0);
    append_elements_item(type, object);
    return;
  }
  std::uint32_t offset = 0;
  for (const auto& entry : object.entries) {
    if (entry.subindex != 0) offset = entry.bit_offset.value_or(std::max(offset, kFirstElementBit));
    append_sub_item(type, entry, offset);
    offset = entry.subindex == 0 ? kFirstElementBit : offset + entry.bit_length;
  }
}

void append_data_types(pugi::xml_node dictionary, const std::vector<Object>& objects) {
  std::map<std::string, std::uint32_t> base_types;
  for (const auto& object : objects) {
    for (const auto& entry : object.entries) {
      base_types.emplace(data_type_name(entry.type, entry.bit_length), entry.bit_length);
    }
  }
  auto types = dictionary.append_child("DataTypes");
  for (const auto& [name, bits] : base_types) {
    auto type = types.append_child("DataType");
    append_text(type, "Name", name);
    append_number(type, "BitSize", bits);
  }
  for (const auto& object : objects) {
    if (const Shape shape = shape_of(object); shape != Shape::kVariable) append_own_type(types, object, shape);
  }
}

void append_object(pugi::xml_node parent, const Object& object) {
  const Shape shape = shape_of(object);
  auto node = parent.append_child("Object");
  append_text(node, "Index", hex_number(object.index, 4));
  append_name(node, object.name);
  const bool variable = shape == Shape::kVariable;
  append_text(node, "Type",
              variable ? data_type_name(object.entries[0].type, object.entries[0].bit_length) : type_name(object));
  append_number(node, "BitSize", total_bits(object, shape));
  if (variable) {
    append_values(node, object.entries[0]);
    append_flags(node, object.entries[0]);
    return;
  }
  auto info = node.append_child("Info");
  for (const auto& entry : object.entries) {
    auto item = info.append_child("SubItem");
    append_text(item, "Name", entry.name);
    append_values(item, entry);
  }
}

}  // namespace

void write_dictionary(pugi::xml_node profile, const std::vector<Object>& objects) {
  auto dictionary = profile.append_child("Dictionary");
  append_data_types(dictionary, objects);
  auto list = dictionary.append_child("Objects");
  for (const auto& object : objects) append_object(list, object);
}

}  // namespace driveline::esi
