#include "text/drive_page.hpp"

#include <fmt/format.h>

#include <cmath>

#include "driveline/motion/cia402/cia402.hpp"
#include "driveline/slaves/cia402/words.hpp"
#include "driveline/slaves/msd/core/terminals.hpp"
#include "driveline/slaves/msd/core/variant.hpp"
#include "text/seven_segments.hpp"

namespace driveline::cli {
namespace {

using motion::cia402::AxisState;
using slaves::OperationMode;
using slaves::PowerState;
using slaves::msd::Input;
using slaves::msd::Output;
using slaves::msd::Series;
using std::chrono::nanoseconds;
using Object = DriveObject;

constexpr std::uint32_t kMoog = 0x00000028;

/// The simulated drive with this product code; null: another drive.
const slaves::msd::VariantFacts* simulated(const DriveValues& values) {
  if (values.bits(Object::kVendor) != kMoog) return nullptr;
  for (const auto& variant : slaves::msd::kVariants) {
    if (values.bits(Object::kProduct) == variant.product_code) return &variant;
  }
  return nullptr;
}

AxisState state_of(const DriveValues& values) {
  return motion::cia402::decode_state(static_cast<std::uint16_t>(values.bits(Object::kStatusWord).value_or(0xFFFF)));
}

std::string_view mode_name(double mode) {
  switch (static_cast<OperationMode>(static_cast<int>(mode))) {
    case OperationMode::kNone:
      return "none";
    case OperationMode::kProfilePosition:
      return "profile position";
    case OperationMode::kVelocity:
      return "velocity";
    case OperationMode::kProfileVelocity:
      return "profile velocity";
    case OperationMode::kHoming:
      return "homing";
    case OperationMode::kInterpolatedPosition:
      return "interpolated position";
    case OperationMode::kCyclicSynchronousPosition:
      return "cyclic synchronous position";
    case OperationMode::kCyclicSynchronousVelocity:
      return "cyclic synchronous velocity";
    case OperationMode::kCyclicSynchronousTorque:
      return "cyclic synchronous torque";
  }
  return "unknown";
}

/// A bit of a word, and its name.
struct Named {
  unsigned bit;
  std::string_view name;
};
constexpr unsigned bit(Input input) noexcept {
  return static_cast<unsigned>(input);
}
constexpr unsigned bit(Output output) noexcept {
  return static_cast<unsigned>(output);
}
constexpr std::array kFunctions = {  // 60FDh, MSD manual Table 10.5
    Named{0, "negative limit"}, Named{1, "positive limit"}, Named{2, "home"}, Named{18, "safe stop"},
    Named{19, "ENPO"}};
constexpr std::array kTerminals = {  // 2079h, MSD manual Table 10.6
    Named{bit(Input::kEnpo), "ENPO"},   Named{bit(Input::kIsdsh), "ISDSH"}, Named{bit(Input::kIsd00), "ISD00"},
    Named{bit(Input::kIsd01), "ISD01"}, Named{bit(Input::kIsd02), "ISD02"}, Named{bit(Input::kIsd03), "ISD03"},
    Named{bit(Input::kIsd04), "ISD04"}, Named{bit(Input::kIsd05), "ISD05"}, Named{bit(Input::kIsd06), "ISD06"},
    Named{bit(Input::kIsa00), "ISA00"}, Named{bit(Input::kIsa01), "ISA01"}};
constexpr std::array kOutputs = {  // 208Fh, MSD manual Table 10.7
    Named{bit(Output::kOsd00), "OSD00"}, Named{bit(Output::kOsd01), "OSD01"},   Named{bit(Output::kOsd02), "OSD02"},
    Named{bit(Output::kBrake), "brake"}, Named{bit(Output::kRelay), "RELOUT1"}, Named{bit(Output::kStoRelay), "RSH"}};

template <std::size_t kSize>
std::string names_of(std::uint32_t word, const std::array<Named, kSize>& bits) {
  std::string names;
  for (const auto& named : bits) {
    if ((word >> named.bit & 1U) != 0) names += fmt::format("{}{}", names.empty() ? "" : " ", named.name);
  }
  return names.empty() ? "-" : names;
}

/// A line such as "  inputs 60FDh       0x000C0000  safe stop ENPO".
template <std::size_t kSize>
std::string word_line(const DriveValues& values, Object object, std::string_view label,
                      const std::array<Named, kSize>& bits) {
  const auto word = values.bits(object);
  if (!word) return {};
  return fmt::format("  {:<18} 0x{:08X}  {}\n", label, *word, names_of(*word, bits));
}

/// Revolutions of the drive shaft per position unit; none unless the factor group uses plain units (power of ten 0).
std::optional<double> revolutions_per_unit(const DriveValues& values, Object notation) {
  const auto feed = values.number(Object::kFeed);
  const auto revolutions = values.number(Object::kFeedRevolutions);
  const auto power = values.number(notation).value_or(0.0);
  if (!feed || !revolutions || *feed <= 0.0 || std::abs(power) > 0.0) return std::nullopt;
  return *revolutions / *feed;
}

/// A value such as "1234567 (1.177 rev)"; without `factor` only the number.
std::string quantity(std::optional<double> raw, std::optional<double> factor, std::string_view unit) {
  if (!raw) return "";
  if (!factor) return fmt::format("{:.0f}", *raw);
  return fmt::format("{:.0f} ({:.3f} {})", *raw, *raw * *factor, unit);
}

/// A row with actual value, demand and target; empty: the drive has none of them.
std::string quantity_line(const DriveValues& values, std::string_view label, std::array<Object, 3> objects,
                          std::optional<double> factor, std::string_view unit) {
  std::array<std::string, 3> cells;
  for (std::size_t i = 0; i < cells.size(); ++i) cells[i] = quantity(values.number(objects[i]), factor, unit);
  if (cells[0].empty() && cells[1].empty() && cells[2].empty()) return {};
  std::string line = fmt::format("  {:<18} {:<26} {:<26} {}", label, cells[0], cells[1], cells[2]);
  line.resize(line.find_last_not_of(' ') + 1);
  return line + "\n";
}

/// Torque in Nm of 0.1 % of the rated torque.
std::optional<double> torque_factor(const DriveValues& values) {
  const auto rated_mnm = values.number(Object::kRatedTorque);
  if (!rated_mnm || *rated_mnm <= 0.0) return std::nullopt;
  return *rated_mnm * 1e-6;
}

std::optional<double> current_factor(const DriveValues& values) {
  const auto rated_ma = values.number(Object::kRatedCurrent);
  if (!rated_ma || *rated_ma <= 0.0) return std::nullopt;
  return *rated_ma * 1e-6;
}

std::string quantities(const DriveValues& values) {
  auto position = revolutions_per_unit(values, Object::kPositionNotation);
  auto velocity = revolutions_per_unit(values, Object::kVelocityNotation);
  if (velocity) *velocity *= 60.0;
  if (!position) velocity.reset();  // velocity units are based on position units
  std::string text = fmt::format("  {:<18} {:<26} {:<26} {}\n", "", "actual", "demand", "target");
  text += quantity_line(values, "position", {Object::kPositionActual, Object::kPositionDemand, Object::kTargetPosition},
                        position, "rev");
  text += quantity_line(values, "velocity", {Object::kVelocityActual, Object::kVelocityDemand, Object::kTargetVelocity},
                        velocity, "rpm");
  text += quantity_line(values, "torque, 0.1 %", {Object::kTorqueActual, Object::kTorqueDemand, Object::kTargetTorque},
                        torque_factor(values), "Nm");
  if (const auto current = values.number(Object::kCurrentActual)) {
    text += fmt::format("  {:<18} {}\n", "current, 0.1 %", quantity(current, current_factor(values), "A"));
  }
  if (const auto error = values.number(Object::kFollowingError)) {
    text += fmt::format("  {:<18} {}\n", "following error", quantity(error, position, "rev"));
  }
  if (const auto dc_link_mv = values.number(Object::kDcLink)) {
    text += fmt::format("  {:<18} {:.1f} V\n", "DC link", *dc_link_mv * 1e-3);
  }
  return text;
}

std::string parameters(const DriveValues& values) {
  std::string text;
  bool left = true;
  for (const auto& row : drive_objects()) {
    auto value = values.number(row.object);
    if (!row.important || !value) continue;
    if (row.object == Object::kPeriodValue)
      *value *= 1e3 * std::pow(10.0, values.number(Object::kPeriodIndex).value_or(0));
    const auto cell = fmt::format("{:<26} {:.10g}{}{}", row.label, *value, row.unit.empty() ? "" : " ", row.unit);
    text += left ? fmt::format("  {:<45}", cell) : cell + "\n";
    left = !left;
  }
  if (!left) text += "\n";
  // Remove blanks at line ends.
  std::string trimmed;
  for (const char c : text) {
    if (c == '\n') trimmed.resize(trimmed.find_last_not_of(' ') + 1);
    trimmed += c;
  }
  return trimmed;
}

std::string fault_line(const DriveValues& values) {
  const auto code = static_cast<std::uint16_t>(values.bits(Object::kErrorCode).value_or(0));
  if (code == 0) return "none";
  std::string text = fmt::format("0x{:04X}", code);
  if (const auto error = error_class(code); !error.empty()) text += fmt::format(" ({})", error);
  if (const auto own = values.text(Object::kFaultText); !own.empty()) text += ": " + own;
  return text;
}

std::string warning_line(const DriveValues& values) {
  const auto word = values.bits(Object::kWarnings);
  const auto status = values.bits(Object::kStatusWord);
  const bool warned = (word && *word != 0) || (status && (*status & slaves::status_word::kWarning) != 0);
  if (!warned) return "none";
  std::string text = word ? fmt::format("0x{:08X}", *word) : std::string("yes");
  if (const auto own = values.text(Object::kWarningText); !own.empty()) text += ": " + own;
  return text;
}

/// "(*)" for a lit LED, "( )" for a dark one.
std::string_view lamp(bool lit) {
  return lit ? "(*)" : "( )";
}

std::string leds(const DriveView& view, nanoseconds time) {
  using slaves::msd::Connector;
  const auto* model = simulated(view.values);
  const Series series = model == nullptr ? Series::kSingleMultiAxis : model->series;
  std::string text;
  if (series == Series::kServoOneJunior) {
    const auto h1 = slaves::msd::status_led_h1(view.al.status, view.al.code, time);
    text = fmt::format("H1 green {} red {}", lamp(h1.green), lamp(h1.red));
  } else {
    text = fmt::format("RUN {}", lamp(slaves::msd::run_led(view.al.status.state, time)));
  }
  for (const auto& [port, name] : {std::pair(0U, "X15"), std::pair(1U, "X16")}) {
    // The frames of this program count as activity, too.
    const slaves::msd::LinkState link{view.dl.ports[port].link, view.dl.ports[port].communication};
    text += fmt::format("   {} L/A {}", name, lamp(slaves::msd::link_activity_led(link, time)));
  }
  return text;
}

std::string heading(const DriveView& view) {
  const auto& values = view.values;
  std::string text = fmt::format("slave {} of {}", view.position, view.slaves);
  if (view.drive != 0) text += fmt::format(", drive {}", view.drive);
  const auto append = [&text](std::string_view what, const std::string& part) {
    if (!part.empty()) text += fmt::format("   {}{}", what, part);
  };
  append("", values.text(Object::kAlias));
  append("", values.text(Object::kDeviceName));
  append("firmware ", values.text(Object::kSoftwareVersion));
  if (const auto serial = values.bits(Object::kSerial)) append("serial ", std::to_string(*serial));
  text += "\n";
  if (view.other_master) {
    const bool exchanging =
        view.al.status.state == wire::AlState::kSafeOp || view.al.status.state == wire::AlState::kOp;
    text += fmt::format("{}: only the mailbox of the drive is used, which both share.\n",
                        exchanging ? "Another master works with this line"
                                   : "A master has taken this line out of INIT and may be active");
  }
  if (!view.trouble.empty()) text += fmt::format("Previous values: {}\n", view.trouble);
  return text;
}

/// The framed display, and its meaning beside it.
std::string front(const DriveView& view, nanoseconds time) {
  const auto& values = view.values;
  const auto content = display_content(view);
  const bool only_er = content.fault && content.fault->number == 0;  // the fault number is unknown
  const auto rows = draw_display(slaves::msd::display_frame(content, only_er ? nanoseconds{0} : time));
  const auto mode = values.number(Object::kModeDisplay);
  const auto wanted = values.number(Object::kMode);
  std::string mode_text = mode ? fmt::format("{:.0f} {}", *mode, mode_name(*mode)) : "?";
  if (mode && wanted && std::abs(*mode - *wanted) > 0.0) mode_text += fmt::format(", 6060h asks for {:.0f}", *wanted);
  std::string network = std::string(wire::to_text(view.al.status.state));
  if (view.al.status.error) {
    network += fmt::format(" + error 0x{:04X} ({})", static_cast<unsigned>(view.al.code), wire::to_text(view.al.code));
  }
  const auto word = [&values](Object object) {
    const auto bits = values.bits(object);
    return bits ? fmt::format("0x{:04X}", *bits) : std::string("?");
  };
  std::string text = fmt::format("  +-----------+   EtherCAT  {}   {}\n", network, leds(view, time));
  text += fmt::format("  | {} |   drive     {}   control {} status {}\n", rows[0],
                      motion::cia402::to_text(state_of(values)), word(Object::kControlWord), word(Object::kStatusWord));
  text += fmt::format("  | {} |   mode      {}\n", rows[1], mode_text);
  text += fmt::format("  | {} |   fault     {}\n", rows[2], fault_line(values));
  text += fmt::format("  +-----------+   warnings  {}\n", warning_line(values));
  return text;
}

}  // namespace

std::string_view error_class(std::uint16_t code) noexcept {
  switch (code >> 12) {
    case 0x1:
      return "generic";
    case 0x2:
      return "current";
    case 0x3:
      return "voltage";
    case 0x4:
      return "temperature";
    case 0x5:
      return "hardware";
    case 0x6:
      return "software";
    case 0x7:
      return "additional modules";
    case 0x8:
      return "monitoring";
    case 0x9:
      return "external";
    case 0xF:
      return "of the manufacturer";
    default:
      return {};
  }
}

slaves::msd::DisplayContent display_content(const DriveView& view) {
  slaves::msd::DisplayContent content;
  const auto& values = view.values;
  const auto state = state_of(values);
  // The manual numbers the states from 1 (MSD manual 10.1.2).
  if (state <= AxisState::kFault) content.state = static_cast<PowerState>(static_cast<unsigned>(state) + 1);
  content.starting = values.bits(Object::kNetworkState) == 0U;
  if (const auto inputs = values.bits(Object::kInputState)) {
    content.safe_torque_off = (*inputs >> bit(Input::kIsdsh) & 1U) == 0;
  }
  if (state == AxisState::kFault) {
    content.fault = slaves::msd::DisplayContent::FaultCode{};
    const auto last = values.bits(Object::kLastError);
    if (last && simulated(values) != nullptr) {
      content.fault->number = static_cast<std::uint8_t>(*last >> 16);
      content.fault->location = static_cast<std::uint8_t>(*last >> 24);
    }
  }
  return content;
}

std::string drive_page(const DriveView& view, nanoseconds shown_for) {
  const auto& values = view.values;
  return heading(view) + "\n" + front(view, shown_for) + "\n" + quantities(values) + "\n" +
         word_line(values, Object::kDigitalInputs, "inputs 60FDh", kFunctions) +
         word_line(values, Object::kInputState, "terminals 2079h", kTerminals) +
         word_line(values, Object::kOutputState, "outputs 208Fh", kOutputs) + "\n" + parameters(values);
}

nlohmann::json drive_json(const DriveView& view) {
  const auto& values = view.values;
  nlohmann::json objects = nlohmann::json::object();
  for (const auto& row : drive_objects()) {
    const std::string key(row.key);
    if (row.type == esi::DataType::kVisibleString) {
      if (const auto text = values.text(row.object); !text.empty()) objects[key] = text;
    } else if (row.type == esi::DataType::kReal32) {
      if (const auto number = values.number(row.object); number && std::isfinite(*number)) objects[key] = *number;
    } else if (const auto number = values.number(row.object)) {
      objects[key] = static_cast<std::int64_t>(*number);
    }
  }
  const auto frame = slaves::msd::display_frame(display_content(view), nanoseconds{0});
  return {{"slave", view.position},
          {"drive", view.drive},
          {"al_state", wire::to_text(view.al.status.state)},
          {"al_error", view.al.status.error},
          {"al_status_code", static_cast<unsigned>(view.al.code)},
          {"other_master", view.other_master},
          {"state", motion::cia402::to_text(state_of(values))},
          {"mode_name", mode_name(values.number(Object::kModeDisplay).value_or(0.0))},
          {"display", slaves::msd::to_text(frame)},
          {"objects", objects}};
}

}  // namespace driveline::cli
