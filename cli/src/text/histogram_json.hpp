#pragma once

#include <nlohmann/json.hpp>

#include "driveline/rt/histogram.hpp"

namespace driveline::cli {

/// Percentiles of a duration for JSON documents, in ns.
[[nodiscard]] inline nlohmann::json percentiles_json(const rt::Histogram& histogram) {
  return {{"p50", histogram.percentile(0.5).count()},
          {"p99", histogram.percentile(0.99).count()},
          {"p999", histogram.percentile(0.999).count()},
          {"max", histogram.max().count()}};
}

}  // namespace driveline::cli
