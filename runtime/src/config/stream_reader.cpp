#include "config/stream_reader.hpp"

#include <fmt/format.h>
#include <grp.h>
#include <sys/types.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <chrono>
#include <string>
#include <string_view>

#include "config/machine_user.hpp"

namespace driveline::runtime {
namespace {

constexpr double kShortestKeepAliveMs = 10.0;
constexpr double kLongestKeepAliveMs = 10'000.0;
constexpr double kLongestDelayMs = 500.0;

std::chrono::nanoseconds duration_of_ms(double ms) {
  return std::chrono::round<std::chrono::nanoseconds>(std::chrono::duration<double, std::milli>(ms));
}

/// Returns the decimal number in the text; none: the text is no number.
std::optional<unsigned> number_in(std::string_view text) {
  unsigned value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc{} || end != text.data() + text.size()) return std::nullopt;
  return value;
}

uid_t user_of(const TomlReader& reader, const std::string& name) {
  const auto found = find_user(name);
  if (!found) reader.fail("users", fmt::format("there is no user \"{}\" on this machine", name));
  return found->user;
}

gid_t group_of(const TomlReader& reader, const std::string& name) {
  if (const auto number = number_in(name)) return *number;
  group entry{};
  group* found = nullptr;
  std::array<char, 16384> texts{};
  ::getgrnam_r(name.c_str(), &entry, texts.data(), texts.size(), &found);
  if (found == nullptr) reader.fail("group", fmt::format("there is no group \"{}\" on this machine", name));
  return found->gr_gid;
}

std::size_t axis_of(const TomlReader& reader, const std::string& name, const std::vector<motion::AxisConfig>& axes) {
  const auto found = std::find_if(axes.begin(), axes.end(), [&](const auto& axis) { return axis.name == name; });
  if (found == axes.end()) reader.fail("axes", fmt::format("there is no [[axis]] named \"{}\"", name));
  return static_cast<std::size_t>(found - axes.begin());
}

}  // namespace

std::optional<StreamConfig> read_stream(TomlReader reader, const std::vector<motion::AxisConfig>& axes) {
  using Method = trajectory::StreamMethod;
  StreamConfig stream;
  const bool enabled = reader.boolean_or("enabled", true);
  stream.socket = reader.text("socket");
  if (stream.socket.empty()) reader.fail("socket", "is empty, the path of a socket is expected");
  std::vector<std::string> names;
  for (const auto& axis : axes) names.push_back(axis.name);
  for (const auto& name : reader.texts_or("axes", names)) {
    const auto axis = axis_of(reader, name, axes);
    const bool twice = std::find(stream.axes.begin(), stream.axes.end(), axis) != stream.axes.end();
    if (twice) reader.fail("axes", fmt::format("has \"{}\" twice", name));
    stream.axes.push_back(axis);
  }
  constexpr std::array kMethods = {Method::kHold,  Method::kLinear,  Method::kHermite,
                                   Method::kCubic, Method::kQuintic, Method::kBSpline};
  stream.settings.method =
      kMethods[reader.choice_or("interpolation", 3, {"hold", "linear", "hermite", "cubic", "quintic", "b_spline"})];
  stream.settings.keep_alive =
      duration_of_ms(reader.number_or("keep_alive_ms", 100.0, kShortestKeepAliveMs, kLongestKeepAliveMs));
  stream.settings.delay = duration_of_ms(reader.number_or("delay_ms", 5.0, 0.0, kLongestDelayMs));
  for (const auto& name : reader.texts_or("users", {})) stream.allowed.users.push_back(user_of(reader, name));
  if (reader.has("group")) stream.allowed.group = group_of(reader, reader.text("group"));
  reader.finish();
  if (!enabled) return std::nullopt;
  if (stream.axes.empty()) reader.fail("axes", "no axis is left for streams");
  return stream;
}

}  // namespace driveline::runtime
