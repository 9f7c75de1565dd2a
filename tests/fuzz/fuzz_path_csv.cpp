// Path files.

#include <cmath>
#include <string>

#include "driveline/trajectory/interpolation_method.hpp"
#include "driveline/trajectory/interpolator.hpp"
#include "driveline/trajectory/path.hpp"
#include "fuzz_target.hpp"

namespace driveline::fuzz {

void test_one_input(std::span<const std::byte> input) {
  std::string text;
  for (const auto byte : input) text += static_cast<char>(byte);
  const auto path = trajectory::parse_path_csv(text, "input.csv");
  if (!path) {
    if (path.error().message().empty()) std::abort();
    return;
  }
  std::vector<trajectory::AxisSetpoint> setpoints(path->axes().size());
  for (const auto& facts : trajectory::interpolation_methods()) {
    auto curve = trajectory::Interpolator::make(*path, facts.method);
    curve.evaluate(0.5 * (curve.start_s() + curve.end_s()), setpoints);
    for (const auto& setpoint : setpoints) {
      if (!std::isfinite(setpoint.position)) std::abort();
    }
  }
}

std::vector<Bytes> seeds() {
  constexpr std::string_view kTexts[] = {
      "time[s],x[rad],y[mm]\n0,0,0\n0.001,1e-3,2\n0.002,-4,8.5\n",
      "time[s],x[mm],x[m/s],x[mm/s^2]\n0,0,1,0\n0.5,4,-2,1e3\n0.75,0,0,-5\n",
      "\xEF\xBB\xBF# comment\r\ntime[ms],a[deg],b[rev]\r\n0,0,0\r\n\r\n1,90,0.25\r\n2.5,180,0.5\r\n",
  };
  std::vector<Bytes> inputs;
  for (const auto text : kTexts) {
    inputs.emplace_back();
    for (const char c : text) inputs.back().push_back(static_cast<std::byte>(c));
  }
  return inputs;
}

}  // namespace driveline::fuzz
