// How does an axis move in each homing method, and how long does it take? Runs every method from three start positions,
// on the simulated drive on virtual time. With --figures writes a CSV: method, start, time, position, speed, and the
// home position. docs/figures/homing.py draws it.
#include <fmt/format.h>

#include <array>
#include <fstream>
#include <limits>
#include <numbers>
#include <stdexcept>
#include <string>
#include <vector>

#include "driveline/slaves/msd/core/drive_values.hpp"
#include "driveline/slaves/msd/msd_drive.hpp"
#include "support/report.hpp"

namespace {

using namespace driveline;
using namespace driveline::bench;
using slaves::msd::Input;
using std::chrono::nanoseconds;

constexpr double kTurn = 2.0 * std::numbers::pi;
constexpr double kEndless = std::numeric_limits<double>::infinity();
// The machine, in revolutions of the motor; docs/figures/homing.py draws the same machine.
constexpr double kLimit = 4.3;    ///< limit switches from here outwards
constexpr double kEdge = 1.4;     ///< reference switch of methods 3 to 6 from here outwards
constexpr double kCamLeft = 0.6;  ///< cam of methods 7 to 14
constexpr double kCamRight = 1.7;
constexpr double kIncrements = 1048576.0;
constexpr auto kSample = std::chrono::milliseconds{5};
constexpr auto kLongest = std::chrono::seconds{60};

/// A drive in PREOP that is commanded by SDOs only.
class Drive {
 public:
  explicit Drive(const slaves::msd::MsdParameters& parameters) : drive_(parameters) {
    drive_.advance(now_);
    pass(std::chrono::milliseconds{5});
    static_cast<void>(drive_.transition(wire::AlState::kInit, wire::AlState::kPreOp));
  }
  /// Expedited download; false: it was refused.
  bool write(std::uint16_t index, std::uint8_t subindex, std::uint32_t value, unsigned size) {
    std::array<std::byte, 512> mailbox{};
    const std::span bytes(mailbox);
    counter_ = wire::next_mailbox_counter(counter_);
    wire::MailboxHeader{10, 0, 0, 0, wire::MailboxType::kCoe, counter_}.encode(bytes.first<6>());
    bytes::store_le<std::uint16_t>(bytes.subspan(6), 0x2000);  // SDO request
    bytes::store_le(bytes.subspan(8), static_cast<std::uint8_t>(0x23U | (4U - size) << 2U));
    bytes::store_le(bytes.subspan(9), index);
    bytes::store_le(bytes.subspan(11), subindex);
    bytes::store_le(bytes.subspan(12), value);
    drive_.mailbox_request(mailbox);
    return drive_.mailbox_reply(mailbox) > 8 && mailbox[8] == std::byte{0x60};
  }
  void pass(nanoseconds time) { drive_.advance(now_ += time); }
  [[nodiscard]] const slaves::msd::DriveCore& model() const { return drive_.core(); }

 private:
  slaves::msd::MsdDrive drive_;
  nanoseconds now_{1'000'000'000};
  std::uint8_t counter_ = 0;
};

int without_index(int method) {
  return method > 16 && method < 31 ? method - 16 : method;
}

slaves::msd::MsdParameters machine(int method, double start) {
  const int number = without_index(method);
  slaves::msd::MsdParameters parameters;
  parameters.initial_position_rad = start * kTurn;
  parameters.switches = {{Input::kIsd00, -kEndless, -kLimit * kTurn}, {Input::kIsd01, kLimit * kTurn, kEndless}};
  if (number == 3 || number == 4) {
    parameters.switches.push_back({Input::kIsd02, kEdge * kTurn, kEndless});
  } else if (number == 5 || number == 6) {
    parameters.switches.push_back({Input::kIsd02, -kEndless, -kEdge * kTurn});
  } else if (number >= 7 && number <= 14) {
    parameters.switches.push_back({Input::kIsd02, kCamLeft * kTurn, kCamRight * kTurn});
  }
  return parameters;
}

/// Start positions left of the switch, on it and right of it, as far as the method has these sides.
std::array<double, 3> starts(int method) {
  const int number = without_index(method);
  if (number == 1) return {-4.45, -1.7, 2.4};
  if (number == 2) return {-2.4, 1.7, 4.45};
  if (number >= 3 && number <= 6) return {-2.6, number <= 4 ? 1.75 : -1.75, 2.8};
  if (number <= 14) return {-2.4, 1.15, 3.1};
  return {-2.6, 0.45, 3.3};
}

std::uint32_t per_second(double revolutions) {
  return static_cast<std::uint32_t>(revolutions * kIncrements);
}

/// Sets up everything except the motion: two speeds, an acceleration, inputs, operation enabled in mode 6.
bool prepare(Drive& drive, int method) {
  bool good = drive.write(0x2065, 0, 6, 2) && drive.write(0x2066, 0, 5, 2) && drive.write(0x2067, 0, 10, 2) &&
              drive.write(0x6098, 0, static_cast<std::uint8_t>(method), 1) &&
              drive.write(0x6099, 1, per_second(2.0), 4) && drive.write(0x6099, 2, per_second(0.4), 4) &&
              drive.write(0x609A, 0, per_second(8.0), 4) && drive.write(0x6060, 0, 6, 1);
  for (const std::uint32_t word : {0x06U, 0x07U, 0x0FU}) {
    good = good && drive.write(0x6040, 0, word, 2);
    drive.pass(std::chrono::milliseconds{20});
  }
  return good;
}

/// Writes the motion of the axis to a file.
class Curve {
 public:
  /// `folder`: empty: nothing is written.
  explicit Curve(const std::string& folder) {
    if (folder.empty()) return;
    out_.open(folder + "/homing.csv");
    if (!out_) throw std::runtime_error(folder + "/homing.csv cannot be written");
    out_ << "method,start,time_s,position_rev,speed_rev_s,home_rev\n";
  }
  void line(const std::string& text) {
    if (out_.is_open()) out_ << text << '\n';
  }

 private:
  std::ofstream out_;
};

/// Executes a method once; returns its duration in ms. Throws if homing is not attained.
double run_method(int method, std::size_t number, double start, Curve& curve) {
  Drive drive(machine(method, start));
  const auto where = fmt::format("method {} from {} revolutions", method, start);
  if (!prepare(drive, method) || !drive.write(0x6040, 0, 0x1F, 2)) throw std::runtime_error(where + ": did not start");
  constexpr std::uint16_t kAttained = 0x1400;  // homing attained, target reached
  for (nanoseconds time{0}; time < kLongest; time += kSample) {
    const auto& model = drive.model();
    curve.line(fmt::format("{},{},{:.3f},{:.4f},{:.3f},", method, number, std::chrono::duration<double>(time).count(),
                           model.position_rad() / kTurn, model.velocity_rad_s() / kTurn));
    if ((model.status() & kAttained) == kAttained) {
      // The drive's zero is at home, so the displayed position gives the position of home.
      const std::int32_t shown = model.dictionary().get(slaves::msd::kValue.position_actual);
      const double home = model.position_rad() / kTurn - shown / kIncrements;
      curve.line(fmt::format("{},{},,,,{:.6f}", method, number, home));
      return std::chrono::duration<double, std::milli>(time).count();
    }
    drive.pass(kSample);
  }
  throw std::runtime_error(where + ": no home found");
}

void measure(const Options& options) {
  Report report("homing_paths");
  Curve curve(options.figures);
  for (int method = 1; method <= 37; ++method) {
    if (!slaves::HomingSequence::supported(static_cast<std::int8_t>(method))) continue;
    const auto places = starts(method);
    std::vector<double> times_ms;
    for (std::size_t i = 0; i < places.size(); ++i) times_ms.push_back(run_method(method, i, places[i], curve));
    report.add({fmt::format("method_{}", method), "time_to_home", "ms", summarize(times_ms)});
  }
  report.note("virtual time, in steps of 5 ms; from three start positions each");
  if (options.figures.empty()) report.print(options);
}

}  // namespace

int main(int argc, char** argv) {
  return driveline::bench::run(argc, argv, "Which path does an axis follow in each homing method?", measure);
}
