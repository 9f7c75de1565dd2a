#include "axes/coupling_words.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cstdint>
#include <optional>
#include <vector>

#include "axes/axis_words.hpp"
#include "axes/quantity.hpp"
#include "driveline/runtime/toml/suggestion.hpp"

namespace driveline::cli {
namespace {

using motion::AxisConfig;
using runtime::CouplingOrder;
using Kind = CouplingOrder::Kind;

constexpr std::array<std::string_view, 5> kCouplingVerbs{"gear-in", "gear-out", "cam-in", "cam-out", "phase"};
constexpr std::array<std::string_view, 9> kOrderOptions{"at", "over", "to",           "master",  "slave",
                                                        "by", "jerk", "acceleration", "velocity"};
/// Default limits of a phase shift: the share of the master's velocity and acceleration limits, and acceleration per
/// velocity and jerk per acceleration.
constexpr double kPhaseShare = 0.1;
constexpr double kPhaseRamps = 10.0;  // per s
constexpr double kPhaseJerks = 50.0;  // per s

Kind kind_of(std::string_view verb) {
  if (verb == "gear-in") return Kind::kGearIn;
  if (verb == "cam-in") return Kind::kCamIn;
  return verb == "phase" ? Kind::kPhase : Kind::kOut;
}

/// The encoder as an axis, for parsing quantities in its unit.
AxisConfig as_axis(const runtime::EncoderConfig& encoder) {
  AxisConfig axis;
  axis.name = encoder.name;
  axis.unit = encoder.unit;
  axis.kind = encoder.unit->kind;
  axis.limits.max_velocity = encoder.max_velocity;
  axis.limits.max_acceleration = encoder.max_acceleration.value_or(kPhaseRamps * encoder.max_velocity);
  return axis;
}

/// Parses a whole number, as in the ratio "3/2" or "-2".
std::optional<std::int64_t> whole_number(std::string_view text) {
  std::int64_t value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc{} || end != text.data() + text.size()) return std::nullopt;
  return value;
}

/// Builds an order word by word.
class OrderReader {
 public:
  OrderReader(const AxisConfig& slave, AxisConfig master, const runtime::CouplingPlan& plan,
              const runtime::CouplingConfig& coupling, std::string_view verb)
      : slave_(slave), master_(std::move(master)), plan_(plan), verb_(verb) {
    order_.kind = kind_of(verb);
    order_.ratio = coupling.ratio;
    ratio_given_ = coupling.ratio_given;
    cam_ = coupling.cam;
  }

  [[nodiscard]] Outcome<CouplingOrder> read(std::span<const std::string> words) {
    for (const auto& word : words) {
      if (auto taken = take(word); !taken) return tl::unexpected(taken.error());
    }
    if (auto whole = check(); !whole) return tl::unexpected(whole.error());
    return order_;
  }

 private:
  [[nodiscard]] tl::unexpected<Failure> wrong(std::string_view reason) const {
    return misused(fmt::format("axis {}: {}: {}", slave_.name, verb_, reason));
  }

  [[nodiscard]] Outcome<void> take(std::string_view word) {
    const auto equals = word.find('=');
    if (equals != std::string_view::npos) return take_option(word.substr(0, equals), word.substr(equals + 1));
    if (order_.kind == Kind::kGearIn) {
      // "10 mm : 360 deg" may come as one word or as several.
      ratio_text_ += (ratio_text_.empty() ? "" : " ") + std::string(word);
      return {};
    }
    if (operand_ || order_.kind == Kind::kOut) return wrong(fmt::format("\"{}\" was not expected", word));
    operand_ = true;
    if (order_.kind == Kind::kCamIn) return take_cam(word);
    return take(order_.phase, master_, Quantity::kPosition, word, "phase");
  }

  [[nodiscard]] Outcome<void> take_ratio() {
    if (ratio_text_.empty()) {
      if (ratio_given_ || slave_.kind == master_.kind) return {};
      return wrong(fmt::format("{}, and the [[coupling]] has no ratio: {}", kinds(), units_expected()));
    }
    const auto colon = ratio_text_.find(':');
    return colon == std::string::npos ? take_numbers(ratio_text_) : take_travels(colon);
  }

  /// "2 m" moves the slave, and the master moves by the second distance meanwhile.
  [[nodiscard]] Outcome<void> take_travels(std::size_t colon) {
    const auto trimmed = [](std::string_view text) {
      while (text.starts_with(' ')) text.remove_prefix(1);
      while (text.ends_with(' ')) text.remove_suffix(1);
      return text;
    };
    double slave = 0.0;
    double master = 0.0;
    const std::string_view text = ratio_text_;
    if (auto taken = take(slave, slave_, Quantity::kPosition, trimmed(text.substr(0, colon)), "ratio, slave"); !taken)
      return taken;
    if (auto taken = take(master, master_, Quantity::kPosition, trimmed(text.substr(colon + 1)), "ratio, master");
        !taken)
      return taken;
    const auto ratio = trajectory::GearRatio::of_travel(slave, master);
    if (!ratio) return wrong(fmt::format("\"{}\": both distances must be other than 0, and within 1 to 2^31", text));
    order_.ratio = *ratio;
    return {};
  }

  [[nodiscard]] std::string kinds() const {
    return slave_.linear() ? "the slave is linear and its master rotary" : "the slave is rotary and its master linear";
  }
  [[nodiscard]] std::string units_expected() const {
    return fmt::format("a ratio with units is expected, such as {}", slave_.linear() ? "10mm:360deg" : "360deg:10mm");
  }

  [[nodiscard]] Outcome<void> take_numbers(std::string_view word) {
    if (slave_.kind != master_.kind) return wrong(fmt::format("\"{}\": {}: {}", word, kinds(), units_expected()));
    const auto slash = word.find('/');
    const auto numerator = whole_number(word.substr(0, slash));
    const auto denominator =
        slash == std::string_view::npos ? std::optional<std::int64_t>(1) : whole_number(word.substr(slash + 1));
    if (!numerator || !denominator)
      return wrong(
          fmt::format("\"{}\": a ratio of whole numbers such as 3/2 is expected, or of two distances such as "
                      "10mm:25mm",
                      word));
    const auto ratio = trajectory::GearRatio::make(*numerator, *denominator);
    if (!ratio) return wrong(ratio.error().message());
    order_.ratio = *ratio;
    return {};
  }

  [[nodiscard]] Outcome<void> take_cam(std::string_view word) {
    std::vector<std::string_view> names;
    for (std::size_t i = 0; i < plan_.cams.size(); ++i) {
      names.emplace_back(plan_.cams[i].name);
      if (names.back() == word) cam_ = i;
    }
    if (std::find(names.begin(), names.end(), word) != names.end()) return {};
    if (names.empty()) return wrong("the line description has no [[cam]]");
    return wrong(fmt::format("there is no cam \"{}\", but {}", word, fmt::join(names, ", ")));
  }

  [[nodiscard]] Outcome<void> take_option(std::string_view name, std::string_view value) {
    const bool gear = order_.kind == Kind::kGearIn;
    const bool cam = order_.kind == Kind::kCamIn;
    if ((gear || cam) && name == "at") return take(order_.at.emplace(), master_, Quantity::kPosition, value, name);
    if ((gear || cam) && name == "over") return take_distance(value);
    if (gear && name == "to") {
      to_ = true;
      return take(order_.to, slave_, Quantity::kPosition, value, name);
    }
    if (cam && name == "master") return take(order_.master_zero, master_, Quantity::kPosition, value, name);
    if (cam && name == "slave") return take(order_.slave_zero, slave_, Quantity::kPosition, value, name);
    if (order_.kind == Kind::kPhase) {
      if (name == "by" && !operand_) {
        operand_ = order_.relative = true;
        return take(order_.phase, master_, Quantity::kPosition, value, "phase");
      }
      if (name == "velocity") return take_limit(velocity_, Quantity::kVelocity, value, name);
      if (name == "acceleration") return take_limit(acceleration_, Quantity::kAcceleration, value, name);
      if (name == "jerk") return take_limit(jerk_, Quantity::kJerk, value, name);
    }
    const auto meant = runtime::closest(name, kOrderOptions);
    const bool known = std::find(kOrderOptions.begin(), kOrderOptions.end(), name) != kOrderOptions.end();
    return wrong(fmt::format("\"{}=\" does not belong there{}", name,
                             known || meant.empty() ? "" : fmt::format("; did you mean {}?", meant)));
  }

  [[nodiscard]] Outcome<void> take_distance(std::string_view value) {
    if (auto taken = take(order_.over, master_, Quantity::kPosition, value, "over"); !taken) return taken;
    if (!(order_.over > 0.0))
      return wrong("over= is the distance of the master within which the slave synchronizes; it must be above 0");
    return {};
  }

  [[nodiscard]] Outcome<void> take_limit(double& target, Quantity quantity, std::string_view value,
                                         std::string_view name) {
    if (auto taken = take(target, master_, quantity, value, name); !taken) return taken;
    if (!(target > 0.0)) return wrong(fmt::format("{} must be above 0", name));
    return {};
  }

  [[nodiscard]] static Outcome<void> take(double& target, const AxisConfig& axis, Quantity quantity,
                                          std::string_view text, std::string_view what) {
    const auto value = parse_quantity(axis, quantity, text, what);
    if (!value) return tl::unexpected(value.error());
    target = *value;
    return {};
  }

  [[nodiscard]] Outcome<void> check() {
    switch (order_.kind) {
      case Kind::kGearIn:
        if (auto taken = take_ratio(); !taken) return taken;
        if (order_.at.has_value() != to_)
          return wrong(
              "at=PLACE of the master and to=PLACE of the slave must be given together: they define the point of "
              "synchronism");
        break;
      case Kind::kCamIn:
        if (!cam_) return wrong("the name of a cam is needed: the [[coupling]] has none");
        order_.cam = *cam_;
        return check_kinds(*plan_.cams[*cam_].cam);
      case Kind::kPhase:
        if (!operand_) return wrong("an offset of the master, or by=DISTANCE, is needed");
        set_limits();
        return {};
      case Kind::kOut:
        return {};
    }
    if (order_.over > 0.0 && !order_.at) return wrong("over= needs at=");
    return {};
  }

  [[nodiscard]] Outcome<void> check_kinds(const trajectory::Cam& cam) const {
    if (order_.over > 0.0 && !order_.at) return wrong("over= needs at=");
    if (cam.master_kind() == master_.kind && cam.slave_kind() == slave_.kind) return {};
    return wrong(
        fmt::format("cam \"{}\" does not fit these axes: rotary and linear axes differ", plan_.cams[order_.cam].name));
  }

  void set_limits() {
    const double velocity = velocity_ > 0.0 ? velocity_ : kPhaseShare * master_.limits.max_velocity;
    const double acceleration = acceleration_ > 0.0
                                    ? acceleration_
                                    : std::min(kPhaseShare * master_.limits.max_acceleration, kPhaseRamps * velocity);
    order_.limits =
        trajectory::ProfileLimits::symmetric(velocity, acceleration, jerk_ > 0.0 ? jerk_ : kPhaseJerks * acceleration);
  }

  const AxisConfig& slave_;
  AxisConfig master_;
  const runtime::CouplingPlan& plan_;
  std::string_view verb_;
  CouplingOrder order_;
  std::string ratio_text_;    ///< words of the ratio, separated by spaces
  bool ratio_given_ = false;  ///< the [[coupling]] has a ratio
  std::optional<std::size_t> cam_{};
  bool operand_ = false;
  bool to_ = false;
  double velocity_ = 0.0;
  double acceleration_ = 0.0;
  double jerk_ = 0.0;
};

}  // namespace

std::span<const std::string_view> coupling_verbs() {
  return kCouplingVerbs;
}

bool is_coupling_verb(std::string_view word) {
  return std::find(kCouplingVerbs.begin(), kCouplingVerbs.end(), word) != kCouplingVerbs.end();
}

Outcome<CouplingOrder> parse_coupling_order(std::span<const AxisConfig> axes, const runtime::CouplingPlan& plan,
                                            std::size_t slave, std::span<const std::string> words) {
  const auto* const coupling = plan.of(slave);
  const auto& axis = axes[slave];
  if (coupling == nullptr) {
    return misused(
        fmt::format("axis {}: {}: it has no master: a [[coupling]] with slave = \"{}\" is expected in the "
                    "line description",
                    axis.name, words[0], axis.name));
  }
  auto master = coupling->axis ? axes[*coupling->axis] : as_axis(plan.encoders[*coupling->encoder]);
  auto order = OrderReader(axis, std::move(master), plan, *coupling, words[0]).read(words.subspan(1));
  if (!order) return order;
  for (const auto& word : words) order->text += (order->text.empty() ? "" : " ") + quoted_word(word);
  return order;
}

}  // namespace driveline::cli
