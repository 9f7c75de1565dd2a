// Objects of a drive over CoE: reads a value, writes one, reads three at the same time, and shows a refusal.

#include <cstdio>
#include <memory>

#include "driveline/ecat_master/master.hpp"
#include "driveline/slaves/line/simulated_line.hpp"
#include "driveline/slaves/msd/msd_drive.hpp"

using namespace driveline;

int main() {
  rt::VirtualClock clock;
  std::vector<std::unique_ptr<slaves::Slave>> slaves;
  for (std::uint32_t i = 0; i < 3; ++i) {
    slaves::msd::MsdParameters parameters;
    parameters.serial_number = 1001 + i;
    slaves.push_back(std::make_unique<slaves::Slave>(std::make_unique<slaves::msd::MsdDrive>(parameters)));
  }
  slaves::SimulatedLine line(clock, std::move(slaves));

  ecat_master::Master master(line, clock);
  auto ready = master.scan();
  if (ready) ready = master.enter_pre_op();
  if (!ready) {
    std::puts(ecat_master::describe(ready.error()).c_str());
    return 1;
  }

  // Blocking calls. The value is typed, and its size is checked.
  ecat_master::CoeClient first(*master.mailbox(0));
  const auto status_word = first.upload_as<std::uint16_t>(0x6041, 0);
  const auto written = first.download_as<std::int8_t>(0x6060, 0, 8);  // mode of operation: cyclic synchronous position
  if (!status_word || !written) return 1;
  std::printf("slave 0: status word 0x%04X\n", *status_word);

  // Transfers with several slaves run in parallel: start all, then fetch the results.
  std::vector<ecat_master::SdoFuture> serial_numbers;
  for (std::uint16_t i = 0; i < 3; ++i) {
    serial_numbers.push_back(ecat_master::CoeClient(*master.mailbox(i)).start_upload({0x1018, 4}));
  }
  for (const auto& serial_number : serial_numbers) {
    const auto& bytes = serial_number.get();
    if (!bytes) return 1;
    std::printf("serial number %u\n", bytes::load_le<std::uint32_t>(*bytes));
  }

  // Errors are values with facts; describe() makes a sentence of them.
  const auto refused = first.download_as<std::uint16_t>(0x6041, 0, 0);
  if (refused) return 1;
  std::puts(ecat_master::describe(refused.error()).c_str());
  return refused.error().is<ecat_master::facts::SdoAbort>() && master.shut_down() ? 0 : 1;
}
