#pragma once

#include "dc/receive_times.hpp"
#include "driveline/ecat_master/dc/line_clocks.hpp"

namespace driveline::ecat_master::dc {

/// Synchronises the clocks of a line and starts the SYNC signals, in the order that the hardware requires (ETG.1000.4
/// 6.7, ESC data sheet I 9.1):
///
/// 1. checks the plan against the rules and the present clocks;
/// 2. switches off signals of an earlier run;
/// 3. measures the propagation delays (using the topology, averaged) and writes them (0x0928);
/// 4. writes the offsets (0x0920), so that all clocks show the master's time plus ClockPlan::epoch, 64 or 32 bits of
///    it;
/// 5. restarts the control loops (0x0930) and sends them some ten thousand times of the reference clock, so that the
///    clocks run at the same frequency, and continues until all differences are small; a lost frame costs one sample;
/// 6. computes the frequency of the reference clock relative to the master's clock from the same frames;
/// 7. writes cycle times (0x09A0, 0x09A4) and start time (0x0990) of all signals, then activates all (0x0981); the
///    start is at a multiple of the common cycle, and if it has become too near in the meantime, the step is repeated
///    with a later start.
///
/// Preconditions, all checked: station addresses are set, `slaves` are all slaves of the line in line order, `topology`
/// belongs to them; the slaves are in PREOP (SYNC signals must be present on the way to SAFEOP); no cycle runs. The
/// cyclic exchange should start soon afterwards: without it the clocks drift apart by what the loops have not learned.
///
/// Errors: those of clock_facts.hpp, those of the bus. After an error no SYNC signal is active, and the call may be
/// repeated. Takes 150 ms to 1.2 s, depending on the clocks, plus 1 ms per slave. Not real-time safe.
[[nodiscard]] Result<LineClocks> bring_up_clocks(Bus& bus, std::span<const SlaveRef> slaves, const Topology& topology,
                                                 const ClockPlan& plan);

/// Switches off the SYNC signals of all slaves, which would continue in every state. Not real-time safe.
[[nodiscard]] Result<void> stop_signals(Bus& bus);

/// Step 1 without the bus: every rule of the plan that does not depend on the slaves found.
[[nodiscard]] Result<void> check_plan(const ClockPlan& plan);

/// The reference clock of `plan`: the planned slave, or else the first slave with a clock that has SYNC signals,
/// because the clock of a slave before it (a coupler, a terminal) need not be accurate, or work at all; the first slave
/// with a clock when none has signals, or slaves may join (ClockPlan::may_join). Error: there is none, the planned
/// slave has no clock, or frames pass a slave that needs the time before it.
[[nodiscard]] Result<std::uint16_t> choose_reference(const ClockPlan& plan, std::span<const ClockFeatures> features);

}  // namespace driveline::ecat_master::dc
