#pragma once

#include <array>
#include <span>
#include <vector>

#include "driveline/ecat_master/bus/bus.hpp"
#include "driveline/ecat_master/dc/propagation_delay.hpp"
#include "driveline/ecat_master/discovery/topology.hpp"

/// Reading the clock registers of a line. Not real-time safe; errors are those of the bus unless stated otherwise.
namespace driveline::ecat_master::dc {

/// Clock features of a slave from register 0x0008 (ETG.1000.4 Table 31: bit 2 distributed clocks, bit 3 64 bits).
struct ClockFeatures {
  bool present = false;  ///< the slave has a DC unit
  bool wide = false;     ///< the clock has 64 bits, else 32
};

/// Reads the features of all slaves, by position; a slave that does not answer counts as having no clock.
[[nodiscard]] Result<std::vector<ClockFeatures>> read_clock_features(Bus& bus, std::span<const SlaveRef> slaves);

/// Times at which the same frame passed, on the slave's own clock.
struct ReceiveTimes {
  std::array<std::uint32_t, kSlavePorts> ports{};  ///< registers 0x0900..0x090F
  std::uint64_t processing_unit = 0;               ///< register 0x0918
};

/// Latches the receive times of a single frame in all slaves and reads them; slaves without a clock have zeros. Error:
/// NoReceiveTimes when a slave with a clock does not answer.
[[nodiscard]] Result<std::vector<ReceiveTimes>> latch_receive_times(Bus& bus, std::span<const SlaveRef> slaves,
                                                                    std::span<const ClockFeatures> features);

/// Measures the propagation delays, averaged over `rounds` frames. A closed ring is opened at its far end during the
/// measurement, because the frame must return on the same path, and closed again; its last slave also closes it
/// automatically after a second. `processing_extra_ns`: DelayNode::processing_extra_ns by position; 0 for slaves beyond
/// its end. Errors: ContradictingDelays when no round is consistent, NoReceiveTimes, those of the bus.
[[nodiscard]] Result<std::vector<PropagationDelay>> measure_delays(Bus& bus, std::span<const SlaveRef> slaves,
                                                                   std::span<const ClockFeatures> features,
                                                                   const Topology& topology, unsigned rounds,
                                                                   std::span<const double> processing_extra_ns);

/// Reads register 0x092C of all slaves with a clock: the filtered lead of each clock over the reference clock. Empty
/// for slaves without a clock or without an answer.
[[nodiscard]] Result<std::vector<std::optional<std::chrono::nanoseconds>>> read_differences(
    Bus& bus, std::span<const SlaveRef> slaves, std::span<const ClockFeatures> features);

}  // namespace driveline::ecat_master::dc
