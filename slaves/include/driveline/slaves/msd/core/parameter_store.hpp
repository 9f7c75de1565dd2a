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
  /// Takes stored parameters from their file, if there is one. A file that cannot be used leaves the factory settings.
  /// The motor must outlive this.
  ParameterStore(const DictionaryTable& table, const MsdParameters& parameters, const ServoMotor& motor);

  /// Keeps the dictionary's parameters, or makes them factory settings from the next start on when such a reset is
  /// pending. False: they could not be written to their file.
  [[nodiscard]] bool store(const ObjectDictionary& dictionary);
  /// Power-on: initial values, factory settings, stored parameters.
  void restore(ObjectDictionary& dictionary);

  /// The drive has this firmware from the next restore() on. \rtsafe
  void install_firmware(FirmwareVersion version) noexcept { next_firmware_ = version; }
  /// The next store() makes factory settings. \rtsafe
  void request_factory_reset() noexcept { factory_reset_pending_ = true; }
  /// Whether the last access to the file succeeded. \rtsafe
  [[nodiscard]] bool good() const noexcept { return good_; }
  /// Error of the last access. \rtsafe
  [[nodiscard]] const ParameterFileError& error() const noexcept { return error_; }
  /// Properties of the drive, written into the dictionary at power-on. \rtsafe
  [[nodiscard]] const FactoryFacts& facts() const noexcept { return facts_; }
  /// Time of an ordinary self-test. \rtsafe
  [[nodiscard]] std::chrono::nanoseconds start_up_time() const noexcept { return start_up_time_; }
  /// Time of the self-test at this start; longer after a reset to factory settings. \rtsafe
  [[nodiscard]] std::chrono::nanoseconds take_start_up_time() noexcept;
  /// `time` has passed; true when in it the data have been saved. \rtsafe
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
  std::string file_;  ///< empty: there is none
  ParameterFileError error_;
  std::chrono::nanoseconds start_up_time_;
  std::chrono::nanoseconds factory_start_up_time_;
  std::chrono::nanoseconds save_time_;
  std::chrono::nanoseconds save_left_{0};
  bool good_ = true;
  bool factory_reset_pending_ = false;
  bool stored_are_factory_ = false;  ///< the next start takes the time of a reset to factory settings
};

}  // namespace driveline::slaves::msd
