// What do setpoints cost: how long does planning a time-optimal profile take?
#include <fmt/format.h>
#include <stdexcept>

#include "support/options.hpp"
#include "support/profile_figures.hpp"
#include "support/report.hpp"

namespace {

using namespace driveline::bench;

void measure_all(const Options& options) {
  Report report("trajectory");
  const auto failures = add_profile_figures(report, options);
  report.print(options);
  if (failures > 0) {
    throw std::runtime_error(fmt::format("{} problems without a right profile", failures));
  }
}

}  // namespace

int main(int argc, char** argv) {
  return run(argc, argv, "How long does planning a time-optimal profile take?", measure_all);
}
