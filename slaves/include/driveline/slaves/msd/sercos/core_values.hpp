#pragma once

#include <cstdint>
#include <span>
#include <string_view>
#include <vector>

#include "driveline/esi/data_type.hpp"
#include "driveline/slaves/idn/idn_row.hpp"
#include "driveline/slaves/msd/core/sercos/weighting.hpp"
#include "driveline/slaves/od/dictionary_table.hpp"

namespace driveline::slaves::msd::sercos {

/// Relation between a number of an IDN and the number of the same value in the drive core.
enum class CoreConversion : std::uint8_t {
  kScaled,        ///< core = IDN * CoreValue::factor
  kSpeedRpm,      ///< SPEED to revolutions per minute of the motor
  kTorque,        ///< TORQUE to per mille of the rated torque
  kRatedCurrent,  ///< A * CoreValue::factor to per mille of the rated current
  kText,          ///< a text
};

/// A value that has an IDN and an object of the drive core: one value with two addresses.
struct CoreValue {
  wire::Idn idn;                                        ///< number of the IDN
  std::uint16_t index = 0;                              ///< address in the object dictionary of the core
  std::uint8_t subindex = 0;                            ///< see index
  std::uint16_t slot = 0;                               ///< slot of that object; of a text it is in the core's table
  esi::DataType type = esi::DataType::kUnsigned32;      ///< type of that object
  CoreConversion conversion = CoreConversion::kScaled;  ///< relation of the numbers
  double factor = 1.0;                                  ///< see CoreConversion
  Polarity polarity = Polarity::kNever;                 ///< the bit that inverts the sign
  bool own_default = false;   ///< the drive starts with the default of the IDN, not with that of the object
  std::string_view source{};  ///< why both are one value; "ours" marks what no source states
};

/// Returns the table of all values of the ServoOne that are in the drive core, in ascending order of the raw numbers.
/// \rtsafe
[[nodiscard]] std::span<const CoreValue> core_values() noexcept;

/// Objects of a drive core with the values of servoone_idns(), for all drives with the same table of objects.
class CoreLinks {
 public:
  /// The object of a row.
  struct Link {
    const EntryRow* entry = nullptr;   ///< null: the value is in IdnValues
    const CoreValue* value = nullptr;  ///< null: both have the same number
  };

  /// An object at the address of the IDN's parameter, 2000h + parameter_number(), holds the same number: a core with
  /// the profile SERCOS has these (ServoOne SERCOS manual, lines 392-400). Otherwise core_values() counts. The table
  /// must outlive this. Throws std::logic_error when it has no object for one of core_values().
  explicit CoreLinks(const DictionaryTable& table);

  /// Returns the table that was passed to the constructor. \rtsafe
  [[nodiscard]] const DictionaryTable& table() const noexcept { return *table_; }
  /// Returns the object of a row of servoone_idns(). The time does not depend on the size of the tables. \rtsafe
  [[nodiscard]] const Link& of(const IdnRow& row) const noexcept {
    return links_[static_cast<std::size_t>(&row - first_)];
  }

 private:
  const DictionaryTable* table_;
  const IdnRow* first_;
  std::vector<Link> links_;
};

}  // namespace driveline::slaves::msd::sercos
