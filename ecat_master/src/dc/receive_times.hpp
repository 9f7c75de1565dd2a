#pragma once

#include <array>
#include <span>
#include <vector>

#include "driveline/ecat_master/bus/bus.hpp"
#include "driveline/ecat_master/dc/propagation_delay.hpp"
#include "driveline/ecat_master/discovery/topology.hpp"

/// Reading the clock registers of a line. Not real-time safe; errors are those of the bus unless said otherwise.
namespace driveline::ecat_master::dc {

/// Register 0x0008 of one slave, as far as clocks go (ETG.1000.4 Table 31: bit 2 distributed clocks, bit 3 64 bits).
struct ClockFeatures {
  bool present = false;  ///< it has a DC unit
  bool wide = false;     ///< of 64 bits, else of 32
};

/// Of all slaves, by position; a slave that does not answer counts as one without clock.
[[nodiscard]] Result<std::vector<ClockFeatures>> read_clock_features(Bus& bus, std::span<const SlaveRef> slaves);

/// When the same frame came by, on the slave's own clock.
struct ReceiveTimes {
  std::array<std::uint32_t, kSlavePorts> ports{};  ///< registers 0x0900..0x090F
  std::uint64_t processing_unit = 0;               ///< register 0x0918
};

/// Latches the receive times of one frame in all slaves and reads them; slaves without clock stay zero.
/// Error: NoReceiveTimes when a slave with clock does not answer.
[[nodiscard]] Result<std::vector<ReceiveTimes>> latch_receive_times(Bus& bus, std::span<const SlaveRef> slaves,
                                                                    std::span<const ClockFeatures> features);

/// Propagation delays, averaged over `rounds` frames. A closed ring is opened at its far end meanwhile: the frame must
/// come back the way it went, and closed again, which its last slave does by itself after a second.
/// `processing_extra_ns`: DelayNode::processing_extra_ns by position; 0 for slaves beyond its end. Errors:
/// ContradictingDelays when no round is consistent, NoReceiveTimes, those of the bus.
[[nodiscard]] Result<std::vector<PropagationDelay>> measure_delays(Bus& bus, std::span<const SlaveRef> slaves,
                                                                   std::span<const ClockFeatures> features,
                                                                   const Topology& topology, unsigned rounds,
                                                                   std::span<const double> processing_extra_ns);

/// Register 0x092C of all slaves with a clock: how far each is ahead of the reference clock, as its own filter sees it.
/// Slaves without clock, or without answer, are left out (nothing at their position).
[[nodiscard]] Result<std::vector<std::optional<std::chrono::nanoseconds>>> read_differences(
    Bus& bus, std::span<const SlaveRef> slaves, std::span<const ClockFeatures> features);

}  // namespace driveline::ecat_master::dc
