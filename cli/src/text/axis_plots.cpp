#include "text/axis_plots.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "text/gnuplot.hpp"
#include "text/visible_text.hpp"
#include "text/wrapped_text.hpp"

namespace driveline::cli {
namespace {

// Sizes in pixels.
constexpr double kWidth = 1400.0;
constexpr double kLeft = 68.0;        // ticks left of a panel
constexpr double kRight = 24.0;       // right of the last panel
constexpr double kIncrements = 76.0;  // ticks of the second axis
constexpr double kAbove = 84.0;       // title, legend and the name of the first panel
constexpr double kBelow = 56.0;       // ticks and label of the time
constexpr double kBetween = 46.0;     // ticks of a panel, and the name of the one below
constexpr double kSentence = 16.0;    // a line of text about an event
constexpr double kPanel = 130.0;      // height of a panel
constexpr double kSinglePanel = 190.0;

constexpr int kNameTag = 100;  // above the tags of the events
constexpr std::size_t kMaxSentences = 24;
constexpr std::size_t kLongestSentence = 200;
/// Labels of events that are closer than this share of the time are joined: they would cover each other.
constexpr double kLabelShare = 0.08;

/// Column numbers of an axis in axes.csv: time, three columns per axis, their torques, minimum and maximum following
/// error of each, then the following errors and the demands of the drives that report them (Recorder).
struct AxisColumns {
  std::size_t commanded;  ///< followed by the actual position
  std::size_t least;      ///< least following error; the next column is the greatest
  std::size_t by_drive;   ///< following error of the drive, if it reports one
  std::size_t demand;     ///< demand of the drive, if it is recorded
};

AxisColumns columns_of(const std::vector<runtime::AxisRunReport>& axes, std::size_t axis) {
  const auto reporting = [&](auto end) {
    return std::count_if(axes.begin(), end, [](const auto& each) { return each.by_drive.has_value(); });
  };
  const auto here = axes.begin() + static_cast<std::ptrdiff_t>(axis);
  const auto demands = std::count_if(axes.begin(), here, [](const auto& each) { return each.demand_recorded; });
  const auto last = 2 + 6 * axes.size();
  return {2 + 3 * axis, 2 + 4 * axes.size() + 2 * axis, last + static_cast<std::size_t>(reporting(here)),
          last + static_cast<std::size_t>(reporting(axes.end()) + demands)};
}

/// The curves of a panel.
class Curves {
 public:
  explicit Curves(int power) : factor_(power == 0 ? std::string{} : fmt::format("*1e{}", -power)) {}

  /// Adds a curve of a column, drawn `with` this style.
  void add(std::size_t column, std::string_view with) { add_columns(value(column), with); }
  /// Fills the area between two columns.
  void fill(std::size_t lower, std::size_t upper, std::string_view with) {
    add_columns(fmt::format("{}:{}", value(lower), value(upper)), with);
  }
  [[nodiscard]] const std::string& script() const { return text_; }

 private:
  [[nodiscard]] std::string value(std::size_t column) const {
    return factor_.empty() ? fmt::format("{}", column) : fmt::format("(${}{})", column, factor_);
  }
  void add_columns(const std::string& columns, std::string_view with) {
    text_ += fmt::format("{} skip 1 using 1:{} {} notitle", text_.empty() ? "plot 'axes.csv'" : ", ''", columns, with);
  }

  std::string factor_;
  std::string text_;
};

constexpr std::string_view kCommanded = "with lines lw 4 lc rgb '#9ecae1'";
constexpr std::string_view kDemand = "with lines lc rgb '#238b45'";
constexpr std::string_view kActual = "with lines lc rgb '#08306b'";
constexpr std::string_view kError = "with lines lt 1";
constexpr std::string_view kErrorBand = "with filledcurves lt 1";
constexpr std::string_view kErrorByDrive = "with lines lt 2";
constexpr std::string_view kMissed = "dt 2 lc rgb '#dd181f'";
constexpr std::string_view kEvent = "dt 2 lc rgb '#606060'";

std::string entry(std::string_view with, std::string_view title) {
  return fmt::format(", keyentry {} title {}", with, gnuplot_text(title));
}

/// Numbers of the events at the top of a panel; those of close events share a label: "3-5".
std::string numbers(const std::vector<PlotMark>& events, double span_s, int tag) {
  std::string script;
  for (std::size_t first = 0; first < events.size();) {
    auto end = first + 1;
    while (end < events.size() && events[end].time_s - events[first].time_s < kLabelShare * span_s) ++end;
    const auto text = end == first + 1 ? fmt::format("{}", end) : fmt::format("{}-{}", first + 1, end);
    const auto middle = 0.5 * (events[first].time_s + events[end - 1].time_s);
    script += fmt::format("set label {} '{}' at {:.6f},graph 0.9 center front boxed font ',9'\n", tag++, text, middle);
    first = end;
  }
  return script;
}

}  // namespace

AxisPlots::AxisPlots(std::vector<runtime::AxisRunReport> axes, bool increments, const std::vector<PlotMark>& marks,
                     std::vector<ValueRange> ranges)
    : axes_(std::move(axes)), increments_(increments), ranges_(std::move(ranges)) {
  for (const auto& mark : marks) {
    if (!is_before_picture(mark)) (mark.missed ? missed_ : events_).push_back(mark);
  }
  std::stable_sort(events_.begin(), events_.end(),
                   [](const PlotMark& a, const PlotMark& b) { return a.time_s < b.time_s; });
}

bool AxisPlots::is_before_picture(const PlotMark& mark) const {
  return !ranges_.empty() && !ranges_[0].empty() && mark.time_s < ranges_[0].low;
}

std::size_t AxisPlots::rows(std::size_t panels_per_axis) const {
  return panels_per_axis * (axes_.size() > 1 ? (axes_.size() + 1) / 2 : 1);
}

bool AxisPlots::is_last(std::size_t axis) const {
  return axes_.size() == 1 || axis + 2 >= axes_.size();
}

double AxisPlots::height(std::size_t panels_per_axis) const {
  const auto count = static_cast<double>(rows(panels_per_axis));
  const auto sentences = static_cast<double>(std::min(events_.size(), kMaxSentences + 1));
  return kAbove + count * (panels_per_axis > 1 ? kPanel : kSinglePanel) + (count - 1.0) * kBetween + kBelow +
         sentences * kSentence;
}

std::string AxisPlots::head(std::size_t panels_per_axis, std::string_view output, std::string_view title) const {
  const auto total = height(panels_per_axis);
  const auto sentences = static_cast<double>(std::min(events_.size(), kMaxSentences + 1));
  const double second = increments_ ? kIncrements : 0.0;
  return fmt::format(
             "reset\nset terminal pngcairo size {:.0f},{:.0f} font 'sans,11' noenhanced\nset output '{}'\n"
             "set datafile separator ','\n"
             "set multiplot layout {},{} title '{}' margins {:.6f},{:.6f},{:.6f},{:.6f} spacing {:.6f},{:.6f}\n"
             "set grid\nunset key\nset autoscale xfix\nset tics font ',10'\nset style textbox opaque noborder\n",
             kWidth, total, output, rows(panels_per_axis), axes_.size() > 1 ? 2 : 1, title, kLeft / kWidth,
             1.0 - (kRight + second) / kWidth, (kBelow + sentences * kSentence) / total, 1.0 - kAbove / total,
             (kLeft + second) / kWidth, kBetween / total) +
         marks();
}

std::string AxisPlots::marks() const {
  std::string script;
  int tag = 1;
  for (const auto* kind : {&missed_, &events_}) {
    for (const auto& mark : *kind) {
      script += fmt::format("set arrow {0} from {1:.6f},graph 0 to {1:.6f},graph 1 nohead {2}\n", tag++, mark.time_s,
                            kind == &missed_ ? kMissed : kEvent);
    }
  }
  const double span_s = ranges_.empty() || ranges_[0].empty() ? 0.0 : ranges_[0].size();
  return script + numbers(events_, span_s, 1);
}

PictureScale AxisPlots::scale(std::size_t axis, const std::vector<std::size_t>& columns) const {
  ValueRange values;
  for (const auto column : columns) {
    if (column > ranges_.size() || ranges_[column - 1].empty()) continue;
    values.include(ranges_[column - 1].low);
    values.include(ranges_[column - 1].high);
  }
  return scale_of(values, increments_ ? 1.0 / std::abs(axes_[axis].increments_per_unit) : 0.0);
}

std::string AxisPlots::vertical_axis(std::size_t axis, std::string_view quantity, const PictureScale& scale) const {
  const auto& drawn = axes_[axis];
  const auto name = fmt::format("{}{} in {}{}", drawn.name, quantity, scale.unit(drawn.unit),
                                increments_ ? "; right: increments" : "");
  auto script = fmt::format(
      "set label {} {} at graph 0,graph 1 left offset 0,0.7\nset yrange [{:.9g}:{:.9g}]\nset ytics {:.9g}\n", kNameTag,
      gnuplot_text(name), scale.labelled(scale.low), scale.labelled(scale.high), scale.labelled(scale.step));
  if (!increments_) return script;
  const double low = scale.low * drawn.increments_per_unit;
  const double high = scale.high * drawn.increments_per_unit;
  const auto second = scale_of({std::min(low, high), std::max(low, high)});
  return script + fmt::format("set ytics nomirror\nset y2range [{:.17g}:{:.17g}]\nset y2tics {:.9g} format '%.0f'\n",
                              low, high, std::max(second.step, 1.0));
}

std::string AxisPlots::position_panel(std::size_t axis) const {
  const auto columns = columns_of(axes_, axis);
  const bool demand = axes_[axis].demand_recorded;
  std::vector<std::size_t> shown{columns.commanded, columns.commanded + 1};
  if (demand) shown.push_back(columns.demand);
  const auto range = scale(axis, shown);
  // Draw the actual position over a wide pale band, so that both stay visible where they are equal.
  Curves curves(range.power);
  curves.add(columns.commanded, kCommanded);
  if (demand) curves.add(columns.demand, kDemand);
  curves.add(columns.commanded + 1, kActual);
  return vertical_axis(axis, "", range) + curves.script() + "\n";
}

std::string AxisPlots::error_panel(std::size_t axis, bool by_drive) const {
  const auto columns = columns_of(axes_, axis);
  const bool reported = by_drive && axes_[axis].by_drive;
  std::vector<std::size_t> shown{columns.least, columns.least + 1};
  if (reported) shown.push_back(columns.by_drive);
  const auto range = scale(axis, shown);
  // The band has the range between the rows of the file, so that no maximum is lost.
  Curves curves(range.power);
  curves.fill(columns.least, columns.least + 1, kErrorBand);
  curves.add(columns.least, kError);
  curves.add(columns.least + 1, kError);
  if (reported) curves.add(columns.by_drive, kErrorByDrive);
  return (is_last(axis) ? "set xlabel 'time in s'\n" : "") + vertical_axis(axis, " error", range) + curves.script() +
         "\nunset xlabel\n";
}

/// One legend for all panels, and the sentences about the numbered events below them, on a plot of its own.
std::string AxisPlots::legend(std::size_t panels_per_axis, const std::string& entries) const {
  const auto total = height(panels_per_axis);
  auto script = fmt::format(
      "unset arrow\nunset label\nunset grid\nunset border\nunset tics\n"
      "set lmargin at screen 0.02\nset rmargin at screen 0.98\nset bmargin at screen 0\nset tmargin at screen 1\n"
      "set xrange [0:1]\nset yrange [0:1]\nset key at screen 0.5,screen {:.6f} center top horizontal samplen 2\n",
      1.0 - 26.0 / total);
  const auto listed = std::min(events_.size(), kMaxSentences);
  const auto lines = std::min(events_.size(), kMaxSentences + 1);
  for (std::size_t i = 0; i < lines; ++i) {
    const auto text = i == listed ? fmt::format("and {} more events", events_.size() - listed)
                                  : fmt::format("{}  {:.3f} s  {}", i + 1, events_[i].time_s,
                                                shortened(visible_text(events_[i].text), kLongestSentence));
    script += fmt::format("set label {} {} at screen 0.02,screen {:.6f} font ',9'\n", i + 1, gnuplot_text(text),
                          (static_cast<double>(lines - i) - 0.5) * kSentence / total);
  }
  auto all = entries;
  if (!missed_.empty()) all += entry(fmt::format("with lines {}", kMissed), "periods missed");
  if (!events_.empty()) all += entry(fmt::format("with lines {}", kEvent), "events, listed below");
  return script + "plot NaN notitle" + all + "\nunset multiplot\n";
}

std::string AxisPlots::positions() const {
  auto script = head(2, "positions.png", "commanded and actual position; below, the following error");
  for (std::size_t first = 0; first < axes_.size(); first += 2) {
    const auto end = std::min(axes_.size(), first + 2);
    for (auto i = first; i < end; ++i) script += position_panel(i);
    // With an odd number of axes, the last one has no neighbour.
    if (end == first + 1 && axes_.size() > 1) script += "set multiplot next\n";
    for (auto i = first; i < end; ++i) script += error_panel(i, false);
  }
  const bool demands = std::any_of(axes_.begin(), axes_.end(), [](const auto& axis) { return axis.demand_recorded; });
  return script + legend(2, entry(kCommanded, "commanded") + (demands ? entry(kDemand, "demand (6062h)") : "") +
                                entry(kActual, "actual") + entry(kErrorBand, "following error, min to max"));
}

std::string AxisPlots::errors() const {
  auto script = head(1, "following_error.png", "following error");
  for (std::size_t i = 0; i < axes_.size(); ++i) script += error_panel(i, true);
  const bool reported = std::any_of(axes_.begin(), axes_.end(), [](const auto& axis) { return axis.by_drive; });
  return script + legend(1, entry(kErrorBand, "minimum and maximum") +
                                (reported ? entry(kErrorByDrive, "by the drive (60F4h)") : ""));
}

}  // namespace driveline::cli
