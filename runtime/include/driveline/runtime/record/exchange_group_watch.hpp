#pragma once

#include <vector>

#include "driveline/ecat_master/cyclic/cyclic_core.hpp"
#include "driveline/runtime/config/line_config.hpp"
#include "driveline/runtime/event/event.hpp"

namespace driveline::runtime {

/// Watches the groups of the process image while the cycle runs: reports that the outputs of a group were zeroed, and
/// enables them again as soon as its process data are complete.
class ExchangeGroupWatch {
 public:
  /// `config` must outlive the watch.
  explicit ExchangeGroupWatch(const ProcessDataConfig& config);

  /// Call every few milliseconds. Returns the changes: events::ExchangeGroupZeroed, events::ExchangeGroupReleased.
  [[nodiscard]] std::vector<EventFacts> poll(ecat_master::CyclicCore& core);
  /// Returns how often the outputs of a group were zeroed so far.
  [[nodiscard]] std::uint64_t zeroings(std::size_t group) const noexcept {
    return group < zeroings_.size() ? zeroings_[group] : 0;
  }

 private:
  const ProcessDataConfig& config_;
  std::vector<char> zeroed_;
  std::vector<std::uint64_t> zeroings_;
};

}  // namespace driveline::runtime
