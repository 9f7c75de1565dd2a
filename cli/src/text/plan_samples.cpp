#include "text/plan_samples.hpp"

#include <fmt/format.h>

namespace driveline::cli {

PlanSamples::PlanSamples(const std::filesystem::path& file, const MoveFile& moves)
    : output_(file), moves_(moves), outputs_(moves.outputs.size(), 0.0) {
  output_.stream() << "time[s]";
  for (const auto& axis : moves_.axes) output_.stream() << fmt::format(",{}[{}]", axis.name, axis.unit->name);
  if (moves_.machine) {
    for (const auto& each : moves_.coordinates) output_.stream() << fmt::format(",{}[{}]", each.name, each.unit->name);
  }
  output_.stream() << fmt::format(",speed[{}/s],line", moves_.coordinates.front().unit->name);
  for (const auto& name : moves_.outputs) output_.stream() << "," << name;
  output_.stream() << "\n";
}

void PlanSamples::take(const trajectory::ContourSetpoint& setpoint) {
  // Enough digits to restore the exact value, because readers differentiate it three times.
  output_.stream() << fmt::format("{}", static_cast<double>(++cycle_) * moves_.settings.period_s);
  for (std::size_t i = 0; i < moves_.axes.size(); ++i) {
    output_.stream() << fmt::format(",{}", moves_.axes[i].unit->from_si(setpoint.position[i]));
  }
  for (std::size_t i = 0; moves_.machine && i < moves_.coordinates.size(); ++i) {
    output_.stream() << fmt::format(",{}", moves_.coordinates[i].unit->from_si(setpoint.tool[i]));
  }
  output_.stream() << fmt::format(",{},{}", moves_.coordinates.front().unit->from_si(setpoint.speed),
                                  moves_.moves[setpoint.move].line);
  for (const auto& [output, value] : setpoint.changed_outputs()) outputs_[output] = value;
  for (const double value : outputs_) output_.stream() << fmt::format(",{}", value);
  output_.stream() << "\n";
}

}  // namespace driveline::cli
