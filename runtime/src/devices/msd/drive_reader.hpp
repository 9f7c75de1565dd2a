#pragma once

#include <filesystem>
#include <span>
#include <variant>

#include "driveline/runtime/toml/toml_reader.hpp"
#include "driveline/slaves/msd/core/msd_parameters.hpp"

namespace driveline::runtime {

/// A number of the machine of a simulated drive: its key in the line description and its place in the model.
struct PlantKey {
  using Place = std::variant<double*, std::uint32_t*>;
  std::string_view table;  ///< "plant", "plant.load"
  std::string_view key;
  std::string_view unit;  ///< unit in the file; empty: none
  double minimum = 0.0;
  double maximum = 0.0;
  double scale = 1.0;  ///< model unit per unit of the file
  Place (*place)(slaves::msd::MsdParameters& parameters) = nullptr;

  [[nodiscard]] bool integer() const noexcept;
  /// Returns the default of the model, in the unit of the file; infinite: no limit.
  [[nodiscard]] double standard() const;
};
[[nodiscard]] std::span<const PlantKey> plant_keys();

/// Reads the keys that only a simulated drive has: firmware, [slave.plant] and its tables, [[slave.switch]],
/// [[slave.input]], parameter_file, start_up_ms, factory_start_up_ms, file_password. Throws ConfigError.
/// @param directory folder of the line description
[[nodiscard]] slaves::msd::MsdParameters read_drive_parameters(TomlReader& slave, slaves::msd::Variant variant,
                                                               const std::filesystem::path& directory);

}  // namespace driveline::runtime
