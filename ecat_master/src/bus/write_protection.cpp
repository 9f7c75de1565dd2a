#include "bus/write_protection.hpp"

namespace driveline::ecat_master {

Result<void> lift_write_protection(Bus& bus, std::optional<SlaveRef> slave) {
  const auto write_zeros = [&bus, &slave](auto... registers) {
    std::array<std::array<std::byte, 1>, sizeof...(registers)> data{};
    std::vector<Request> requests;
    for (const auto& reg : {registers...}) {
      const auto address = wire::DatagramAddress::physical(slave ? slave->station : 0, reg.address);
      const auto command = slave ? wire::Command::kFpwr : wire::Command::kBwr;
      requests.push_back({command, address, data[requests.size()], 0, false});
    }
    return bus.exchange().exchange(requests);
  };
  // An enable register takes effect within the frame in which it is written. Each protection covers the registers of
  // the other, so both must be enabled to end either; three datagrams fit into any byte budget of the cycle, four do
  // not.
  if (auto done =
          write_zeros(wire::reg::kEscWriteEnable, wire::reg::kRegisterWriteEnable, wire::reg::kEscWriteProtection);
      !done) {
    return done;
  }
  return write_zeros(wire::reg::kRegisterWriteEnable, wire::reg::kRegisterWriteProtection);
}

}  // namespace driveline::ecat_master
