// Locates a bad cable: the master reads the error counters of all slaves and computes its position.

#include <cstdio>
#include <memory>

#include "driveline/ecat_master/diagnosis/diagnosis.hpp"
#include "driveline/ecat_master/master.hpp"
#include "driveline/slaves/line/simulated_line.hpp"
#include "driveline/slaves/msd/msd_drive.hpp"

using namespace driveline;

int main() {
  rt::VirtualClock clock;
  std::vector<std::unique_ptr<slaves::Slave>> slaves;
  for (int i = 0; i < 4; ++i)
    slaves.push_back(std::make_unique<slaves::Slave>(std::make_unique<slaves::msd::MsdDrive>()));
  slaves::SimulatedLine line(clock, std::move(slaves));

  ecat_master::Master master(line, clock);
  if (const auto found = master.scan(); !found) {
    std::puts(ecat_master::describe(found.error()).c_str());
    return 1;
  }

  // The cable before slave 2 damages the next three frames. They are repeated, so operation continues.
  slaves::Fault fault;
  fault.kind = slaves::FaultKind::kDamage;
  fault.slave = 2;
  fault.port = 0;
  fault.count = 3;
  if (!line.inject(fault)) return 1;
  if (const auto done = master.enter_pre_op(); !done) {
    std::puts(ecat_master::describe(done.error()).c_str());
    return 1;
  }

  const auto diagnosis = ecat_master::diagnose(master, nullptr, nullptr);
  if (!diagnosis) {
    std::puts(ecat_master::describe(diagnosis.error()).c_str());
    return 1;
  }
  std::fputs(ecat_master::to_text(*diagnosis).c_str(), stdout);
  using Kind = ecat_master::FaultPlace::Kind;
  const bool located = diagnosis->places.size() == 1 && diagnosis->places[0].kind == Kind::kDamagedFrames &&
                       diagnosis->places[0].slave == 2 && diagnosis->places[0].port == 0;
  return located && master.shut_down() ? 0 : 1;
}
