#include "text/plan_samples.hpp"

#include <fmt/format.h>

namespace driveline::cli {

PlanSamples::PlanSamples(const std::filesystem::path& file, const MoveFile& moves) : output_(file), moves_(moves) {
  output_.stream() << "time[s]";
  for (const auto& axis : moves_.axes) output_.stream() << fmt::format(",{}[{}]", axis.name, axis.unit->name);
  output_.stream() << fmt::format(",speed[{}/s],line\n", moves_.axes.front().unit->name);
}

void PlanSamples::take(const trajectory::ContourSetpoint& setpoint) {
  // As many digits as bring the very value back: readers differentiate it three times.
  output_.stream() << fmt::format("{}", static_cast<double>(++cycle_) * moves_.settings.period_s);
  for (std::size_t i = 0; i < moves_.axes.size(); ++i) {
    output_.stream() << fmt::format(",{}", moves_.axes[i].unit->from_si(setpoint.position[i]));
  }
  output_.stream() << fmt::format(",{},{}\n", moves_.axes.front().unit->from_si(setpoint.speed),
                                  moves_.moves[setpoint.move].line);
}

}  // namespace driveline::cli
