#include "driveline/esi/soe_start_list.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <optional>
#include <pugixml.hpp>

#include "text.hpp"

namespace driveline::esi {
namespace {

constexpr unsigned kWriteRequest = 3;  // ETG.1000.6 5.9
constexpr unsigned kValueElement = 64;
constexpr unsigned kLastDrive = 7;
/// IEC 61800-7-204: S-0-0267, password.
constexpr std::uint16_t kPassword = 267;

/// Parses a number, decimal or hexadecimal with 0x or #x.
std::optional<unsigned> number_in(std::string_view text, unsigned maximum) {
  text = trimmed(text);
  const bool hexadecimal = text.starts_with("0x") || text.starts_with("#x");
  if (hexadecimal) text.remove_prefix(2);
  unsigned number = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number, hexadecimal ? 16 : 10);
  if (error != std::errc{} || end != text.data() + text.size() || number > maximum) return std::nullopt;
  return number;
}

/// Parses hex digits, with or without blanks between the bytes; empty: there are none, or other characters.
std::optional<std::vector<std::byte>> parse_bytes(std::string_view text) {
  std::vector<std::byte> bytes;
  for (text = trimmed(text); !text.empty(); text = trimmed(text.substr(2))) {
    const auto byte = text.size() < 2 ? std::nullopt : number_in("0x" + std::string(text.substr(0, 2)), 0xFF);
    if (!byte) return std::nullopt;
    bytes.push_back(static_cast<std::byte>(*byte));
  }
  return bytes.empty() ? std::nullopt : std::optional(std::move(bytes));
}

/// A number of a child element; `fallback` if there is no such child.
std::optional<unsigned> number_of(pugi::xml_node node, const char* child, unsigned fallback, unsigned maximum) {
  const auto element = node.child(child);
  return element ? number_in(element.text().get(), maximum) : fallback;
}

bool has_transition(pugi::xml_node node, std::string_view transition) {
  const auto transitions = node.children("Transition");
  return std::any_of(transitions.begin(), transitions.end(),
                     [&](pugi::xml_node one) { return trimmed(one.text().get()) == transition; });
}

/// Why a command is left out.
struct LeftOut {
  std::string_view why;
};

/// Returns the command, or the reason why it cannot be taken over.
tl::expected<SoeStartEntry, LeftOut> read_command(pugi::xml_node node) {
  const auto idn = number_of(node, "IDN", 0, 0xFFFF);
  if (!idn) return tl::unexpected(LeftOut{"its IDN is no number from 0 to 65535"});
  const auto drive = number_of(node, "DriveNo", 0, kLastDrive);
  if (!drive) return tl::unexpected(LeftOut{"its drive is no number from 0 to 7"});
  if (number_of(node, "OpCode", kWriteRequest, 7) != kWriteRequest) return tl::unexpected(LeftOut{"it does not write"});
  if (number_of(node, "Elements", kValueElement, 0xFF) != kValueElement)
    return tl::unexpected(LeftOut{"it writes another element than the value"});
  const bool in_pre_op = has_transition(node, "PS");
  if (!in_pre_op && !has_transition(node, "SO"))
    return tl::unexpected(LeftOut{"it is for none of the transitions PS and SO"});
  const auto number = static_cast<std::uint16_t>(*idn);
  if (number == kPassword) return tl::unexpected(LeftOut{"it is a password"});
  const auto data = parse_bytes(node.child("Data").text().get());
  if (!data) return tl::unexpected(LeftOut{"it has no data in hex digits"});
  return SoeStartEntry{static_cast<std::uint8_t>(*drive), number, !in_pre_op, *data,
                       std::string(trimmed(node.child("Comment").text().get()))};
}

/// The commands of a file, in their order.
class Commands final : public pugi::xml_tree_walker {
 public:
  explicit Commands(std::string_view text) : text_(text) {}
  bool for_each(pugi::xml_node& node) override {
    if (std::string_view(node.name()) != "InitCmd" || !node.child("IDN")) return true;
    auto entry = read_command(node);
    if (entry) {
      list.entries.push_back(std::move(*entry));
    } else {
      list.left_out.push_back({line_of(node), what(node), std::string(entry.error().why)});
    }
    return true;
  }

  SoeStartList list;

 private:
  [[nodiscard]] std::size_t line_of(pugi::xml_node node) const {
    const auto offset = std::min(static_cast<std::size_t>(node.offset_debug()), text_.size());
    return 1 + static_cast<std::size_t>(
                   std::count(text_.begin(), text_.begin() + static_cast<std::ptrdiff_t>(offset), '\n'));
  }
  static std::string what(pugi::xml_node node) {
    const auto comment = trimmed(node.child("Comment").text().get());
    return fmt::format("IDN {}{}", trimmed(node.child("IDN").text().get()),
                       comment.empty() ? std::string{} : fmt::format(" ({})", comment));
  }

  std::string_view text_;
};

}  // namespace

std::string describe(const NoSoeStartList& error) {
  if (error.xml) return "has no <InitCmd> with an <IDN>: the XML export of the SoE start-up list is expected";
  return fmt::format("is no XML at byte {}: {}", error.offset, error.problem);
}

tl::expected<SoeStartList, NoSoeStartList> read_soe_start_list(std::string_view text) {
  pugi::xml_document document;
  // An export may be a sequence of commands without a root.
  const auto parsed = document.load_buffer(text.data(), text.size(), pugi::parse_default | pugi::parse_fragment);
  if (!parsed) {
    return tl::unexpected(NoSoeStartList{false, static_cast<std::size_t>(parsed.offset), parsed.description()});
  }
  Commands commands(text);
  document.traverse(commands);
  if (commands.list.entries.empty() && commands.list.left_out.empty())
    return tl::unexpected(NoSoeStartList{.xml = true});
  return std::move(commands.list);
}

}  // namespace driveline::esi
