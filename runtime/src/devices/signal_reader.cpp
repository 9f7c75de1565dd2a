#include "devices/signal_reader.hpp"

#include <fmt/format.h>

#include <cmath>

namespace driveline::runtime {
namespace {

using slaves::Signal;

constexpr double kMaxValue = 1e18;  ///< largest value of a script; larger numbers fit no entry
constexpr double kMaxPeriodS = 86400.0;

std::chrono::nanoseconds from_s(double seconds) {
  return std::chrono::nanoseconds{std::llround(seconds * 1e9)};
}

/// The first step must be at time 0, so that the input has a value at every time.
void read_steps(TomlReader& reader, Signal& signal) {
  const auto times_ms = reader.numbers("at_ms", 0.0, kMaxPeriodS * 1e3);
  const auto values = reader.numbers("values", -kMaxValue, kMaxValue);
  if (times_ms.empty() || times_ms.front() > 0.0) reader.fail("at_ms", "must start with 0, the start of the script");
  if (times_ms.size() != values.size()) {
    reader.fail("values", fmt::format("has {} numbers, at_ms has {}: the same number is expected", values.size(),
                                      times_ms.size()));
  }
  signal.low = values.front();
  for (std::size_t i = 1; i < values.size(); ++i) {
    if (times_ms[i] <= times_ms[i - 1]) {
      reader.fail("at_ms", fmt::format("{} follows {}, rising times are expected", times_ms[i], times_ms[i - 1]));
    }
    signal.steps.push_back({from_s(times_ms[i] * 1e-3), values[i]});
  }
}

}  // namespace

Signal read_signal(TomlReader& reader) {
  using Shape = Signal::Shape;
  constexpr Shape kShapes[] = {Shape::kConstant, Shape::kRamp, Shape::kSine, Shape::kToggle, Shape::kSteps};
  Signal signal;
  signal.shape = kShapes[reader.choice_or("shape", 0, {"constant", "ramp", "sine", "toggle", "steps"})];
  if (signal.shape == Shape::kConstant) {
    signal.low = reader.number("value", -kMaxValue, kMaxValue);
    return signal;
  }
  if (signal.shape == Shape::kSteps) {
    read_steps(reader, signal);
    return signal;
  }
  signal.low = reader.number_or("low", 0.0, -kMaxValue, kMaxValue);
  signal.high = reader.number_or("high", 1.0, -kMaxValue, kMaxValue);
  signal.period = from_s(reader.number("period_s", 1e-6, kMaxPeriodS));
  return signal;
}

}  // namespace driveline::runtime
