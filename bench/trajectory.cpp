// Measures the cost of setpoints: interpolating a path, and planning a time-optimal profile.
#include <fmt/format.h>
#include <stdexcept>

#include "support/interpolation_figures.hpp"
#include "support/options.hpp"
#include "support/profile_figures.hpp"
#include "support/report.hpp"

namespace {

using namespace driveline::bench;

void measure_all(const Options& options) {
  Report report("trajectory");
  add_interpolation_figures(report, options);
  const auto failures = add_profile_figures(report, options);
  report.print(options);
  if (failures > 0) {
    throw std::runtime_error(fmt::format("{} problems without a correct profile", failures));
  }
}

}  // namespace

int main(int argc, char** argv) {
  return run(argc, argv, "What does a setpoint cost, interpolated or planned?", measure_all);
}
