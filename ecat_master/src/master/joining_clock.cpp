// Clocks of slaves that join a running line or move to another position.
#include <algorithm>
#include <array>

#include "driveline/ecat_master/dc/sync_objects.hpp"
#include "driveline/ecat_master/master.hpp"

namespace driveline::ecat_master {

/// All slaves in line order. Slaves without a station address of this master get a temporary one, so that their receive
/// times can be read.
Result<std::vector<SlaveRef>> Master::wire_order() {
  // Above those of any line (kMaxSlaves), as in identify_newcomers().
  constexpr std::uint16_t kTemporary = 0x3000;
  std::array<std::byte, 1> type{};
  const auto count = bus_.broadcast_read(wire::reg::kType.address, type);
  if (!count) return tl::unexpected(count.error());
  std::vector<std::array<std::byte, 2>> stations(*count);
  std::vector<Request> requests;
  for (std::uint16_t i = 0; i < *count; ++i) {
    requests.push_back(
        {wire::Command::kAprd, wire::DatagramAddress::position(i, wire::reg::kStationAddress.address), stations[i]});
  }
  if (auto done = exchange_.exchange(requests); !done) return tl::unexpected(done.error());
  std::vector<SlaveRef> order;
  for (std::uint16_t i = 0; i < *count; ++i) {
    auto station = bytes::load_le<std::uint16_t>(stations[i]);
    const bool ours =
        std::any_of(refs_.begin(), refs_.end(), [station](const SlaveRef& ref) { return ref.station == station; });
    if (!ours) {
      station = static_cast<std::uint16_t>(kTemporary + i);
      const auto address = bytes::to_le_bytes(station);
      if (auto done = bus_.write_at_position(i, wire::reg::kStationAddress.address, address); !done)
        return tl::unexpected(done.error());
    }
    order.push_back({i, station});
  }
  return order;
}

/// Restores the clock of a slave that is being configured while the others cycle.
Result<void> Master::restore_clock(std::size_t slave) {
  if (!watch_) return {};
  const auto number = static_cast<std::uint16_t>(slave);
  // A slave with a fixed position on the line keeps its delay.
  if (!slaves_[slave].plan.hot_connect) {
    if (auto done = tell_sync_type(slave); !done) return done;
    return watch_->restore(number);
  }
  if (slave >= clock_plan_->slaves.size()) clock_plan_->slaves.resize(slaves_.size());
  auto& plan = clock_plan_->slaves[slave];
  const auto plan_number = comparison_.plan_of_slave[slave];
  if (clock_plan_->joining && plan_number) {
    auto joining = clock_plan_->joining(*plan_number, slaves_[slave].info.description);
    if (!joining) {
      auto error = joining.error();
      error.slave = number;
      return tl::unexpected(error);
    }
    plan = *joining;
  }
  if (auto done = tell_sync_type(slave); !done) return done;
  const auto order = wire_order();
  if (!order) return tl::unexpected(order.error());
  return watch_->join(number, plan, *order);
}

Result<void> Master::remeasure_delays() {
  if (!watch_) return {};
  const auto order = wire_order();
  if (!order) return tl::unexpected(order.error());
  return watch_->remeasure_delays(*order);
}

}  // namespace driveline::ecat_master
