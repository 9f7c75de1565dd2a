#include "drift_compensation.hpp"

#include <algorithm>

#include "dc/mapping_fit.hpp"

namespace driveline::ecat_master::dc {
namespace {

using std::chrono::nanoseconds;

/// A frame full of drift datagrams.
class DriftFrame {
 public:
  DriftFrame(const LineClocks& clocks, unsigned datagrams) : data_(datagrams) {
    const auto address = wire::DatagramAddress::physical(clocks.station, wire::reg::kSystemTime.address);
    // The reference clock follows the master: it first receives the time, then is read.
    if (clocks.mode == FollowMode::kReferenceFollows)
      requests_.push_back({wire::Command::kFpwr, address, data_[0], 0, false});
    for (std::size_t i = requests_.size(); i < data_.size(); ++i)
      requests_.push_back({wire::Command::kFrmw, address, data_[i], 0, false});
  }

  /// Returns empty when the reference clock did not answer.
  [[nodiscard]] Result<std::optional<ClockSample>> exchange(DatagramExchange& exchange, const ClockMapping& mapping) {
    ClockSample sample;
    sample.sent = exchange.now();
    const auto expected = mapping.at(sample.sent);
    // If the reference clock does not answer, the other clocks receive the data of the datagram: the expected time, not
    // zero.
    for (auto& data : data_) bytes::store_le<std::uint32_t>(data, static_cast<std::uint32_t>(expected));
    if (auto done = exchange.exchange(requests_); !done) return tl::unexpected(done.error());
    if (requests_.back().working_counter == 0) return std::nullopt;
    sample.ahead = difference(extend(bytes::load_le<std::uint32_t>(data_.back()), expected), expected);
    return sample;
  }

 private:
  std::vector<std::array<std::byte, 4>> data_;
  std::vector<Request> requests_;
};

/// The loops learn slowly, and reading the differences costs a frame: do it only after this many frames.
constexpr unsigned kFramesPerLook = 40;

class DriftCompensation {
 public:
  DriftCompensation(Bus& bus, const ClockPlan& plan, LineClocks& clocks, unsigned per_frame)
      : bus_(bus), plan_(plan), clocks_(clocks), frame_(clocks, per_frame) {}

  [[nodiscard]] Result<void> send(unsigned frames) {
    for (unsigned i = 0; i < frames; ++i) {
      follow_time_source();
      const auto sample = frame_.exchange(bus_.exchange(), clocks_.mapping);
      ++clocks_.drift_frames;
      if (!sample) {
        // A frame lost despite all repetitions costs one sample; when too many are lost, the line has failed.
        ++clocks_.drift_frames_lost;
        const bool gone = clocks_.drift_frames_lost > 3 + clocks_.drift_frames / 2;
        if (gone || sample.error().is<facts::LinkDown>()) return tl::unexpected(sample.error());
      } else if (*sample) {
        fit_.add(**sample);
      }
      bus_.exchange().pause(plan_.drift_pause);
    }
    return {};
  }

  void finish() {
    if (clocks_.mode == FollowMode::kMasterFollows) fit_.apply(clocks_.mapping);
  }

 private:
  /// With an external time source the reference clock receives that time from the start.
  void follow_time_source() {
    if (clocks_.time == nullptr || clocks_.mode != FollowMode::kReferenceFollows) return;
    const auto both = read_both(*clocks_.time, [this] { return bus_.exchange().now(); });
    clocks_.mapping = {both.local, static_cast<std::uint64_t>(both.external.count()), 0.0};
  }

  Bus& bus_;
  const ClockPlan& plan_;
  LineClocks& clocks_;
  DriftFrame frame_;
  MappingFit fit_;
};

/// Whether every clock behind the reference is within the window.
Result<bool> settled(Bus& bus, std::span<const SlaveRef> slaves, std::span<const ClockFeatures> features,
                     const LineClocks& clocks, nanoseconds window) {
  const auto differences = read_differences(bus, slaves, features);
  if (!differences) return tl::unexpected(differences.error());
  for (std::size_t i = 0; i < slaves.size(); ++i) {
    if (clocks.slaves[i].follows && std::chrono::abs((*differences)[i].value_or(nanoseconds{0})) > window) return false;
  }
  return true;
}

}  // namespace

Result<void> compensate_drift(Bus& bus, std::span<const SlaveRef> slaves, std::span<const ClockFeatures> features,
                              const ClockPlan& plan, LineClocks& clocks) {
  const auto per_frame = std::clamp(plan.drift_datagrams_per_frame, 2U, 80U);
  DriftCompensation compensation(bus, plan, clocks, per_frame);
  if (auto done = compensation.send((plan.drift_datagrams + per_frame - 1) / per_frame); !done) return done;
  const auto limit = bus.exchange().now() + plan.drift_limit;
  while (bus.exchange().now() < limit) {
    const auto near = settled(bus, slaves, features, clocks, plan.drift_window);
    if (!near) return tl::unexpected(near.error());
    if (*near) break;
    if (auto done = compensation.send(kFramesPerLook); !done) return done;
  }
  compensation.finish();
  return {};
}

}  // namespace driveline::ecat_master::dc
