#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <initializer_list>
#include <limits>
#include <map>
#include <memory>
#include <system_error>

#include "client.hpp"
#include "driveline/rt/output_place.hpp"
#include "recorded.hpp"
#include "text.hpp"

namespace driveline::bridge::clients {
namespace {

// Dimensions of a picture in pixels.
constexpr double kWidth = 760;
constexpr double kPanelHeight = 110;  // of each of the two panels of an axis
constexpr double kSpacing = 48;       // between panels: ticks, and the name of the lower one
constexpr double kAbove = 62;         // legend, and the name of the first panel
constexpr double kBelow = 62;
constexpr double kLineHeight = 16;         // text line of an event
constexpr std::size_t kIntervals = 1500;   // more than the picture has pixels
constexpr std::size_t kLongestText = 110;  // characters of an event's text
constexpr int kNameTag = 10'000;           // label of a panel's name, above those of all events
constexpr std::string_view kCommanded = "with lines lw 4 lc rgb '#9ecae1'";
constexpr std::string_view kDemand = "with lines lc rgb '#238b45'";
constexpr std::string_view kActual = "with lines lc rgb '#08306b'";
constexpr std::string_view kError = "with lines lc rgb '#a63603'";
constexpr std::string_view kBatch = "driveline/v1/axis_batch";
constexpr std::string_view kAxis = "driveline/axis_telemetry";
constexpr std::string_view kEvent = "driveline/v1/event";

struct Point {
  std::int64_t time_ns;
  double target;
  double actual;
  double error;
  double demand;  ///< demand of the drive (6062h); NaN: unknown
};

struct Axis {
  std::string name;
  std::string unit = "rad or m";  // until the kind of the axis is known
  std::vector<Point> points;      ///< every cycle, from batches
  std::vector<Point> thinned;     ///< decimated samples
};

struct Mark {
  std::int64_t wall_ns;
  std::string text;
};

/// Data of a picture.
class Curves {
 public:
  void add(const Recorded& recorded) {
    const auto sample = decode(*recorded.topic->structure, recorded.bytes);
    if (!sample) return;
    if (recorded.topic->name == kBatch) add_batch(*sample);
    if (recorded.topic->name == kAxis) add_axis(*sample, recorded.received_ns);
    if (recorded.topic->name == kEvent) {
      marks_.push_back({static_cast<std::int64_t>(sample->find("wall_time_ns")->whole()),
                        std::string(sample->find("text")->text())});
    }
  }

  /// Returns the axes by number, with the points to draw: every cycle, or the decimated samples if no batches were
  /// recorded.
  [[nodiscard]] std::map<std::uint64_t, Axis> take_axes() {
    for (auto& [number, axis] : axes_) {
      if (axis.name.empty()) axis.name = fmt::format("axis {}", number);
      if (axis.points.empty()) axis.points = std::move(axis.thinned);
    }
    std::erase_if(axes_, [](const auto& each) { return each.second.points.empty(); });
    return std::move(axes_);
  }

  /// Events with their line time; events before and after the recording are omitted.
  [[nodiscard]] std::vector<std::pair<std::int64_t, std::string>> events() const {
    std::vector<std::pair<std::int64_t, std::string>> found;
    for (const auto& mark : marks_) {
      const auto behind = times_.upper_bound(mark.wall_ns);
      if (behind != times_.begin() && behind != times_.end()) found.emplace_back(std::prev(behind)->second, mark.text);
    }
    return found;
  }

 private:
  static Point point(const Value& sample, std::int64_t time_ns) {
    const auto* const demand = sample.find("demand_position");  // decimated samples have none
    return {time_ns, sample.find("target_position")->number(), sample.find("actual_position")->number(),
            sample.find("following_error")->number(),
            demand == nullptr ? std::numeric_limits<double>::quiet_NaN() : demand->number()};
  }

  void add_batch(const Value& batch) {
    const auto& cycles = batch.find("cycles")->parts;
    for (const auto& cycle : cycles) {
      times_.emplace(static_cast<std::int64_t>(cycle.find("wall_time_ns")->whole()),
                     static_cast<std::int64_t>(cycle.find("time_ns")->whole()));
    }
    for (const auto& sample : batch.find("samples")->parts) {
      const auto index = sample.find("cycle_index")->whole();
      if (index >= cycles.size()) continue;
      const auto time_ns = static_cast<std::int64_t>(cycles[index].find("time_ns")->whole());
      axes_[sample.find("axis")->whole()].points.push_back(point(sample, time_ns));
    }
  }

  void add_axis(const Value& sample, std::int64_t received_ns) {
    const auto time_ns = static_cast<std::int64_t>(sample.find("time_ns")->whole());
    times_.emplace(received_ns, time_ns);
    auto& axis = axes_[sample.find("axis")->whole()];
    axis.name = sample.find("name")->text();
    axis.unit = sample.find("kind")->text() == "AXIS_LINEAR" ? "m" : "rad";
    axis.thinned.push_back(point(sample, time_ns));
  }

  std::map<std::uint64_t, Axis> axes_;
  std::vector<Mark> marks_;
  std::map<std::int64_t, std::int64_t> times_;  ///< line time by wall-clock time
};

/// Vertical axis of a panel.
struct Scale {
  double low = -1;
  double high = 1;
  double step = 1;  ///< distance between ticks, a round number
  int power = 0;    ///< the labels are in units of ten to this power, a multiple of 3, so that they stay short
};

/// The scale of some members of all points, with a margin; NaN is ignored. A value that does not change has room for
/// ticks of six digits that differ.
Scale scale_of(const std::vector<Point>& points, std::initializer_list<double Point::*> members) {
  double low = std::numeric_limits<double>::infinity();
  double high = -low;
  for (const auto& point : points) {
    for (const auto member : members) {
      if (!std::isfinite(point.*member)) continue;
      low = std::min(low, point.*member);
      high = std::max(high, point.*member);
    }
  }
  constexpr double kLeastShare = 1e-3;
  const double magnitude = std::max(std::abs(low), std::abs(high));
  const double span = std::max(high - low, kLeastShare * magnitude);
  if (!(span > 0) || !std::isfinite(span)) return {};
  constexpr double kMargin = 0.04;
  constexpr double kTickIntervals = 5;
  Scale scale{0.5 * (low + high) - (0.5 + kMargin) * span, 0.5 * (low + high) + (0.5 + kMargin) * span};
  const double ten = std::pow(10.0, std::floor(std::log10(span / kTickIntervals)));
  constexpr double kRounding = 1e-9;
  const double digit = span / kTickIntervals / ten - kRounding;
  scale.step = (digit <= 1 ? 1 : digit <= 2 ? 2 : digit <= 5 ? 5 : 10) * ten;
  constexpr double kLeastPlain = 0.01;
  constexpr double kGreatestPlain = 1e5;
  if (magnitude < kLeastPlain || magnitude >= kGreatestPlain) {
    scale.power = 3 * static_cast<int>(std::floor(std::log10(magnitude) / 3));
  }
  return scale;
}

/// Quotes a string for gnuplot: texts come from recordings, and must not end the string and inject commands.
std::string in_quotes(std::string_view text) {
  std::string safe = "'";
  for (const char c : visible(text)) {
    safe += c;
    if (c == '\'') safe += c;
  }
  return safe + "'";
}

/// Reduces the points to the first one of each interval and those with its least and greatest following error, so that
/// no peak is lost.
std::vector<Point> reduced(const std::vector<Point>& points, std::int64_t begin_ns, std::int64_t end_ns) {
  const auto width = std::max<std::int64_t>((end_ns - begin_ns) / static_cast<std::int64_t>(kIntervals), 1);
  std::vector<Point> kept;
  for (std::size_t i = 0; i < points.size();) {
    const auto interval = (points[i].time_ns - begin_ns) / width;
    std::vector<std::size_t> of_interval{i, i, i};
    for (; i < points.size() && (points[i].time_ns - begin_ns) / width == interval; ++i) {
      if (points[i].error < points[of_interval[1]].error) of_interval[1] = i;
      if (points[i].error > points[of_interval[2]].error) of_interval[2] = i;
    }
    std::sort(of_interval.begin(), of_interval.end());
    of_interval.erase(std::unique(of_interval.begin(), of_interval.end()), of_interval.end());
    for (const auto each : of_interval) kept.push_back(points[each]);
  }
  return kept;
}

class Picture {
 public:
  Picture(std::vector<Axis> axes, const std::vector<std::pair<std::int64_t, std::string>>& events)
      : axes_(std::move(axes)) {
    for (const auto& axis : axes_) {
      begin_ns_ = std::min(begin_ns_, axis.points.front().time_ns);
      end_ns_ = std::max(end_ns_, axis.points.back().time_ns);
    }
    for (const auto& [time_ns, text] : events) {
      if (time_ns >= begin_ns_ && time_ns <= end_ns_) events_.emplace_back(seconds(time_ns), text);
    }
  }

  [[nodiscard]] std::string script(const std::string& output) const {
    const auto panels_count = static_cast<double>(2 * axes_.size());
    const auto below = kBelow + kLineHeight * static_cast<double>(events_.size());
    const auto height = kAbove + panels_count * kPanelHeight + (panels_count - 1) * kSpacing + below;
    auto text = fmt::format(
        "set terminal svg size {},{} font 'sans,11' background 'white' noenhanced\nset output {}\nset grid\n"
        "set key at screen 0.5,screen {:.6f} center top horizontal samplen 2\nset style textbox opaque noborder\n"
        "set xrange [0:{:.9g}]\n",
        kWidth, height, in_quotes(output), 1 - 8 / height, std::max(seconds(end_ns_), 1e-9));
    for (std::size_t i = 0; i < axes_.size(); ++i) text += data(i);
    text += fmt::format("set multiplot layout {},1 margins 0.08,0.98,{:.6f},{:.6f} spacing 0,{:.6f}\n",
                        2 * axes_.size(), below / height, 1 - kAbove / height, kSpacing / height);
    text += arrows();
    for (std::size_t i = 0; i < axes_.size(); ++i) {
      text += panels(i, i + 1 == axes_.size() ? sentences(height) : std::string{});
    }
    return text + "unset multiplot\n";
  }

 private:
  [[nodiscard]] double seconds(std::int64_t time_ns) const { return static_cast<double>(time_ns - begin_ns_) * 1e-9; }

  [[nodiscard]] std::string data(std::size_t i) const {
    auto text = fmt::format("$axis{} << END\n", i);
    for (const auto& point : reduced(axes_[i].points, begin_ns_, end_ns_)) {
      text += fmt::format("{:.9f} {} {} {} {}\n", seconds(point.time_ns), point.target, point.actual, point.error,
                          point.demand);
    }
    return text + "END\n";
  }

  /// A vertical line for each event in every panel, and the numbers of the events; those of events that are too close
  /// for two numbers share one: "3-5".
  [[nodiscard]] std::string arrows() const {
    std::string text;
    for (const auto& [at, sentence] : events_) {
      text +=
          fmt::format("set arrow from {0:.9f}, graph 0 to {0:.9f}, graph 1 nohead dashtype 2 lc rgb '#a63603'\n", at);
    }
    constexpr double kLabelShare = 0.08;  // of the width
    for (std::size_t first = 0; first < events_.size();) {
      auto end = first + 1;
      while (end < events_.size() && events_[end].first - events_[first].first < kLabelShare * seconds(end_ns_)) ++end;
      text += fmt::format("set label '{}' at {:.9f}, graph 0.9 center front boxed font 'sans,9'\n",
                          end == first + 1 ? fmt::format("{}", end) : fmt::format("{}-{}", first + 1, end),
                          0.5 * (events_[first].first + events_[end - 1].first));
      first = end;
    }
    return text;
  }

  /// Texts of the numbered events, below the last panel.
  [[nodiscard]] std::string sentences(double height) const {
    std::string text;
    for (std::size_t i = 0; i < events_.size(); ++i) {
      const auto& sentence = events_[i].second;
      const auto shown = sentence.size() > kLongestText ? sentence.substr(0, kLongestText) + " ..." : sentence;
      const auto line = static_cast<double>(events_.size() - i) - 0.5;
      text += fmt::format("set label {} at screen 0.02, screen {:.6f} font 'sans,9'\n",
                          in_quotes(fmt::format("{}  {:.3f} s  {}", i + 1, events_[i].first, shown)),
                          line * kLineHeight / height);
    }
    return text;
  }

  static bool has_demand(const Axis& axis) {
    return std::any_of(axis.points.begin(), axis.points.end(),
                       [](const Point& point) { return !std::isnan(point.demand); });
  }

  /// The two panels of an axis; `below` follows the second panel of the last axis.
  [[nodiscard]] std::string panels(std::size_t i, const std::string& below) const {
    const auto& axis = axes_[i];
    // Draws the actual position over a broad pale band, so that both are visible where they coincide.
    const bool demands = has_demand(axis);
    const auto positions = scale_of(axis.points, {&Point::target, &Point::actual, &Point::demand});
    auto text = vertical_axis(axis, "", positions) + (i == 0 ? "plot " + legend() : std::string("plot ")) +
                fmt::format("$axis{0} using 1:($2*1e{1}) {2} notitle, {3}'' using 1:($3*1e{1}) {4} notitle\n", i,
                            -positions.power, kCommanded,
                            demands ? fmt::format("'' using 1:($5*1e{}) {} notitle, ", -positions.power, kDemand) : "",
                            kActual);
    if (i == 0) text += "unset key\n";
    if (i + 1 == axes_.size()) text += "set xlabel 'time in s'\n" + below;
    const auto errors = scale_of(axis.points, {&Point::error});
    return text + vertical_axis(axis, " error", errors) +
           fmt::format("plot $axis{} using 1:($4*1e{}) {} notitle\n", i, -errors.power, kError);
  }

  /// Range, ticks and name of a panel. The name is above it, where a long one has room.
  [[nodiscard]] static std::string vertical_axis(const Axis& axis, std::string_view quantity, const Scale& scale) {
    const double factor = std::pow(10.0, -scale.power);
    return fmt::format(
        "set label {} {} at graph 0,graph 1 left offset 0,0.7\nset yrange [{:.9g}:{:.9g}]\nset ytics {:.9g}\n",
        kNameTag,
        in_quotes(fmt::format("{}{} in {}{}", axis.name, quantity,
                              scale.power == 0 ? "" : fmt::format("1e{} ", scale.power), axis.unit)),
        scale.low * factor, scale.high * factor, scale.step * factor);
  }

  /// Entries of the one legend, which the first panel draws.
  [[nodiscard]] std::string legend() const {
    const bool demands = std::any_of(axes_.begin(), axes_.end(), has_demand);
    return fmt::format(
        "keyentry {} title 'commanded', {}keyentry {} title 'actual', keyentry {} title 'following error', ",
        kCommanded, demands ? fmt::format("keyentry {} title 'demand (6062h)', ", kDemand) : "", kActual, kError);
  }

  std::vector<Axis> axes_;
  std::vector<std::pair<double, std::string>> events_;
  std::int64_t begin_ns_ = std::numeric_limits<std::int64_t>::max();
  std::int64_t end_ns_ = std::numeric_limits<std::int64_t>::min();
};

/// The requested axes in that order; all axes if no name is given.
Outcome<std::vector<Axis>> select_axes(std::map<std::uint64_t, Axis> axes, const std::vector<std::string>& names) {
  std::vector<Axis> chosen;
  std::string known;
  for (auto& [number, axis] : axes) known += (known.empty() ? "" : ", ") + axis.name;
  for (const auto& name : names) {
    const auto found =
        std::find_if(axes.begin(), axes.end(), [&](const auto& each) { return each.second.name == name; });
    if (found == axes.end()) return misused(fmt::format("there is no axis \"{}\"; there are {}", name, known));
    chosen.push_back(found->second);
  }
  if (names.empty()) {
    for (auto& [number, axis] : axes) chosen.push_back(std::move(axis));
  }
  return chosen;
}

/// Converts the points of an axis, whose kind must be known, to the unit in which it is drawn.
void show_in_unit(Axis& axis, const DisplayUnits& units) {
  const bool linear = axis.unit == "m";
  if (!linear && axis.unit != "rad") return;
  const auto& unit = units.of(axis.name, linear);
  axis.unit = unit.name;
  for (auto& point : axis.points) {
    for (auto* const value : {&point.target, &point.actual, &point.error, &point.demand}) *value /= unit.si;
  }
}

Outcome<void> run_gnuplot(const std::string& script) {
  constexpr int kNoProgram = 127 << 8;
  auto* const pipe = ::popen("exec gnuplot 2>/dev/null", "w");  // fixed words; names occur only in the script
  if (pipe == nullptr) return failed("gnuplot cannot be started");
  std::fwrite(script.data(), 1, script.size(), pipe);
  const int status = ::pclose(pipe);
  if (status == 0) return {};
  return failed(status == kNoProgram ? "gnuplot is not installed (Debian package gnuplot-nox)"
                                     : "gnuplot cannot draw the plot");
}

Outcome<void> draw(const Picture& picture, const std::string& output) {
  const auto cannot = [&](std::error_code error) {
    return failed(fmt::format("{}: {}", output, rt::describe_output_error(output, error)));
  };
  const auto place = rt::OutputPlace::find(output);
  if (!place) return cannot(place.error());
  // Opened here, because gnuplot continues when it cannot write. It stays open, so that the reader of a pipe does not
  // see an end before gnuplot writes.
  const auto file = place->open();
  if (!file) return cannot(file.error());
  auto drawn = run_gnuplot(picture.script(place->written()));
  ::close(*file);
  if (!drawn) {
    place->discard();
    return drawn;
  }
  if (const auto error = place->complete()) return cannot(error);
  return {};
}

}  // namespace

Outcome<int> plot(const Options& options) {
  const auto& name = options.argument;
  if (name.empty()) return misused("a recording is expected: plot FILE");
  Curves curves;
  if (auto read = read_recording(name, [&](const Recorded& each) { curves.add(each); }); !read) {
    return tl::unexpected(read.error());
  }
  auto axes = curves.take_axes();
  if (axes.empty()) return failed(fmt::format("{}: has no samples of axes", name));
  auto chosen = select_axes(std::move(axes), options.axes);
  if (!chosen) return tl::unexpected(chosen.error());
  for (auto& axis : *chosen) show_in_unit(axis, options.units);
  auto output = options.output;
  if (output.empty()) output = (name.ends_with(".mcap") ? name.substr(0, name.size() - 5) : name) + ".svg";
  if (output.starts_with('|')) output.insert(0, "./");  // gnuplot would start a program
  std::error_code ignored;
  if (std::filesystem::equivalent(output, name, ignored)) return misused(fmt::format("{}: is the recording", output));
  if (auto done = draw(Picture(std::move(*chosen), curves.events()), output); !done) {
    return tl::unexpected(done.error());
  }
  if (auto told = print(visible(output) + '\n'); !told) return tl::unexpected(told.error());
  return 0;
}

}  // namespace driveline::bridge::clients
