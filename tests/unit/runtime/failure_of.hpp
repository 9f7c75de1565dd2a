#pragma once

#include <string>

#include "driveline/runtime/record/run_report.hpp"

namespace driveline::runtime {

/// For assertions: the sentence of the failure of a run; empty: it succeeded.
[[nodiscard]] inline std::string failure_of(const RunReport& report) {
  const auto* failure = report.failure();
  return failure == nullptr ? std::string() : describe(*failure);
}

}  // namespace driveline::runtime
