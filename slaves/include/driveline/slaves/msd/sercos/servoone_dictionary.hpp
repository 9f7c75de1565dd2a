#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "driveline/slaves/idn/idn_dictionary.hpp"
#include "driveline/slaves/msd/core/drive_core.hpp"
#include "driveline/slaves/msd/core/sercos/weighting.hpp"
#include "driveline/slaves/msd/sercos/core_values.hpp"

namespace driveline::slaves::msd::sercos {

/// Returns the kind of data that a unit of Table 10.1 names: POS, SPEED, ACC, TORQUE, TEMP; nullopt for other units.
/// \rtsafe
[[nodiscard]] std::optional<WeightedData> weighted_data(std::string_view unit) noexcept;

/// The 479 IDNs of servoone_idns() on drive cores. A value with an object of the core, see CoreLinks, is that object:
/// what one writes, the other reads. Other values are in IdnValues. Units, decimals and signs are those of the
/// weighting in force, which is the default one until take_weighting().
///
/// Belongs to the thread that drives the cores.
class ServoOneDictionary : public IdnDictionary {
 public:
  /// The core of each drive number, at most eight; they must outlive this. Throws std::logic_error when a core has no
  /// object for one of core_values().
  explicit ServoOneDictionary(std::vector<DriveCore*> cores);

  /// Returns the weighting in force. Precondition: has_drive(drive). \rtsafe
  [[nodiscard]] const Weighting& weighting(std::uint8_t drive) const noexcept { return weightings_[drive]; }
  /// Returns the settings of the weighting that the IDNs contain now, in force or not.
  [[nodiscard]] WeightingSettings weighting_settings(std::uint8_t drive) const noexcept;
  /// Returns the motor that the weighting is for.
  [[nodiscard]] WeightedMotor weighted_motor(std::uint8_t drive) const noexcept;
  /// Puts the settings in force; to be called at the change from phase 2 to phase 3 (ServoOne SERCOS manual, Table
  /// 10.1: they are writable in phase 2 alone). Returns false, and changes nothing, when they are not valid().
  [[nodiscard]] bool take_weighting(std::uint8_t drive) noexcept;
  /// Sets the objects of the core whose default is that of their IDN; to be called after a restart of the core that has
  /// found no stored parameters.
  void write_defaults_to_core(std::uint8_t drive);

  /// \name For process data
  /// Of the actual values, only those in the groups of DriveCore::send() are up to date. Precondition:
  /// has_drive(drive), and `row` is a number of servoone_idns().
  /// @{

  /// Returns the value of a number as its bits, as IdnValues::raw() does. \rtsafe
  [[nodiscard]] std::uint64_t raw(std::uint8_t drive, const IdnRow& row) const noexcept;
  /// Sets the value of a number by its bits; a value that the core's object cannot hold is limited to its type. The
  /// core is not told: see DriveCore::outputs_written(). \rtsafe
  void set_raw(std::uint8_t drive, const IdnRow& row, std::uint64_t raw) noexcept;
  /// @}

 protected:
  [[nodiscard]] SoeAnswer<void> check_value(std::uint8_t drive, wire::Idn idn,
                                            std::span<const std::byte> value) override;
  void written(std::uint8_t drive, wire::Idn idn) override;
  [[nodiscard]] std::uint64_t number(std::uint8_t drive, const IdnRow& row) const noexcept override;
  void set_number(std::uint8_t drive, const IdnRow& row, std::uint64_t raw) noexcept override {
    set_raw(drive, row, raw);
  }
  [[nodiscard]] std::span<const std::byte> content(std::uint8_t drive, const IdnRow& row) const noexcept override;
  void set_content(std::uint8_t drive, const IdnRow& row, std::span<const std::byte> content) override;
  [[nodiscard]] wire::SoeAttribute attribute(std::uint8_t drive, const IdnRow& row) const noexcept override;
  [[nodiscard]] std::string unit(std::uint8_t drive, const IdnRow& row) const override;

 private:
  /// Relation between the numbers of an IDN and of its object: factor, and sign.
  [[nodiscard]] double core_per_idn(std::uint8_t drive, const CoreValue* value) const noexcept;
  [[nodiscard]] std::string user_unit(std::uint8_t drive, WeightedData data) const;

  std::vector<DriveCore*> cores_;
  std::vector<std::shared_ptr<const CoreLinks>> links_;  ///< by drive; drives with the same table share theirs
  std::vector<Weighting> weightings_;
};

}  // namespace driveline::slaves::msd::sercos
