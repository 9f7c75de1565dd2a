#pragma once

#include "dc/receive_times.hpp"
#include "driveline/ecat_master/dc/line_clocks.hpp"

namespace driveline::ecat_master::dc {

/// Brings the clocks of a line together and starts the SYNC signals, in the order the hardware asks for
/// (ETG.1000.4 6.7, ESC data sheet I 9.1):
///
///  1. the plan is checked against the rules and the clocks that are there;
///  2. signals of an earlier run are switched off;
///  3. propagation delays are measured (topology aware, averaged) and written (0x0928);
///  4. offsets are written (0x0920), so that all clocks show the master's time plus ClockPlan::epoch, 64 or 32 bits of
///  it;
///  5. the control loops are started anew (0x0930) and given some ten thousand times of the reference clock, so that
///  the
///     clocks run at the same speed, and then on until all are near; a frame that gets lost meanwhile costs one sample;
///  6. the speed of the reference clock against the master's is taken from the same frames;
///  7. cycle times (0x09A0, 0x09A4) and start time (0x0990) of all signals are written, then all are activated
///  (0x0981);
///     the start lies on a multiple of the common cycle, and if it has come too near meanwhile all is done once more
///     with a later one.
///
/// Preconditions, all checked: station addresses are set, `slaves` are in line order and all of the line, `topology` is
/// theirs; the slaves are in PREOP (SYNC signals must be there on the way to SAFEOP); no cycle runs. Afterwards the
/// cyclic exchange should follow soon: without it the clocks drift apart by what the loops have not learned.
///
/// Errors: those of clock_facts.hpp, those of the bus. After an error no SYNC signal is active, and the call may
/// be repeated. Takes 150 ms to 1.2 s, as the clocks need, plus 1 ms per slave. Not real-time safe.
[[nodiscard]] Result<LineClocks> bring_up_clocks(Bus& bus, std::span<const SlaveRef> slaves, const Topology& topology,
                                                 const ClockPlan& plan);

/// Switches the SYNC signals of all slaves off: they go on in every state otherwise. Not real-time safe.
[[nodiscard]] Result<void> stop_signals(Bus& bus);

/// Step 1 alone, without the bus: every rule of the plan that does not depend on the slaves found.
[[nodiscard]] Result<void> check_plan(const ClockPlan& plan);

/// The reference clock of `plan`: the chosen slave or the first with a clock. Error: when there is none, the
/// chosen one has none, or a slave that needs the time is passed by frames before it.
[[nodiscard]] Result<std::uint16_t> choose_reference(const ClockPlan& plan, std::span<const ClockFeatures> features);

}  // namespace driveline::ecat_master::dc
