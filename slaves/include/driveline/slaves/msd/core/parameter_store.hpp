#pragma once

#include <chrono>
#include <optional>
#include <string>
#include <utility>

#include "driveline/slaves/msd/core/factory_settings.hpp"
#include "driveline/slaves/msd/core/msd_parameters.hpp"
#include "driveline/slaves/od/object_dictionary.hpp"
#include "driveline/slaves/od/parameter_file.hpp"

namespace driveline::slaves::msd {

/// Non-volatile data: the stored parameters, their file, factory settings (MSD manual 7.5.3, 7.5.4).
class ParameterStore {
 public:
  /// Loads stored parameters from their file, if it exists. With an unusable file the factory settings remain. The
  /// motor must outlive this.
  ParameterStore(const DictionaryTable& table, const MsdParameters& parameters, const ServoMotor& motor);

  /// Stores the dictionary's parameters, or the factory settings for the next start if such a reset is pending. Returns
  /// false when they could not be written to their file.
  [[nodiscard]] bool store(const ObjectDictionary& dictionary);
  /// Power-on: restores initial values, factory settings and stored parameters.
  void restore(ObjectDictionary& dictionary);

  /// Restores the stored parameters with an index from `first` to `last`.
  void restore(ObjectDictionary& dictionary, std::uint16_t first, std::uint16_t last) const {
    dictionary.copy_backup_values(stored_, first, last);
  }

  /// Installs a firmware version that becomes active at the next restore(). \rtsafe
  void install_firmware(FirmwareVersion version) noexcept { next_firmware_ = version; }
  /// Makes the next store() store the factory settings. \rtsafe
  void request_factory_reset() noexcept { factory_reset_pending_ = true; }
  /// Whether the last access to the file succeeded. \rtsafe
  [[nodiscard]] bool good() const noexcept { return good_; }
  /// Returns the error of the last access. \rtsafe
  [[nodiscard]] const ParameterFileError& error() const noexcept { return error_; }
  /// Returns the properties of the drive, which are written to the dictionary at power-on. \rtsafe
  [[nodiscard]] const FactoryFacts& facts() const noexcept { return facts_; }
  /// Returns the duration of a normal self-test. \rtsafe
  [[nodiscard]] std::chrono::nanoseconds start_up_time() const noexcept { return start_up_time_; }
  /// Returns the duration of the self-test at this start; longer after a reset to factory settings. \rtsafe
  [[nodiscard]] std::chrono::nanoseconds take_start_up_time() noexcept;
  /// Advances by `time`; returns true when saving the data ends within it. \rtsafe
  [[nodiscard]] bool finishes(std::chrono::nanoseconds time) noexcept {
    if (save_left_.count() <= 0) return false;
    save_left_ -= time;
    return save_left_.count() <= 0;
  }

 private:
  void load();

  FactoryFacts facts_;
  std::optional<FirmwareVersion> next_firmware_;
  const ServoMotor* motor_;
  ObjectDictionary stored_;
  std::string file_;  ///< empty: no file
  ParameterFileError error_;
  std::chrono::nanoseconds start_up_time_;
  std::chrono::nanoseconds factory_start_up_time_;
  std::chrono::nanoseconds save_time_;
  bool good_ = true;
  bool factory_reset_pending_ = false;
  bool stored_are_factory_ = false;  ///< the next start takes as long as after a reset to factory settings
  std::chrono::nanoseconds save_left_{0};
};

}  // namespace driveline::slaves::msd
