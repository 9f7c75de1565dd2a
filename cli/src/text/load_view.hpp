#pragma once

#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>
#include <string>
#include <tl/expected.hpp>

#include "driveline/motion/axis/axis.hpp"
#include "driveline/runtime/error.hpp"
#include "driveline/runtime/identify/load_estimate.hpp"
#include "text/gnuplot.hpp"

namespace driveline::cli {

/// The output of `identify`: the figures with their intervals, the quality of the fit, and the keys for the
/// description.
[[nodiscard]] std::string load_text(const runtime::LoadEstimate& load, const motion::AxisConfig& axis);

/// The same as a document; `files` by their key.
[[nodiscard]] nlohmann::json to_json(const runtime::LoadEstimate& load, const motion::AxisConfig& axis,
                                     const std::map<std::string, std::filesystem::path>& files);

/// Writes the samples behind the figures: time, position, velocity, acceleration, torque as measured and by the model.
[[nodiscard]] runtime::Result<void> write_load_csv(const runtime::LoadEstimate& load, const motion::AxisConfig& axis,
                                                   const std::filesystem::path& file);

/// Draws load.png from load.csv in `directory`: torque as measured and by the model, and the difference. Error: a
/// sentence.
[[nodiscard]] tl::expected<Drawing, std::string> draw_load(const std::filesystem::path& directory,
                                                           const motion::AxisConfig& axis);

}  // namespace driveline::cli
