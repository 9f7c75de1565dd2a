#include "config/coupling_reader.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <string_view>
#include <utility>

#include "driveline/runtime/config/finite_number.hpp"
#include "driveline/trajectory/axis_name.hpp"
#include "driveline/trajectory/gear_ratio.hpp"
#include "driveline/trajectory/position_unit.hpp"

namespace driveline::runtime {
namespace {

using trajectory::AxisKind;

/// Limits of encoder values, in rad/s or m/s, rad/s^2 or m/s^2.
constexpr double kLeastOfEncoder = 1e-6;
constexpr double kMaxEncoderVelocity = 1e6;
constexpr double kMaxEncoderAcceleration = 1e9;
constexpr double kMaxEncoderNoise = 1e6;  // increments
constexpr double kLeastCutoffHz = 0.1;
constexpr double kMaxCutoffHz = 1e4;
constexpr double kMaxLatencyUs = 100'000.0;
/// The first letters of units.
constexpr std::string_view kUnitLetters = "dmru";
constexpr std::int64_t kMaxEncoderRange = std::int64_t{1} << 32;

template <typename Named>
std::optional<std::size_t> find_named(const std::vector<Named>& all, std::string_view name) {
  const auto found = std::find_if(all.begin(), all.end(), [&](const Named& one) { return one.name == name; });
  if (found == all.end()) return std::nullopt;
  return static_cast<std::size_t>(found - all.begin());
}

std::string_view kind_text(AxisKind kind) {
  return kind == AxisKind::kLinear ? "linear" : "rotary";
}

std::string read_encoder_name(TomlReader& reader, const LineConfig& config) {
  auto name = reader.text("name");
  std::vector<std::string_view> names;
  for (const auto& axis : config.axes) names.push_back(axis.name);
  for (const auto& encoder : config.couplings.encoders) names.push_back(encoder.name);
  if (const auto checked = trajectory::check_axis_name(name, names); !checked)
    reader.fail("name", describe(checked.error()));
  return name;
}

/// Reads the scale as for an axis: linear if there is a feed per revolution; the unit must agree.
void read_scale(TomlReader& reader, EncoderConfig& encoder) {
  const double increments = reader.number("increments_per_revolution", 1.0, kMaxIncrementsPerRevolution);
  const bool linear = reader.has("feed_mm_per_revolution");
  constexpr double kMmPerM = 1000.0;
  const double turn = linear ? reader.number("feed_mm_per_revolution", 1e-6, 1e6) / kMmPerM : 2.0 * std::numbers::pi;
  encoder.increments_per_unit = increments / turn;
  const auto kind = linear ? AxisKind::kLinear : AxisKind::kRotary;
  const auto name = reader.text_or("unit", std::string(trajectory::si_unit(kind)));
  encoder.unit = trajectory::find_position_unit(name);
  if (encoder.unit != nullptr && encoder.unit->kind == kind) return;
  reader.fail("unit", fmt::format("is \"{}\", {} is expected", name,
                                  linear ? "\"m\", \"mm\" or \"um\" of an encoder with feed_mm_per_revolution"
                                         : "\"rad\", \"deg\" or \"rev\" of an encoder without feed_mm_per_revolution"));
}

/// Checks that the direction of motion is unambiguous between two valid positions of the encoder.
void check_range(const TomlReader& reader, const LineConfig& config, const EncoderConfig& encoder) {
  if (!encoder.range) return;
  const double unseen_s = std::chrono::duration<double>(config.period).count() * (config.max_lost_cycles + 1.0);
  const double way = encoder.max_velocity * unseen_s * encoder.increments_per_unit;
  if (way < 0.5 * static_cast<double>(*encoder.range)) return;
  reader.fail("range_increments",
              fmt::format("is {}, and at max_velocity the encoder moves {:.6g} increments in {} cycles, which may be "
                          "lost: less than half of the range is expected",
                          *encoder.range, way, config.max_lost_cycles + 1));
}

EncoderConfig read_encoder(TomlReader reader, const LineConfig& config) {
  EncoderConfig encoder;
  encoder.name = read_encoder_name(reader, config);
  encoder.position = reader.text("position");
  encoder.position_place = reader.place("position");
  read_scale(reader, encoder);
  encoder.reversed = reader.choice_or("polarity", 0, {"normal", "reversed"}) == 1;
  const auto limit = [&](std::string_view key, double most) {
    return encoder.unit->to_si(reader.number(key, encoder.unit->from_si(kLeastOfEncoder), encoder.unit->from_si(most)));
  };
  encoder.max_velocity = limit("max_velocity", kMaxEncoderVelocity);
  if (reader.has("max_acceleration")) encoder.max_acceleration = limit("max_acceleration", kMaxEncoderAcceleration);
  if (reader.has("range_increments")) encoder.range = reader.integer("range_increments", 2, kMaxEncoderRange);
  check_range(reader, config, encoder);
  encoder.cutoff_hz = reader.number_or("filter_hz", encoder.cutoff_hz, kLeastCutoffHz, kMaxCutoffHz);
  encoder.noise_increments = reader.number_or("noise_increments", encoder.noise_increments, 0.0, kMaxEncoderNoise);
  const std::chrono::duration<double, std::micro> latency{reader.number_or("latency_us", 0.0, 0.0, kMaxLatencyUs)};
  encoder.latency = std::chrono::round<std::chrono::nanoseconds>(latency);
  reader.finish();
  return encoder;
}

CamConfig read_cam(TomlReader reader, const std::filesystem::path& directory, const std::vector<CamConfig>& others) {
  using trajectory::CamKind;
  using trajectory::CamMethod;
  constexpr std::array kMethods{CamMethod::kQuintic, CamMethod::kSpline, CamMethod::kCubic, CamMethod::kLinear};
  constexpr std::array kKinds{CamKind::kPeriodic, CamKind::kAdvancing, CamKind::kOneShot};
  CamConfig cam;
  cam.name = reader.text("name");
  if (cam.name.empty()) reader.fail("name", "must not be empty");
  if (find_named(others, cam.name)) reader.fail("name", fmt::format("\"{}\" is there twice", cam.name));
  const auto table = trajectory::load_cam_table(directory / reader.text("file"));
  if (!table) reader.fail("file", table.error().message());
  std::vector<std::string_view> methods;
  for (const auto method : kMethods) methods.push_back(to_text(method));
  std::vector<std::string_view> kinds;
  for (const auto kind : kKinds) kinds.push_back(to_text(kind));
  const auto method = kMethods.at(reader.choice_or("method", 0, methods));
  const auto kind = kKinds.at(reader.choice_or("kind", 0, kinds));
  auto made = trajectory::Cam::make(*table, method, kind);
  if (!made) reader.fail("file", made.error().message());
  cam.cam = std::make_shared<const trajectory::Cam>(std::move(*made));
  reader.finish();
  return cam;
}

AxisKind kind_of_master(const LineConfig& config, const CouplingConfig& coupling) {
  return coupling.axis ? config.axes[*coupling.axis].kind : config.couplings.encoders[*coupling.encoder].unit->kind;
}

/// Reads "10 mm" as rad or m.
double read_travel(const TomlReader& reader, const std::string& text, AxisKind kind, std::string_view whose) {
  const auto end = text.find_first_of(kUnitLetters);
  auto number = std::string_view(text).substr(0, end);
  while (number.ends_with(' ')) number.remove_suffix(1);
  const auto value = finite_number(number);
  const auto* const unit =
      end == std::string::npos ? nullptr : trajectory::find_position_unit(std::string_view(text).substr(end));
  if (value && unit != nullptr && unit->kind == kind) return unit->to_si(*value);
  reader.fail("ratio", fmt::format("\"{}\": the travel of the {} {} is expected, such as \"{}\"", text, kind_text(kind),
                                   whose, kind == AxisKind::kLinear ? "10 mm" : "360 deg"));
}

/// Reads a gear ratio of two distances with units.
trajectory::GearRatio read_travels(TomlReader& reader, AxisKind slave, AxisKind master) {
  const auto texts = reader.texts_or("ratio", {});
  if (texts.size() != 2) {
    reader.fail(
        "ratio",
        "two distances are expected: [\"10 mm\", \"360 deg\"] moves the slave by 10 mm while its master turns by "
        "360 deg");
  }
  const double of_slave = read_travel(reader, texts[0], slave, "slave");
  const double of_master = read_travel(reader, texts[1], master, "master");
  const auto ratio = trajectory::GearRatio::of_travel(of_slave, of_master);
  if (!ratio) reader.fail("ratio", "both distances must be other than 0, and their ratio within 1 to 2^31");
  return *ratio;
}

/// Reads a gear ratio: two whole numbers.
trajectory::GearRatio read_ratio(TomlReader& reader) {
  const auto numbers = reader.numbers("ratio", -static_cast<double>(trajectory::kMaxGearNumber),
                                      static_cast<double>(trajectory::kMaxGearNumber));
  const bool whole = std::all_of(numbers.begin(), numbers.end(), [](double one) { return std::trunc(one) == one; });
  if (numbers.size() != 2 || !whole)
    reader.fail("ratio",
                "two whole numbers are expected: [2, 3] moves the slave two thirds of the distance of its master");
  const auto ratio =
      trajectory::GearRatio::make(static_cast<std::int64_t>(numbers[0]), static_cast<std::int64_t>(numbers[1]));
  if (!ratio) reader.fail("ratio", ratio.error().message());
  return *ratio;
}

void read_master(TomlReader& reader, const LineConfig& config, CouplingConfig& coupling) {
  const auto name = reader.text("master");
  coupling.actual = reader.choice_or("master_value", 0, {"setpoint", "actual"}) == 1;
  coupling.axis = find_named(config.axes, name);
  coupling.encoder = find_named(config.couplings.encoders, name);
  if (!coupling.axis && !coupling.encoder)
    reader.fail("master", fmt::format("there is no [[axis]], [[virtual_axis]] or [[encoder]] named \"{}\"", name));
  if (coupling.axis == coupling.slave) reader.fail("master", fmt::format("\"{}\" cannot be its own master", name));
  if (!coupling.actual) return;
  if (coupling.encoder) reader.fail("master_value", "is for axes: an encoder has only actual positions");
  if (config.axes[*coupling.axis].is_virtual())
    reader.fail("master_value", fmt::format("\"{}\" is virtual and has only setpoints", name));
}

/// Refuses a coupling whose slave would, through its masters, follow itself.
void check_circle(const TomlReader& reader, const LineConfig& config, const CouplingConfig& coupling) {
  auto names = config.axes[coupling.slave].name;
  for (auto at = coupling.axis; at;) {
    names += " follows " + config.axes[*at].name;
    if (*at == coupling.slave) reader.fail("master", fmt::format("is part of a coupling loop: {}", names));
    const auto* const next = config.couplings.of(*at);
    at = next != nullptr ? next->axis : std::nullopt;
  }
}

/// Reads the ratio of the coupling. Whole numbers between an angle and a length count m and rad, which a note says.
void read_coupling_ratio(TomlReader& reader, LineConfig& config, CouplingConfig& coupling) {
  if (!reader.has("ratio")) return;
  coupling.ratio_given = true;
  const auto slave = config.axes[coupling.slave].kind;
  const auto master = kind_of_master(config, coupling);
  if (reader.holds_texts("ratio")) {
    coupling.ratio = read_travels(reader, slave, master);
    return;
  }
  coupling.ratio = read_ratio(reader);
  if (slave == master) return;
  const bool linear = slave == AxisKind::kLinear;
  config.notes.push_back(fmt::format(
      "{}: [{}, {}] counts {} of the slave per {} of its master; with units it is [\"{}\", \"{}\"]",
      reader.place("ratio"), coupling.ratio.numerator(), coupling.ratio.denominator(), trajectory::si_unit(slave),
      trajectory::si_unit(master), linear ? "10 mm" : "360 deg", linear ? "360 deg" : "10 mm"));
}

void check_cam(const TomlReader& reader, const LineConfig& config, const CouplingConfig& coupling) {
  if (!coupling.cam) return;
  const auto& cam = config.couplings.cams[*coupling.cam];
  const auto master = kind_of_master(config, coupling);
  const auto slave = config.axes[coupling.slave].kind;
  if (cam.cam->master_kind() == master && cam.cam->slave_kind() == slave) return;
  reader.fail("cam", fmt::format("\"{}\" is for a {} slave and a {} master, but this slave is {} and its master {}",
                                 cam.name, kind_text(cam.cam->slave_kind()), kind_text(cam.cam->master_kind()),
                                 kind_text(slave), kind_text(master)));
}

CouplingConfig read_coupling(TomlReader reader, LineConfig& config) {
  CouplingConfig coupling;
  const auto name = reader.text("slave");
  coupling.place = reader.place("slave");
  const auto slave = find_named(config.axes, name);
  if (!slave) reader.fail("slave", fmt::format("there is no [[axis]] or [[virtual_axis]] named \"{}\"", name));
  coupling.slave = *slave;
  if (config.couplings.of(*slave) != nullptr)
    reader.fail("slave", fmt::format("\"{}\" already has a master: one [[coupling]] per slave is expected", name));
  if (config.stream && std::count(config.stream->axes.begin(), config.stream->axes.end(), *slave) > 0) {
    reader.fail("slave", fmt::format("\"{}\" follows a [stream]: remove it from `axes` there", name));
  }
  read_master(reader, config, coupling);
  check_circle(reader, config, coupling);
  read_coupling_ratio(reader, config, coupling);
  if (reader.has("cam")) {
    const auto cam = reader.text("cam");
    coupling.cam = find_named(config.couplings.cams, cam);
    if (!coupling.cam) reader.fail("cam", fmt::format("there is no [[cam]] named \"{}\"", cam));
    check_cam(reader, config, coupling);
  }
  const bool stops = reader.choice_or("on_loss", 0, {"follow", "stop"}) == 1;
  coupling.on_loss = stops ? trajectory::OnLoss::kStop : trajectory::OnLoss::kFollow;
  reader.finish();
  return coupling;
}

}  // namespace

void read_couplings(TomlReader& root, const std::filesystem::path& directory, LineConfig& config) {
  auto& plan = config.couplings;
  for (auto& reader : root.tables("encoder")) plan.encoders.push_back(read_encoder(std::move(reader), config));
  for (auto& reader : root.tables("cam")) plan.cams.push_back(read_cam(std::move(reader), directory, plan.cams));
  for (auto& reader : root.tables("coupling")) plan.couplings.push_back(read_coupling(std::move(reader), config));
  if (!plan.couplings.empty() && config.path)
    root.fail("coupling", "needs axes that wait for requests: remove [path], which moves all axes");
}

}  // namespace driveline::runtime
