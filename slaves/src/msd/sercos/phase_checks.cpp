#include "driveline/slaves/msd/sercos/phase_checks.hpp"

#include <algorithm>
#include <array>

#include "driveline/bytes/endian.hpp"
#include "driveline/slaves/msd/sercos/servoone_idns.hpp"
#include "idn_table_row.hpp"

namespace driveline::slaves::msd::sercos {
namespace {

constexpr std::uint32_t kCycleStepUs = 125;
constexpr unsigned kByLists = 7;  ///< bits 2-0 of S-0-0015
constexpr unsigned kTelegramType = 7;
constexpr unsigned kModeCode = 0x03FF;  ///< SERCOS manual 820-857
constexpr std::uint16_t kExternalSpline = 2;

const IdnRow& row_at(std::uint16_t idn) noexcept {
  return *servoone_idns().find({idn});
}

std::uint32_t number_at(const CheckedDrive& d, std::uint16_t idn) noexcept {
  return static_cast<std::uint32_t>(d.idns.raw(d.drive, row_at(idn)));
}

/// A list of 2-byte elements.
class Words {
 public:
  explicit Words(std::span<const std::byte> bytes) noexcept : bytes_(bytes) {}
  Words(const CheckedDrive& d, std::uint16_t idn) noexcept
      : Words(d.idns.values(d.drive).get(Slot<IdnList>{row_at(idn).slot})) {}
  [[nodiscard]] std::size_t size() const noexcept { return bytes_.size() / 2; }
  [[nodiscard]] std::uint16_t operator[](std::size_t i) const noexcept {
    return bytes::load_le<std::uint16_t>(bytes_.subspan(2 * i));
  }
  [[nodiscard]] std::size_t count(std::uint16_t word) const noexcept {
    std::size_t found = 0;
    for (std::size_t i = 0; i < size(); ++i) found += (*this)[i] == word ? 1U : 0U;
    return found;
  }

 private:
  std::span<const std::byte> bytes_;
};

/// What the drive makes of a mode word.
struct PositionMode {
  std::uint16_t encoder;  ///< 1 or 2; 0: no position mode
  bool by_drive;          ///< the profile is made by the drive
};

/// SERCOS manual 863-878.
PositionMode position_mode(unsigned word) noexcept {
  switch (word & kModeCode) {
    case 0x03:
    case 0x0B:
      return {1, false};
    case 0x04:
    case 0x0C:
      return {2, false};
    case 0x13:
    case 0x1B:
      return {1, true};
    case 0x14:
    case 0x1C:
      return {2, true};
    default:
      return {0, false};
  }
}

template <std::uint16_t kMode>
bool other_encoder(const CheckedDrive& d) {
  const auto mode = position_mode(number_at(d, kMode));
  if (mode.encoder == 0) return false;
  return number_at(d, p_raw(mode.encoder == 1 ? 530 : 531)) != number_at(d, p_raw(522));
}

/// Whether a position mode that fulfils this is selected in S-0-0032 to S-0-0035.
template <typename Predicate>
bool any_position_mode(const CheckedDrive& d, Predicate predicate) noexcept {
  for (std::uint16_t idn = 32; idn <= 35; ++idn) {
    const auto mode = position_mode(number_at(d, idn));
    if (mode.encoder != 0 && predicate(mode)) return true;
  }
  return false;
}

bool no_interpolation(const CheckedDrive& d) {
  const auto type = number_at(d, p_raw(370));
  return (type < 1 || type > 4) && any_position_mode(d, [](const PositionMode&) { return true; });
}

bool by_lists(const CheckedDrive& d) noexcept {
  return (number_at(d, 15) & kTelegramType) == kByLists;
}

bool external_without_signals(const CheckedDrive& d) {
  if (number_at(d, p_raw(370)) != kExternalSpline) return false;
  const Words mdt(d, 24);
  const bool sent = by_lists(d) && mdt.count(p_raw(3055)) != 0 && mdt.count(p_raw(3056)) != 0;
  return !sent && any_position_mode(d, [](const PositionMode& mode) { return !mode.by_drive; });
}

bool external_with_drive_profile(const CheckedDrive& d) {
  return number_at(d, p_raw(370)) == kExternalSpline &&
         any_position_mode(d, [](const PositionMode& mode) { return mode.by_drive; });
}

template <std::uint16_t kList, std::uint8_t kUse>
bool carries_what_it_may_not(const CheckedDrive& d) {
  const Words list(d, kList);
  for (std::size_t i = 0; by_lists(d) && i < list.size(); ++i) {
    const auto* row = servoone_idns().find({list[i]});
    if (row == nullptr || (row->uses & kUse) == 0) return true;
  }
  return false;
}

template <std::uint16_t kList, std::uint16_t kLength>
bool too_long(const CheckedDrive& d) {
  const Words list(d, kList);
  std::size_t bytes = 0;
  for (std::size_t i = 0; i < list.size(); ++i) {
    if (const auto* row = servoone_idns().find({list[i]})) bytes += row->attribute.element_size();
  }
  return by_lists(d) && bytes > number_at(d, kLength);
}

bool carries_one_twice(const CheckedDrive& d) {
  const Words mdt(d, 24);
  for (std::size_t i = 0; by_lists(d) && i < mdt.size(); ++i) {
    if (mdt.count(mdt[i]) > 1) return true;
  }
  return false;
}

/// kAllowed is the list of the data with bits.
template <std::uint16_t kList, std::uint16_t kAllowed>
bool signal_without_bits(const CheckedDrive& d) {
  const Words list(d, kList);
  const Words allowed(d, kAllowed);
  for (std::size_t i = 0; i < list.size(); ++i) {
    if (allowed.count(list[i]) == 0) return true;
  }
  return false;
}

template <std::uint16_t kList, std::uint16_t kBits>
bool lists_of_different_length(const CheckedDrive& d) {
  return Words(d, kList).size() != Words(d, kBits).size();
}

template <std::uint16_t kList, std::uint16_t kBits>
bool bit_beyond_datum(const CheckedDrive& d) {
  const Words list(d, kList);
  const Words bits(d, kBits);
  for (std::size_t i = 0; i < std::min(list.size(), bits.size()); ++i) {
    const auto* row = servoone_idns().find({list[i]});
    if (row != nullptr && bits[i] >= 8 * row->attribute.element_size()) return true;
  }
  return false;
}

bool no_common_step(const CheckedDrive& d) {
  const auto bus = number_at(d, 2);
  return bus == 0 || number_at(d, 1) % bus != 0;
}

template <std::uint16_t kIdn>
bool no_step(const CheckedDrive& d) {
  return number_at(d, kIdn) % kCycleStepUs != 0;
}

bool not_exact(const CheckedDrive& d) {
  return !exact(d.idns.weighting_settings(d.drive), d.idns.weighted_motor(d.drive));
}

constexpr std::string_view kEncoder = "its encoder (P 530, P 531) is not that of position control (P 522)";
constexpr std::string_view kEncoderSource = "manual 882-884";
constexpr std::string_view kInterpolation = "it is no interpolation for the position modes";
constexpr std::string_view kNotCarried = "the telegram may not carry one of these data";
constexpr std::string_view kLong = "the data are longer than the telegram";
constexpr std::string_view kOnlyBits = "one of these data has no bits for signals";
constexpr std::string_view kLength = "it has another length than the list of its data";
constexpr std::string_view kBeyond = "a bit is beyond its datum";
constexpr std::string_view kStep = "it is no multiple of 125 us";

constexpr std::array kChecks = {
    PhaseCheck{3, {1}, kStep, no_step<1>, "manual 177, 187"},
    PhaseCheck{3, {1}, "it is no multiple of S-0-0002", no_common_step, "ours"},
    PhaseCheck{3, {2}, kStep, no_step<2>, "manual 177, 187"},
    PhaseCheck{3, {16}, kNotCarried, carries_what_it_may_not<16, kAt>, "manual 191-194, 1675"},
    PhaseCheck{3, {16}, kLong, too_long<16, 185>, "manual 192"},
    PhaseCheck{3, {24}, kNotCarried, carries_what_it_may_not<24, kMdt>, "manual 191-194, 1676"},
    PhaseCheck{3, {24}, kLong, too_long<24, 186>, "manual 191"},
    PhaseCheck{3, {24}, "it has a datum twice", carries_one_twice, "ours"},
    PhaseCheck{3, {26}, kOnlyBits, signal_without_bits<26, p_raw(3002)>, "manual 735, 744"},
    PhaseCheck{3, {328}, kLength, lists_of_different_length<26, 328>, "manual 735; ours"},
    PhaseCheck{3, {328}, kBeyond, bit_beyond_datum<26, 328>, "manual 735; ours"},
    PhaseCheck{3, {27}, kOnlyBits, signal_without_bits<27, p_raw(3003)>, "manual 722, 673-678"},
    PhaseCheck{3, {329}, kLength, lists_of_different_length<27, 329>, "manual 722; ours"},
    PhaseCheck{3, {329}, kBeyond, bit_beyond_datum<27, 329>, "manual 722; ours"},
    PhaseCheck{3, {32}, kEncoder, other_encoder<32>, kEncoderSource},
    PhaseCheck{3, {33}, kEncoder, other_encoder<33>, kEncoderSource},
    PhaseCheck{3, {34}, kEncoder, other_encoder<34>, kEncoderSource},
    PhaseCheck{3, {35}, kEncoder, other_encoder<35>, kEncoderSource},
    PhaseCheck{3, {p_raw(370)}, kInterpolation, no_interpolation, "manual 888"},
    PhaseCheck{3, {p_raw(370)}, "it needs P 3055 and P 3056 in the telegram", external_without_signals, "manual 893"},
    PhaseCheck{3, {p_raw(370)}, "it is not for profiles of the drive", external_with_drive_profile, "manual 1034"},
    PhaseCheck{3, {121}, "with this gear, positions cannot be converted exactly", not_exact, "ours"},
    // What phase 3 still can change.
    PhaseCheck{4, {32}, kEncoder, other_encoder<32>, kEncoderSource},
    PhaseCheck{4, {33}, kEncoder, other_encoder<33>, kEncoderSource},
    PhaseCheck{4, {34}, kEncoder, other_encoder<34>, kEncoderSource},
    PhaseCheck{4, {35}, kEncoder, other_encoder<35>, kEncoderSource},
    PhaseCheck{4, {p_raw(370)}, kInterpolation, no_interpolation, "manual 888"},
    PhaseCheck{4, {p_raw(370)}, "it needs P 3055 and P 3056 in the telegram", external_without_signals, "manual 893"},
    PhaseCheck{4, {p_raw(370)}, "it is not for profiles of the drive", external_with_drive_profile, "manual 1034"},
};

void make_ascending(std::vector<std::uint16_t>& idns) {
  std::sort(idns.begin(), idns.end());
  idns.erase(std::unique(idns.begin(), idns.end()), idns.end());
}

void set_list(ServoOneDictionary& idns, std::uint8_t drive, std::uint16_t idn,
              const std::vector<std::uint16_t>& content) {
  std::vector<std::byte> bytes;
  for (const auto each : content) {
    const auto word = bytes::to_le_bytes(each);
    bytes.insert(bytes.end(), word.begin(), word.end());
  }
  idns.values(drive).set(Slot<IdnList>{row_at(idn).slot}, bytes);
}

}  // namespace

std::span<const PhaseCheck> phase_checks() noexcept {
  return kChecks;
}

std::vector<std::uint16_t> checked_idns(std::uint8_t phase) {
  std::vector<std::uint16_t> idns;
  for (const auto& check : kChecks) {
    if (check.phase == phase) idns.push_back(check.idn.raw);
  }
  if (phase == 3) {
    for (const auto& rule : weighting_rules()) idns.push_back(rule.idn);
  }
  make_ascending(idns);
  return idns;
}

std::vector<InvalidDatum> find_invalid(const CheckedDrive& drive, std::uint8_t phase) {
  std::vector<InvalidDatum> invalid;
  for (const auto& check : kChecks) {
    if (check.phase == phase && check.broken(drive)) invalid.push_back({check.idn, check.reason});
  }
  if (phase != 3) return invalid;
  const auto settings = drive.idns.weighting_settings(drive.drive);
  for (const auto& rule : weighting_rules()) {
    if (rule.broken(settings)) invalid.push_back({{rule.idn}, rule.reason});
  }
  return invalid;
}

bool check_phase(ServoOneDictionary& idns, std::uint8_t drive, std::uint8_t phase) {
  std::vector<std::uint16_t> numbers;
  for (const auto& datum : find_invalid({idns, drive}, phase)) numbers.push_back(datum.idn.raw);
  make_ascending(numbers);
  set_list(idns, drive, phase == 3 ? 21 : 22, numbers);
  return numbers.empty();
}

void fill_checked_lists(ServoOneDictionary& idns, std::uint8_t drive) {
  set_list(idns, drive, 18, checked_idns(3));
  set_list(idns, drive, 19, checked_idns(4));
}

}  // namespace driveline::slaves::msd::sercos
