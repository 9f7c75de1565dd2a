#pragma once

#include <cstdint>
#include <vector>

#include "driveline/motion/cia301/process_copy.hpp"
#include "driveline/motion/cycle/cycle_task.hpp"
#include "driveline/motion/cycle/cycle_trace.hpp"
#include "driveline/motion/cycle/flight_recorder.hpp"

namespace driveline::canopen {

/// Settings of a CanCycle.
struct CanCycleSettings {
  std::uint32_t sample_every = 1;         ///< samples of every n-th cycle are written to the rings
  motion::TaskSchedule* tasks = nullptr;  ///< tasks of the application, before and after the motion; must outlive it
  std::vector<motion::ProcessDataCopy> copies{};  ///< from node to node, after tasks and motion in every cycle
  motion::FlightRecorder* recorder = nullptr;     ///< must outlive the cycle
  motion::CycleTrace* trace = nullptr;            ///< of the counted cycles; must outlive the cycle. The part of the
                                                  ///< work that is done before the grid instant is shown behind the
                                                  ///< sending, as long as it took
};

}  // namespace driveline::canopen
