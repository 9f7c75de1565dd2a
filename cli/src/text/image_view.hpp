#pragma once

#include <nlohmann/json.hpp>
#include <string>

#include "driveline/runtime/record/image_view.hpp"
#include "driveline/runtime/setup/process_data_plan.hpp"

namespace driveline::cli {

/// A line about layout and wire time, and a line per group.
[[nodiscard]] std::string to_text(const runtime::ImageView& view);
[[nodiscard]] nlohmann::json to_json(const runtime::ImageView& view);

/// The complete image of a configured line: slaves with their logical addresses, entries with their names, groups,
/// datagrams with their working counters, copies, wire time.
[[nodiscard]] std::string image_text(const runtime::LineConfig& config, const ecat_master::Master& master,
                                     const runtime::NamedProcessData& named);
[[nodiscard]] nlohmann::json image_json(const runtime::LineConfig& config, const ecat_master::Master& master,
                                        const runtime::NamedProcessData& named);

}  // namespace driveline::cli
