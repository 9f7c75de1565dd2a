#include <cstdio>
#include <memory>
#include <vector>

#include <driveline/ecat_master/master.hpp>
#include <driveline/slaves/line/simulated_line.hpp>
#include <driveline/slaves/msd/msd_drive.hpp>

#ifdef WITH_BRIDGE
#include <driveline/bridge/dds_publisher.hpp>
#endif

int main() {
#ifdef WITH_BRIDGE
  // A requested component is available with everything for linking; nothing is sent here.
  driveline::bridge::DdsConfig nothing;
  nothing.line_name = "";
  if (driveline::bridge::DdsPublisher::create(nothing)) return 1;
#endif
  using namespace driveline;
  rt::VirtualClock clock;
  std::vector<std::unique_ptr<slaves::Slave>> drives;
  drives.push_back(std::make_unique<slaves::Slave>(std::make_unique<slaves::msd::MsdDrive>()));
  slaves::SimulatedLine line(clock, std::move(drives));
  ecat_master::Master master(line, clock);
  if (const auto found = master.scan(); !found) {
    std::puts(ecat_master::describe(found.error()).c_str());
    return 1;
  }
  std::printf("%zu slave: %s\n", master.slaves().size(), master.slaves()[0].info.description.name.c_str());
  return master.slaves().size() == 1 ? 0 : 1;
}
