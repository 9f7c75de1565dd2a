#include "driveline/slaves/msd/sercos/servoone_dictionary.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <string>
#include <type_traits>
#include <utility>

#include "driveline/slaves/msd/core/drive_values.hpp"
#include "driveline/slaves/msd/sercos/phase_checks.hpp"
#include "driveline/slaves/msd/sercos/servoone_idns.hpp"

namespace driveline::slaves::msd::sercos {
namespace {

using wire::SdoAbort;
using wire::SoeError;

/// Texts of the units without weighting, in the order of WeightedData (SERCOS manual 1851-1859).
constexpr std::array<std::uint16_t, 3> kUserUnits = {0x8000 + 284, 0x8000 + 287, 0x8000 + 290};

const IdnRow& row_of(wire::Idn idn) noexcept {
  return *servoone_idns().find(idn);
}

constexpr double kInfinity = std::numeric_limits<double>::infinity();

/// Range of a type; of a REAL none.
struct Limits {
  double low;
  double high;
};
Limits limits(esi::DataType type) noexcept {
  if (type == esi::DataType::kReal32) return {-kInfinity, kInfinity};
  const double numbers = std::exp2(static_cast<double>(8 * byte_size(type)));
  return is_signed(type) ? Limits{-numbers / 2, numbers / 2 - 1} : Limits{0.0, numbers - 1};
}
Limits limits(const wire::SoeAttribute& attribute) noexcept {
  if (attribute.display == wire::SoeDisplay::kFloat) return {-kInfinity, kInfinity};
  const double numbers = std::exp2(static_cast<double>(8 * attribute.element_size()));
  return attribute.display == wire::SoeDisplay::kSigned ? Limits{-numbers / 2, numbers / 2 - 1}
                                                        : Limits{0.0, numbers - 1};
}

/// The nearest number of the type.
double fitted(double number, Limits range) noexcept {
  return std::isinf(range.high) ? number : std::clamp(std::nearbyint(number), range.low, range.high);
}

SoeError error_of(SdoAbort abort) noexcept {
  switch (abort) {
    case SdoAbort::kValueTooHigh:
      return SoeError::kValueTooLarge;
    case SdoAbort::kValueTooLow:
      return SoeError::kValueTooSmall;
    case SdoAbort::kDeviceState:
      return SoeError::kValueProtected;
    case SdoAbort::kParameterIncompatible:
      return SoeError::kOtherSettings;
    default:
      return SoeError::kValueInvalid;
  }
}

std::vector<const IdnTable*> tables(const std::vector<DriveCore*>& cores) {
  return std::vector<const IdnTable*>(cores.size(), &servoone_idns());
}

const DictionaryTable& table_of(const DriveCore& core) noexcept {
  return core.process_values().table();
}

}  // namespace

std::optional<WeightedData> weighted_data(std::string_view unit) noexcept {
  if (unit == "POS") return WeightedData::kPosition;
  if (unit == "SPEED") return WeightedData::kSpeed;
  if (unit == "ACC") return WeightedData::kAcceleration;
  if (unit == "TORQUE") return WeightedData::kTorque;
  if (unit == "TEMP") return WeightedData::kTemperature;
  return std::nullopt;
}

ServoOneDictionary::ServoOneDictionary(std::vector<DriveCore*> cores)
    : IdnDictionary(tables(cores)), cores_(std::move(cores)) {
  for (std::uint8_t drive = 0; has_drive(drive); ++drive) {
    const auto& table = table_of(*cores_[drive]);
    const auto same = std::find_if(links_.begin(), links_.end(), [&](const auto& l) { return &l->table() == &table; });
    links_.push_back(same != links_.end() ? *same : std::make_shared<const CoreLinks>(table));
    weightings_.emplace_back(WeightingSettings{}, weighted_motor(drive));
    fill_checked_lists(*this, drive);
  }
}

WeightingSettings ServoOneDictionary::weighting_settings(std::uint8_t drive) const noexcept {
  WeightingSettings s;
  const auto take = [&](std::uint16_t idn, auto& setting) {
    setting = static_cast<std::remove_reference_t<decltype(setting)>>(raw(drive, row_of({idn})));
  };
  take(76, s.position_type);
  take(77, s.position_factor);
  take(78, s.position_exponent);
  take(79, s.rotary_resolution);
  take(103, s.modulo);
  take(294, s.modulo_divisor);
  take(55, s.position_polarity);
  take(44, s.speed_type);
  take(45, s.speed_factor);
  take(46, s.speed_exponent);
  take(43, s.speed_polarity);
  take(160, s.acceleration_type);
  take(161, s.acceleration_factor);
  take(162, s.acceleration_exponent);
  take(86, s.torque_type);
  take(93, s.torque_factor);
  take(94, s.torque_exponent);
  take(85, s.torque_polarity);
  take(208, s.temperature_type);
  take(121, s.gear_input);
  take(122, s.gear_output);
  take(123, s.feed_um);
  return s;
}

WeightedMotor ServoOneDictionary::weighted_motor(std::uint8_t drive) const noexcept {
  const DriveCore& core = *cores_[drive];
  return {core.motion().motor().parameters().encoder_increments,
          core.process_values().get(kValue.motor_rated_torque_nm)};
}

bool ServoOneDictionary::take_weighting(std::uint8_t drive) noexcept {
  const auto settings = weighting_settings(drive);
  const auto motor = weighted_motor(drive);
  if (!valid(settings, motor)) return false;
  weightings_[drive] = Weighting(settings, motor);
  return true;
}

void ServoOneDictionary::write_defaults_to_core(std::uint8_t drive) {
  for (const auto& value : core_values()) {
    const auto& row = row_of(value.idn);
    const auto& link = links_[drive]->of(row);
    if (!value.own_default || link.value == nullptr) continue;
    set_raw(drive, row, raw_from_number(row.attribute, row.initial));
    cores_[drive]->written(*link.entry);
  }
}

double ServoOneDictionary::core_per_idn(std::uint8_t drive, const CoreValue* value) const noexcept {
  if (value == nullptr) return 1.0;
  const auto& weighting = weightings_[drive];
  const auto& dictionary = std::as_const(*cores_[drive]).process_values();
  const double sign = weighting.inverted(value->polarity) ? -1.0 : 1.0;
  switch (value->conversion) {
    case CoreConversion::kSpeedRpm:
      return sign * weighting.scaling().velocity_rad_s / kRpm;
    case CoreConversion::kTorque:
      return sign * 1e3 * weighting.motor_torque_nm() / double{dictionary.get(kValue.motor_rated_torque_nm)};
    case CoreConversion::kRatedCurrent:
      return sign * 1e3 * value->factor / double{dictionary.get(kValue.motor_rated_current_a)};
    default:
      return sign * value->factor;
  }
}

std::uint64_t ServoOneDictionary::raw(std::uint8_t drive, const IdnRow& row) const noexcept {
  const auto& [entry, value] = links_[drive]->of(row);
  if (entry == nullptr) return values(drive).raw(row);
  const auto core = std::as_const(*cores_[drive]).process_values().raw(*entry);
  const double number = slaves::number_from_raw(entry->type, core) / core_per_idn(drive, value);
  return raw_from_number(row.attribute, fitted(number, limits(row.attribute)));
}

void ServoOneDictionary::set_raw(std::uint8_t drive, const IdnRow& row, std::uint64_t raw) noexcept {
  const auto& [entry, value] = links_[drive]->of(row);
  if (entry == nullptr) return values(drive).set_raw(row, raw);
  const double number = number_from_raw(row.attribute, raw) * core_per_idn(drive, value);
  cores_[drive]->process_values().set_raw(entry->slot,
                                          slaves::raw_from_number(entry->type, fitted(number, limits(entry->type))));
}

SoeAnswer<void> ServoOneDictionary::check_value(std::uint8_t drive, wire::Idn idn, std::span<const std::byte> value) {
  const auto& row = row_of(idn);
  const auto& link = links_[drive]->of(row);
  if (link.entry == nullptr || !is_number(row)) return {};
  const double wanted =
      number_from_raw(row.attribute, raw_from_bytes(row.attribute, value)) * core_per_idn(drive, link.value);
  const auto range = limits(link.entry->type);
  if (std::nearbyint(wanted) > range.high) return tl::unexpected(SoeError::kValueTooLarge);
  if (std::nearbyint(wanted) < range.low) return tl::unexpected(SoeError::kValueTooSmall);
  auto& core = *cores_[drive];
  if (link.entry->power_off_only && core.power_stage_on()) return tl::unexpected(SoeError::kValueProtected);
  const auto raw = slaves::raw_from_number(link.entry->type, fitted(wanted, range));
  const auto accepted = check_range(*link.entry, raw).and_then([&] { return core.accept(*link.entry, raw); });
  if (!accepted) return tl::unexpected(error_of(accepted.error()));
  return {};
}

void ServoOneDictionary::written(std::uint8_t drive, wire::Idn idn) {
  if (const auto* entry = links_[drive]->of(row_of(idn)).entry) cores_[drive]->written(*entry);
}

std::uint64_t ServoOneDictionary::number(std::uint8_t drive, const IdnRow& row) const noexcept {
  cores_[drive]->complete_publication();
  return raw(drive, row);
}

std::span<const std::byte> ServoOneDictionary::content(std::uint8_t drive, const IdnRow& row) const noexcept {
  const auto* entry = links_[drive]->of(row).entry;
  if (entry == nullptr) return IdnDictionary::content(drive, row);
  return std::as_bytes(std::span(std::as_const(*cores_[drive]).process_values().text(entry->slot)));
}

void ServoOneDictionary::set_content(std::uint8_t drive, const IdnRow& row, std::span<const std::byte> content) {
  const auto* entry = links_[drive]->of(row).entry;
  if (entry == nullptr) return IdnDictionary::set_content(drive, row, content);
  auto& text = cores_[drive]->process_values().text(entry->slot);
  text.clear();
  for (const auto byte : content) text.push_back(static_cast<char>(byte));
}

wire::SoeAttribute ServoOneDictionary::attribute(std::uint8_t drive, const IdnRow& row) const noexcept {
  auto attribute = row.attribute;
  const auto data = weighted_data(row.unit);
  const bool decimal =
      attribute.display == wire::SoeDisplay::kSigned || attribute.display == wire::SoeDisplay::kUnsigned;
  if (!data || !decimal) return attribute;
  const auto& unit = weightings_[drive].unit(*data);
  attribute.conversion_factor = unit.conversion_factor;
  attribute.decimals = unit.decimals;
  return attribute;
}

std::string ServoOneDictionary::unit(std::uint8_t drive, const IdnRow& row) const {
  const auto data = weighted_data(row.unit);
  if (!data) return std::string(row.unit);
  auto of_user = user_unit(drive, *data);
  return of_user.empty() ? std::string(weightings_[drive].unit(*data).text.view()) : of_user;
}

/// Text of the user for data without weighting; empty: none.
std::string ServoOneDictionary::user_unit(std::uint8_t drive, WeightedData data) const {
  if (!weightings_[drive].unweighted(data)) return {};
  std::string text;
  for (const auto byte : content(drive, row_of({kUserUnits[static_cast<std::size_t>(data)]}))) {
    text += static_cast<char>(byte);
  }
  return text;
}

}  // namespace driveline::slaves::msd::sercos
