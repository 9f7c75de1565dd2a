#include <algorithm>
#include <map>

#include "data_type_name.hpp"
#include "driveline/bytes/endian.hpp"
#include "driveline/esi/hex.hpp"
#include "esi_dictionary.hpp"

namespace driveline::esi {
namespace {

constexpr std::uint32_t kMaxSubindex = 255;
constexpr std::uint32_t kMaxBits = 0xFFFF;
constexpr std::uint32_t kMaxOffset = 0xFFFFF;  ///< bits; the last offset in an object of 128 KiB
constexpr std::uint32_t kFirstEntryBit = 16;   ///< sub-index 0 has 8 bits, followed by 8 unused bits

/// The type that a type name resolves to.
struct ResolvedType {
  DataType type = DataType::kOctetString;
  pugi::xml_node array;   ///< DataType element of an array of `type`
  pugi::xml_node record;  ///< DataType element of a structure
};

class DictionaryReader {
 public:
  DictionaryReader(XmlContext& context, pugi::xml_node dictionary) : context_(context), dictionary_(dictionary) {
    for (const auto node : dictionary.child("DataTypes").children("DataType")) {
      types_.emplace(XmlContext::child_text(node, "Name"), node);
    }
  }

  std::vector<Object> read() {
    std::map<std::uint16_t, Object> objects;
    for (const auto node : dictionary_.child("Objects").children("Object")) {
      if (!node.child("Index")) {
        context_.fail(node, "an object without Index", "Index, e.g. #x6040");
        continue;
      }
      Object object = read_object(node);
      const std::uint16_t index = object.index;
      if (!objects.emplace(index, std::move(object)).second) {
        context_.note(node, "the object exists twice; the first one is used");
      }
    }
    std::vector<Object> list;
    for (auto& [index, object] : objects) list.push_back(std::move(object));
    return list;
  }

 private:
  ResolvedType resolve(pugi::xml_node user, const std::string& name) {
    if (const auto base = data_type_of(name)) return {*base, {}, {}};
    const auto found = types_.find(name);
    if (found == types_.end()) {
      context_.note(user, fmt::format("the type '{}' is not declared; taken as raw bytes", name));
      return {};
    }
    const auto declaration = found->second;
    if (declaration.child("SubItem")) return {DataType::kOctetString, {}, declaration};
    const auto base = data_type_of(XmlContext::child_text(declaration, "BaseType"));
    if (!base) context_.note(user, fmt::format("the type '{}' has no base type; taken as raw bytes", name));
    ResolvedType type;
    type.type = base.value_or(DataType::kOctetString);
    if (declaration.child("ArrayInfo")) type.array = declaration;
    return type;
  }

  std::uint16_t bit_size(pugi::xml_node node) {
    const auto bits = context_.child_number<std::uint32_t>(node, "BitSize");
    if (bits > kMaxBits) context_.note(node, "a BitSize above 65535 is taken as 65535");
    return static_cast<std::uint16_t>(std::min(bits, kMaxBits));
  }

  Object read_object(pugi::xml_node node) {
    Object object;
    object.index = context_.child_number<std::uint16_t>(node, "Index");
    object.name = context_.localized_text(node, "Name");
    const ResolvedType type = resolve(node, XmlContext::child_text(node, "Type"));
    if (type.record) {
      read_sub_items(node, type.record, object);
    } else if (type.array) {
      object.code = ObjectCode::kArray;
      add_elements(node, type, 0, object);
    } else {
      object.entries.push_back(read_variable(node, object.name, type.type));
    }
    read_infos(node.child("Info"), object);
    return object;
  }

  ObjectEntry read_variable(pugi::xml_node node, const std::string& name, DataType type) {
    ObjectEntry entry;
    entry.name = name;
    entry.type = type;
    entry.bit_length = bit_size(node);
    read_flags(node.child("Flags"), entry);
    return entry;
  }

  void read_sub_items(pugi::xml_node node, pugi::xml_node record, Object& object) {
    object.code = ObjectCode::kRecord;
    std::uint32_t next = 0;
    std::uint32_t behind = kFirstEntryBit;
    for (const auto item : record.children("SubItem")) {
      const ResolvedType type = resolve(item, XmlContext::child_text(item, "Type"));
      if (type.record) {
        context_.note(item, "a structure inside a structure is left out");
        continue;
      }
      const auto flags = item.child("Flags") ? item.child("Flags") : node.child("Flags");
      const auto offset = bit_offset(item, behind);
      if (type.array) {
        object.code = ObjectCode::kArray;
        const auto before = object.entries.size();
        next = add_elements(item, type, next, object, flags);
        place(object, before, offset, behind);
        continue;
      }
      next = context_.child_number<std::uint32_t>(item, "SubIdx", next);
      if (next > kMaxSubindex) {
        context_.fail(item, fmt::format("sub-index {}", next), "a sub-index from 0 to 255");
        return;
      }
      ObjectEntry entry;
      entry.subindex = static_cast<std::uint8_t>(next++);
      entry.name = context_.localized_text(item, "Name");
      entry.type = type.type;
      entry.bit_length = bit_size(item);
      read_flags(flags, entry);
      object.entries.push_back(std::move(entry));
      place(object, object.entries.size() - 1, offset, behind);
    }
  }

  std::uint32_t bit_offset(pugi::xml_node item, std::uint32_t behind) {
    const auto offset = context_.child_number<std::uint32_t>(item, "BitOffs", behind);
    if (offset <= kMaxOffset) return offset;
    context_.note(item, fmt::format("a BitOffs above {} is left out", kMaxOffset));
    return behind;
  }

  /// Places the entries from `first` on one after the other from bit `offset`; the preceding entry ends at `behind`.
  static void place(Object& object, std::size_t first, std::uint32_t offset, std::uint32_t& behind) {
    for (std::size_t i = first; i < object.entries.size(); ++i) {
      ObjectEntry& entry = object.entries[i];
      if (entry.subindex == 0) continue;  // always at bit 0
      if (offset != behind) entry.bit_offset = offset;
      behind = offset + entry.bit_length;
      offset = behind;
    }
  }

  /// Adds the elements of an array type from sub-index `first` (or its LBound, if higher); returns the next sub-index.
  std::uint32_t add_elements(pugi::xml_node user, const ResolvedType& type, std::uint32_t first, Object& object,
                             pugi::xml_node flags = {}) {
    const auto info = type.array.child("ArrayInfo");
    const auto count = context_.child_number<std::uint32_t>(info, "Elements");
    first = std::max(first, context_.child_number<std::uint32_t>(info, "LBound"));
    if (first > kMaxSubindex || count > kMaxSubindex + 1 - first) {
      context_.fail(user, fmt::format("an array of {} elements from {}", count, first), "sub-indices up to 255");
      return first;
    }
    for (std::uint32_t i = 0; i < count; ++i) {
      ObjectEntry entry;
      entry.subindex = static_cast<std::uint8_t>(first + i);
      entry.name = fmt::format("SubIndex {:03}", first + i);
      entry.type = type.type;
      entry.bit_length = static_cast<std::uint16_t>(bit_size(type.array) / count);
      read_flags(flags ? flags : user.child("Flags"), entry);
      object.entries.push_back(std::move(entry));
    }
    return first + count;
  }

  void read_flags(pugi::xml_node flags, ObjectEntry& entry) {
    const auto access = flags.child("Access");
    const std::string text = lower_case(XmlContext::text_of(access));
    if (access && text != "ro" && text != "rw" && text != "wo")
      context_.fail(access, fmt::format("'{}'", text), "ro, rw or wo");
    entry.readable = text != "wo";
    entry.writable = text == "rw" || text == "wo";
    for (const char c : XmlContext::child_text(flags, "PdoMapping")) {
      if (c == 'R' || c == 'r') entry.rx_mappable = true;
      if (c == 'T' || c == 't') entry.tx_mappable = true;
    }
  }

  /// Returns a value as raw bytes in hex: hexBinary data unchanged, a number in the size of the entry, or a text.
  std::string value_hex(pugi::xml_node info, const std::string& kind, std::uint16_t bit_length) {
    const std::string data = kind + "Data";
    if (const auto node = info.child(data.c_str())) {
      // Some vendors write numbers where the schema requires hexBinary.
      if (const auto bytes = parse_hex(node.text().get())) return to_hex(*bytes);
      return number_hex(node, bit_length);
    }
    if (const auto text = info.child((kind + "String").c_str())) return to_hex(as_bytes(XmlContext::text_of(text)));
    const auto node = info.child((kind + "Value").c_str());
    return node ? number_hex(node, bit_length) : std::string{};
  }

  /// Returns a number as the raw bytes of an entry of `bit_length`, in hex; adds a note when the text is not a number.
  std::string number_hex(pugi::xml_node node, std::uint16_t bit_length) {
    const std::string text = XmlContext::text_of(node);
    const auto number = parse_number<std::uint64_t>(text);
    const auto negative = parse_number<std::int64_t>(text);
    const std::size_t size = (bit_length + 7U) / 8U;
    if ((!number && !negative) || size > sizeof(std::uint64_t)) {
      context_.note(node, fmt::format("'{}' is not a whole number; ignored", text));
      return {};
    }
    const auto bytes = bytes::to_le_bytes(number ? *number : static_cast<std::uint64_t>(*negative));
    return to_hex(std::span(bytes).first(size));
  }

  static std::vector<std::byte> as_bytes(const std::string& text) {
    std::vector<std::byte> bytes;
    for (const char c : text) bytes.push_back(static_cast<std::byte>(c));
    return bytes;
  }

  void read_values(pugi::xml_node info, ObjectEntry& entry) {
    entry.default_hex = value_hex(info, "Default", entry.bit_length);
    entry.minimum_hex = value_hex(info, "Min", entry.bit_length);
    entry.maximum_hex = value_hex(info, "Max", entry.bit_length);
  }

  /// A variable has its values in its own Info. Other objects have a SubItem for each sub-index, in order; a record may
  /// omit some, so its SubItems are matched by name.
  void read_infos(pugi::xml_node info, Object& object) {
    if (object.code == ObjectCode::kVariable) {
      read_values(info, object.entries.front());
      return;
    }
    auto next = object.entries.begin();
    for (const auto item : info.children("SubItem")) {
      const std::string name = context_.localized_text(item, "Name");
      auto entry = next;
      if (object.code == ObjectCode::kRecord) {
        const auto named =
            std::find_if(next, object.entries.end(), [&](const ObjectEntry& e) { return e.name == name; });
        if (named != object.entries.end()) entry = named;
      }
      if (entry == object.entries.end()) {
        context_.note(item, "values of a sub-index that the type does not have are left out");
        return;
      }
      if (object.code == ObjectCode::kArray && !name.empty()) entry->name = name;
      read_values(item.child("Info"), *entry);
      next = entry + 1;
    }
  }

  XmlContext& context_;
  pugi::xml_node dictionary_;
  std::map<std::string, pugi::xml_node> types_;
};

}  // namespace

std::vector<Object> read_dictionary(XmlContext& context, pugi::xml_node dictionary) {
  return DictionaryReader(context, dictionary).read();
}

}  // namespace driveline::esi
