// Lists the slaves of a line. Without an argument three simulated drives, otherwise the line on this network interface:
//   01_scan eth1        (as root, or with CAP_NET_RAW)

#include <cstdio>
#include <memory>

#include "driveline/ecat_master/master.hpp"
#include "driveline/port/raw_socket_port.hpp"
#include "driveline/slaves/line/simulated_line.hpp"
#include "driveline/slaves/msd/msd_drive.hpp"

using namespace driveline;

namespace {

std::unique_ptr<port::Port> simulated_line(rt::Clock& clock) {
  std::vector<std::unique_ptr<slaves::Slave>> slaves;
  for (std::uint32_t i = 0; i < 3; ++i) {
    slaves::msd::MsdParameters parameters;
    parameters.serial_number = 1001 + i;
    slaves.push_back(std::make_unique<slaves::Slave>(std::make_unique<slaves::msd::MsdDrive>(parameters)));
  }
  return std::make_unique<slaves::SimulatedLine>(clock, std::move(slaves));
}

}  // namespace

int main(int argc, char** argv) {
  rt::MonotonicClock clock;
  std::unique_ptr<port::Port> line;
  if (argc > 1) {
    auto port = port::RawSocketPort::open({argv[1]}, clock);
    if (!port) {
      std::puts(port::describe(port.error()).c_str());
      return 1;
    }
    line = std::move(*port);
  } else {
    line = simulated_line(clock);
  }

  ecat_master::Master master(*line, clock);
  if (const auto found = master.scan(); !found) {
    std::puts(ecat_master::describe(found.error()).c_str());
    return 1;
  }
  std::vector<std::string> names;
  for (const auto& slave : master.slaves()) {
    const auto& device = slave.info.description;
    names.push_back(device.name + ", serial number " + std::to_string(device.serial_number));
  }
  std::fputs(ecat_master::to_tree_text(master.topology(), names).c_str(), stdout);
  return 0;
}
