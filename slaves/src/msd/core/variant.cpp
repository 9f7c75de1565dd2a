#include "driveline/slaves/msd/core/variant.hpp"

#include <algorithm>
#include <charconv>
#include <vector>

#include "driveline/slaves/msd/core/drive_table.hpp"

namespace driveline::slaves::msd {
namespace {

constexpr bool variants_in_order() noexcept {
  for (std::size_t i = 0; i < kVariants.size(); ++i) {
    if (static_cast<std::size_t>(kVariants[i].variant) != i) return false;
  }
  return true;
}
static_assert(variants_in_order(), "facts() uses the variant as index");

/// A difference of the ServoOne's dictionary from the common table.
struct Difference {
  enum class Kind : std::uint8_t { kMissing, kName };
  Kind kind = Kind::kMissing;
  std::uint16_t index = 0;
  std::string_view name;
  std::string_view source;
};

/// Differences of both ServoOne variants; 1008h, 100Ah and 1018h come from kVariants.
constexpr std::array kServoOneDifferences = {
    Difference{Difference::Kind::kMissing, 0x607F, {}, "ServoOne manual Table 12.8: the list ends with 607Eh"},
    Difference{Difference::Kind::kName, 0x605D, "Stop option code", "ServoOne manual Table 10.3; default CiA 402"},
};

/// Sets the initial values of the rows that identify the drive.
void identify(EntryRow& row, const VariantFacts& variant) {
  if (row.index == 0x1008) {
    row.text = variant.device_name;
    row.string_length = static_cast<std::uint16_t>(variant.device_name.size());
  } else if (row.index == 0x100A && variant.variant != Variant::kMsd) {
    row.text = "4.30-00";
    row.string_length = 7;
    row.source = "ServoOne manual 8.3.3: form of versions; number ours";
  } else if (row.index == 0x1018 && row.subindex == 2) {
    row.initial = variant.product_code;
  } else if (row.index == 0x1018 && row.subindex == 3) {
    row.initial = variant.revision;
  }
}

/// "Device-specific parameters can also be mapped to the PDOs" (MSD manual 8.3.2): numbers only, and in RxPDOs only
/// numbers that may be written at any time and are not commands (ours).
void map_device_parameter(EntryRow& row) {
  constexpr std::array kCommands = {std::uint16_t{0x2000 + 11}, std::uint16_t{0x2000 + 153}};
  const bool parameter = row.index >= 0x2000 && row.index < 0x6000;
  const bool command = std::find(kCommands.begin(), kCommands.end(), row.index) != kCommands.end();
  if (!parameter || command || is_string(row.type)) return;
  row.access |= access::kTxMappable;
  if ((row.access & access::kWriteOperating) != 0 && !row.power_off_only) row.access |= access::kRxMappable;
}

/// Takes a decimal number of this many digits from the start of `text`.
std::optional<std::uint8_t> take_number(std::string_view& text, std::size_t min_digits, std::size_t max_digits) {
  std::uint8_t value = 0;
  const auto digits = std::min(text.find_first_not_of("0123456789"), text.size());
  if (digits < min_digits || digits > max_digits) return std::nullopt;
  if (std::from_chars(text.data(), text.data() + digits, value).ec != std::errc{}) return std::nullopt;
  text.remove_prefix(digits);
  return value;
}

bool take(std::string_view& text, char what) {
  if (text.empty() || text.front() != what) return false;
  text.remove_prefix(1);
  return true;
}

std::string two_digits(std::uint8_t value) {
  return {static_cast<char>('0' + value / 10 % 10), static_cast<char>('0' + value % 10)};
}

}  // namespace

std::vector<EntryRow> drive_rows(Variant variant) {
  std::vector<EntryRow> rows;
  for (const auto part :
       {identity_rows(), parameter_rows(), profile_rows(), mode_rows(), terminal_rows(), function_rows()}) {
    rows.insert(rows.end(), part.begin(), part.end());
  }
  for (auto& row : rows) {
    identify(row, facts(variant));
    map_device_parameter(row);
  }
  if (variant == Variant::kMsd) return rows;
  for (const auto& difference : kServoOneDifferences) {
    const auto is_meant = [&](const EntryRow& row) { return row.index == difference.index; };
    if (difference.kind == Difference::Kind::kMissing) {
      rows.erase(std::remove_if(rows.begin(), rows.end(), is_meant), rows.end());
    } else {
      const auto row = std::find_if(rows.begin(), rows.end(), is_meant);
      row->name = difference.name;
      row->source = difference.source;
    }
  }
  return rows;
}

std::optional<Variant> find_variant(std::string_view key) noexcept {
  const auto found = std::find_if(kVariants.begin(), kVariants.end(), [&](const auto& v) { return v.key == key; });
  if (found == kVariants.end()) return std::nullopt;
  return found->variant;
}

std::string FirmwareVersion::text() const {
  return std::to_string(major) + "." + two_digits(minor) + "-" + two_digits(correction);
}

std::optional<FirmwareVersion> FirmwareVersion::parse(std::string_view text) {
  if (text.starts_with('V')) text.remove_prefix(1);
  const auto major = take_number(text, 1, 3);
  if (!major || !take(text, '.')) return std::nullopt;
  const auto minor = take_number(text, 2, 2);
  if (!minor || !take(text, '-')) return std::nullopt;
  const auto correction = take_number(text, 2, 2);
  if (!correction || !text.empty()) return std::nullopt;
  return FirmwareVersion{*major, *minor, *correction};
}

}  // namespace driveline::slaves::msd
