#include "driveline/runtime/setup/drive_facts.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <array>
#include <cmath>
#include <string>
#include <string_view>

#include "driveline/bytes/endian.hpp"
#include "driveline/ecat_master/coe/coe_client.hpp"
#include "driveline/ecat_master/error.hpp"
#include "driveline/ecat_master/error/facts.hpp"
#include "driveline/motion/cia402/cyclic_mode.hpp"
#include "driveline/motion/drive/drive_objects.hpp"

namespace driveline::runtime {
namespace {

using ecat_master::SdoFuture;
using ObjectData = ecat_master::Result<std::vector<std::byte>>;

constexpr std::uint16_t kVelocityFactor = 0x604C;
constexpr std::uint16_t kPositionRange = 0x607B;
constexpr std::uint16_t kPolarity = 0x607E;
constexpr std::uint16_t kEncoder = 0x608F;
constexpr std::uint16_t kGear = 0x6091;
constexpr std::uint16_t kFeed = 0x6092;
constexpr std::uint16_t kSupportedModes = 0x6502;
constexpr unsigned kVelocityTurned = 0x40;  // bits of 607Eh
constexpr unsigned kPositionTurned = 0x80;

/// Reads facts from objects, one after another, until an object cannot be read for a reason other than that the drive
/// does not have it. `Read` returns the data of an index and sub-index.
template <typename Read>
class FactReader {
 public:
  explicit FactReader(const Read& read) : read_(read) {}

  /// Leaves `to` empty if the drive does not have the object, or has it in another size.
  template <typename T>
  void take(std::uint16_t index, std::uint8_t subindex, std::optional<T>& to) {
    if (error_) return;
    const ObjectData data = read_(index, subindex);
    if (data && data->size() == sizeof(T)) to = bytes::load_le<T>(*data);
    if (data || data.error().template as<ecat_master::facts::SdoAbort>() != nullptr) return;
    error_ = data.error();
  }
  /// Leaves `to` empty unless both objects can be read.
  void take(std::uint16_t index, std::optional<DriveRatio>& to) {
    std::optional<std::uint32_t> numerator;
    std::optional<std::uint32_t> divisor;
    take(index, 1, numerator);
    take(index, 2, divisor);
    if (numerator && divisor) to = DriveRatio{*numerator, *divisor};
  }
  [[nodiscard]] const std::optional<ecat_master::Error>& error() const noexcept { return error_; }

 private:
  const Read& read_;
  std::optional<ecat_master::Error> error_{};
};

/// `range`: also reads 607Bh.
template <typename Read>
ecat_master::Result<DriveFacts> facts_of(const Read& read, bool range) {
  DriveFacts facts;
  FactReader reader(read);
  reader.take(kSupportedModes, 0, facts.supported_modes);
  reader.take(kPolarity, 0, facts.polarity);
  reader.take(kGear, facts.gear);
  reader.take(kFeed, facts.feed);
  reader.take(kEncoder, facts.encoder);
  reader.take(kVelocityFactor, facts.velocity_factor);
  if (range) {
    reader.take(kPositionRange, 1, facts.range_min);
    reader.take(kPositionRange, 2, facts.range_max);
  }
  if (reader.error()) return tl::unexpected(*reader.error());
  return facts;
}

/// All requests to one drive, in progress.
class DriveInquiry {
 public:
  /// `drive`: number of the drive in the slave.
  DriveInquiry(ecat_master::MailboxEngine& engine, std::uint16_t position, unsigned drive, bool range)
      : coe_(engine, position), range_(range) {
    // Start all requests at once; the answers are read in this order.
    const auto ask = [this, drive](std::uint16_t index, std::uint8_t subindex) -> ObjectData {
      asked_.push_back(coe_.start_upload({motion::object_of_drive(index, drive), subindex, false}));
      return {};
    };
    static_cast<void>(facts_of(ask, range_));
  }

  [[nodiscard]] ecat_master::Result<DriveFacts> finish() const {
    auto next = asked_.begin();
    return facts_of([&next](std::uint16_t, std::uint8_t) { return (next++)->get(); }, range_);
  }

 private:
  ecat_master::CoeClient coe_;
  bool range_;
  std::vector<SdoFuture> asked_;
};

std::optional<double> usable(const std::optional<DriveRatio>& ratio) noexcept {
  if (!ratio || ratio->numerator == 0 || ratio->divisor == 0) return std::nullopt;
  return static_cast<double>(ratio->numerator) / ratio->divisor;
}

/// Returns the modes of 6502h, "pp, pv, csp".
std::string mode_names(std::uint32_t modes) {
  constexpr std::array<std::string_view, 10> kNames{"pp", "vl", "pv", "tq", "", "hm", "ip", "csp", "csv", "cst"};
  std::vector<std::string_view> names;
  for (std::size_t bit = 0; bit < kNames.size(); ++bit) {
    if ((modes >> bit & 1U) != 0 && !kNames[bit].empty()) names.push_back(kNames[bit]);
  }
  return names.empty() ? "none of CiA 402" : fmt::format("{}", fmt::join(names, ", "));
}

/// Returns what to write into the description of an axis that cannot interpolate; empty: nothing would help.
std::string mode_instead(motion::cia402::Mode mode, std::uint32_t modes) {
  using motion::cia402::Mode;
  if (mode != Mode::kInterpolatedPosition) return {};
  for (const auto other : {Mode::kProfilePosition, Mode::kProfileVelocity}) {
    if ((modes & motion::cia402::mode_bit(other)) == 0) continue;
    return fmt::format(": with mode = \"{}\" in the [[axis]] the drive plans its motions itself", to_text(other));
  }
  return {};
}

Result<void> take_modes(motion::AxisConfig& axis, const DriveFacts& facts) {
  const auto modes = facts.supported_modes.value_or(0);
  if (modes == 0) return {};
  if ((modes & motion::cia402::mode_bit(axis.mode)) == 0) {
    return fail(
        ErrorKind::kSetting,
        fmt::format("axis {}: its drive does not support mode {}; according to 6502h it supports {}{}", axis.name,
                    motion::cia402::to_text(axis.mode), mode_names(modes), mode_instead(axis.mode, modes)));
  }
  axis.supported_modes = modes;
  return {};
}

/// Whether the master sends torques to the drive, or may be requested to.
bool uses_torques(const motion::AxisConfig& axis) {
  return axis.mode == motion::cia402::Mode::kCyclicTorque || axis.velocity_gain > 0.0 || axis.inertia > 0.0 ||
         axis.feed_forward.any();
}

/// Refuses a drive that inverts only positions: it would run away under the control loops of the master. A drive that
/// inverts positions and velocities but not torques, for which 607Eh has no bit (CiA 402-2; MSD manual 2361-2372),
/// would run away when it is commanded by torques.
Result<void> check_polarity(const motion::AxisConfig& axis, const DriveFacts& facts) {
  const unsigned polarity = facts.polarity.value_or(0);
  const bool position = (polarity & kPositionTurned) != 0;
  const bool velocity = (polarity & kVelocityTurned) != 0;
  if (position && velocity && uses_torques(axis)) {
    return fail(ErrorKind::kSetting,
                fmt::format("axis {}: 607Eh of its drive is {:02X}h and reverses positions and velocities but not "
                            "torques, so that torques would have the wrong direction: polarity = \"reversed\" "
                            "in the [[axis]] reverses all of them, with 607Eh = 0",
                            axis.name, polarity));
  }
  if (position == velocity) return {};
  return fail(ErrorKind::kSetting,
              fmt::format("axis {}: 607Eh of its drive is {:02X}h, so it counts positions in another direction than "
                          "velocities: both of bits 7 and 6 are expected, or none",
                          axis.name, polarity));
}

Result<std::optional<ScaleDifference>> take_scale(motion::AxisConfig& axis, const DriveFacts& facts) {
  constexpr double kRounding = 1e-6;
  const auto reported = increments_per_revolution(facts);
  if (!reported || !(axis.unit_per_revolution > 0.0)) return std::nullopt;
  const double assumed = axis.increments_per_unit * axis.unit_per_revolution;
  if (std::abs(*reported - assumed) <= kRounding * assumed) return std::nullopt;
  if (!axis.scale_assumed) return ScaleDifference{assumed, *reported};
  if (*reported < 1.0 || *reported > kMaxIncrementsPerRevolution) {
    return fail(
        ErrorKind::kSetting,
        fmt::format(
            "axis {}: according to 6092h, 6091h and 608Fh a turn of its motor is {:.6g} increments, 1 to {:.0f} "
            "are expected: increments_per_revolution is needed",
            axis.name, *reported, kMaxIncrementsPerRevolution));
  }
  axis.increments_per_unit = *reported / axis.unit_per_revolution;
  return std::nullopt;
}

void take_range(motion::AxisConfig& axis, const DriveFacts& facts) {
  const auto lowest = facts.range_min.value_or(0);
  const auto highest = facts.range_max.value_or(0);
  if (lowest >= highest) return;
  axis.range_min = lowest;
  axis.range_max = highest;
}

/// Reads 604Ch, which is signed (CiA 402-2); a drive without it has the factor 1.
void take_velocity_count(motion::AxisConfig& axis, const DriveFacts& facts) {
  constexpr double kPerMinute = 1.0 / 60.0;
  double factor = 1.0;
  if (usable(facts.velocity_factor)) {
    factor = static_cast<double>(static_cast<std::int32_t>(facts.velocity_factor->numerator)) /
             static_cast<std::int32_t>(facts.velocity_factor->divisor);
  }
  axis.velocity_count =
      factor * (axis.velocity_by_factors ? 1.0 / axis.increments_per_unit : kPerMinute * axis.unit_per_revolution);
}

}  // namespace

std::optional<double> increments_per_revolution(const DriveFacts& facts) noexcept {
  if (const auto feed = usable(facts.feed)) return *feed / usable(facts.gear).value_or(1.0);
  return usable(facts.encoder);
}

DriveFacts ask_drive_facts(const ReadObject& read) {
  // An empty answer means that the object does not exist.
  const auto data = [&read](std::uint16_t index, std::uint8_t subindex) -> ObjectData {
    return read(index, subindex).value_or(std::vector<std::byte>{});
  };
  return facts_of(data, true).value_or(DriveFacts{});
}

std::vector<ecat_master::Result<DriveFacts>> read_drive_facts(ecat_master::Master& master, const LineConfig& config) {
  std::vector<std::optional<DriveInquiry>> inquiries;
  for (const auto& axis : config.axes) {
    auto& inquiry = inquiries.emplace_back();
    if (axis.is_virtual()) continue;
    const auto position = master.position_of(axis.slave).value_or(axis.slave);
    const auto& slave = master.slaves()[position];
    if (!slave.present || !slave.mailbox || !slave.info.description.mailbox.coe) continue;
    // The range of an axis with a modulo has been written at start-up.
    inquiry.emplace(master.mailboxes(), slave.info.ref.position, axis.drive, axis.range_min >= axis.range_max);
  }
  std::vector<ecat_master::Result<DriveFacts>> facts;
  for (const auto& inquiry : inquiries)
    facts.push_back(inquiry ? inquiry->finish() : ecat_master::Result<DriveFacts>{});
  return facts;
}

Result<std::optional<ScaleDifference>> take_drive_facts(motion::AxisConfig& axis, const DriveFacts& facts) {
  if (auto taken = take_modes(axis, facts); !taken) return tl::unexpected(taken.error());
  if (auto checked = check_polarity(axis, facts); !checked) return tl::unexpected(checked.error());
  take_range(axis, facts);
  auto difference = take_scale(axis, facts);
  if (difference) take_velocity_count(axis, facts);
  return difference;
}

}  // namespace driveline::runtime
