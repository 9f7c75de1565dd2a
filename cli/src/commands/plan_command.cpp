#include <fmt/format.h>
#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <memory>

#include "commands/commands.hpp"
#include "commands/tool_options.hpp"
#include "console.hpp"
#include "driveline/runtime/files/input_file.hpp"
#include "driveline/runtime/files/output_file.hpp"
#include "driveline/trajectory/contour_follower.hpp"
#include "driveline/trajectory/contour_planner.hpp"
#include "text/json_text.hpp"
#include "text/move_file.hpp"
#include "text/plan_picture.hpp"
#include "text/plan_samples.hpp"
#include "text/planned_motion.hpp"
#include "text/wrapped_text.hpp"

namespace driveline::cli {
namespace {

struct PlanOptions {
  std::string file;
  std::optional<std::string> share;
  std::optional<std::string> picture;
  std::optional<std::string> samples;
  bool json = false;
};

/// Executes the moves as the cycle would, but as fast as this machine can.
Outcome<PlannedMotion> follow(const MoveFile& file, const std::string& name, double share, PlanSamples* samples) {
  trajectory::ContourTrack track(file.settings, file.start);
  trajectory::ContourPlanner planner(track);
  trajectory::ContourFollower follower(track);
  if (!follower.set_override(share)) return misused("--override is a percentage above 0 and up to 200");
  MotionMeter meter(file.settings.period_s);
  const auto longest = static_cast<std::size_t>(4.0 * 3600.0 / file.settings.period_s);
  std::size_t next = 0;
  for (std::size_t cycle = 0; cycle < longest; ++cycle) {
    while (cycle % 64 == 0 && planner.flush() && next <= file.moves.size()) {
      if (next == file.moves.size()) {
        planner.finish();
      } else if (const auto added = planner.add(file.moves[next].move); !added) {
        return misused(fmt::format("{}:{}: {}", name, file.moves[next].line, added.error().reason));
      }
      ++next;
    }
    const auto setpoint = follower.step();
    meter.take(setpoint);
    if (samples != nullptr) samples->take(setpoint);
    if (setpoint.at_end && next > file.moves.size()) return meter.result();
  }
  return failed("the motion takes longer than four hours");
}

double limit_of(const MoveFile& file, std::size_t axis, std::size_t quantity) {
  const auto& limits = file.settings.limits[axis];
  return quantity == 0 ? limits.max_velocity : quantity == 1 ? limits.max_acceleration : limits.max_jerk;
}

constexpr std::array<const char*, 3> kQuantities{"velocity", "acceleration", "jerk"};
constexpr std::array<const char*, 3> kPer{"/s", "/s^2", "/s^3"};

std::array<double, 3> limits_of_tool(const MoveFile& file) {
  const auto& tool = file.settings.tool;
  return {tool.max_velocity, tool.max_acceleration, tool.max_jerk};
}

/// The maxima of the tool, for quantities that have a limit.
std::string tool_text(const MoveFile& file, const PlannedMotion& motion) {
  const auto limits = limits_of_tool(file);
  const auto& unit = *file.coordinates.front().unit;
  std::string figures;
  for (std::size_t k = 0; k < kQuantities.size(); ++k) {
    if (!std::isfinite(limits[k])) continue;
    figures += fmt::format("{}{} {:.6g} {}{} ({:.1f} % of its limit)", figures.empty() ? "" : ", ", kQuantities[k],
                           unit.from_si(motion.largest_of_tool[k]), unit.name, kPer[k],
                           100.0 * motion.largest_of_tool[k] / limits[k]);
  }
  return figures.empty() ? figures : wrapped("tool: ", figures) + "\n";
}

std::string outputs_text(const MoveFile& file, const PlannedMotion& motion) {
  constexpr std::size_t kMaxListedOutputs = 40;
  std::string text;
  for (std::size_t k = 0; k < std::min(motion.outputs.size(), kMaxListedOutputs); ++k) {
    const auto& [time_s, change, move, tool] = motion.outputs[k];
    text += fmt::format("{:.4f} s: {} = {:g}, line {}\n", time_s, file.outputs[change.output], change.value,
                        file.moves[move].line);
  }
  if (motion.outputs.size() > kMaxListedOutputs)
    text += fmt::format("and {} more outputs\n", motion.outputs.size() - kMaxListedOutputs);
  return text;
}

std::string plan_text(const MoveFile& file, const PlannedMotion& motion) {
  const auto& unit = *file.coordinates.front().unit;
  std::string text = fmt::format("{} moves, {:.6g} {} long, {:.4f} s", file.moves.size(), unit.from_si(motion.length),
                                 unit.name, motion.duration_s);
  text += motion.dwell_s > 0.0 ? fmt::format(", of which {:.4f} s of dwells\n", motion.dwell_s) : "\n";
  for (std::size_t i = 0; i < file.axes.size(); ++i) {
    std::string figures;
    for (std::size_t k = 0; k < kQuantities.size(); ++k) {
      const double largest = motion.largest[k][i];
      figures += fmt::format("{}{} {:.6g} {}{} ({:.1f} % of its limit)", k == 0 ? "" : ", ", kQuantities[k],
                             file.axes[i].unit->from_si(largest), file.axes[i].unit->name, kPer[k],
                             100.0 * largest / limit_of(file, i, k));
    }
    text += wrapped(file.axes[i].name + ": ", figures) + "\n";
  }
  return text + tool_text(file, motion) + outputs_text(file, motion);
}

nlohmann::json plan_json(const MoveFile& file, const PlannedMotion& motion) {
  nlohmann::json document{{"moves", file.moves.size()},
                          {"duration_s", motion.duration_s},
                          {"dwell_s", motion.dwell_s},
                          {"length", motion.length}};
  document["axes"] = nlohmann::json::array();
  for (std::size_t i = 0; i < file.axes.size(); ++i) {
    nlohmann::json axis{{"name", file.axes[i].name}};
    for (std::size_t k = 0; k < kQuantities.size(); ++k) {
      axis[kQuantities[k]] = {{"largest", motion.largest[k][i]}, {"limit", limit_of(file, i, k)}};
    }
    document["axes"].push_back(axis);
  }
  for (std::size_t k = 0; k < kQuantities.size(); ++k) {
    const double limit = limits_of_tool(file)[k];
    document["tool"][kQuantities[k]] = {{"largest", motion.largest_of_tool[k]},
                                        {"limit", std::isfinite(limit) ? nlohmann::json(limit) : nlohmann::json()}};
  }
  document["outputs"] = nlohmann::json::array();
  for (const auto& [time_s, change, move, tool] : motion.outputs) {
    document["outputs"].push_back({{"time_s", time_s},
                                   {"name", file.outputs[change.output]},
                                   {"value", change.value},
                                   {"line", file.moves[move].line}});
  }
  return document;
}

Outcome<double> share_of(const std::optional<std::string>& text) {
  if (!text) return 1.0;
  double percent = 0.0;
  const auto [end, fault] = std::from_chars(text->data(), text->data() + text->size(), percent);
  if (fault != std::errc{} || end != text->data() + text->size() || !(percent > 0.0 && percent <= 200.0)) {
    return misused("--override is a percentage above 0 and up to 200");
  }
  return percent / 100.0;
}

Outcome<int> plan(const PlanOptions& options) {
  const auto share = share_of(options.share);
  if (!share) return tl::unexpected(share.error());
  const auto text = runtime::read_input_lines(options.file);
  if (!text) return tl::unexpected(Failure(text.error()));
  if (text->empty()) return misused(fmt::format("{}: is empty", options.file));
  const auto file = parse_moves(*text, options.file);
  if (!file) return misused(file.error());
  if (const auto refusal = refusal_of(*file, options.file); !refusal.empty()) return misused(refusal);
  std::optional<PlanSamples> samples;
  if (options.samples) samples.emplace(*options.samples, *file);
  const auto motion = follow(*file, options.file, *share, samples ? &*samples : nullptr);
  if (!motion) return tl::unexpected(motion.error());
  if (samples) {
    if (auto written = samples->complete(); !written) return tl::unexpected(Failure(written.error()));
  }
  if (options.picture) {
    if (auto written = runtime::write_file(*options.picture, picture_of(*file, *motion)); !written) {
      return tl::unexpected(Failure(written.error()));
    }
  }
  print_out("{}", options.json ? json_text(plan_json(*file, *motion)) : plan_text(*file, *motion));
  return 0;
}

}  // namespace

Execute prepare_plan(Arguments& to) {
  auto options = std::make_shared<PlanOptions>();
  to.required(&options->file, Value::file(), "Moves as JSON lines");
  to.option("--override", &options->share, Value::text("PERCENT"),
            "Override of the feed in percent, up to 200; default: 100");
  to.option("--picture", &options->picture, Value::file(), "Draw path and speed into this SVG file");
  to.option("--samples", &options->samples, Value::file(), "Write the setpoints of every cycle into this CSV file");
  add_json_flag(to, options->json);
  return [options] { return plan(*options); };
}

}  // namespace driveline::cli
