#include "driveline/ecat_master/bus/bus.hpp"

#include <vector>

namespace driveline::ecat_master {
namespace {

Error wkc_error(std::uint16_t position, std::uint16_t address, std::uint16_t received) {
  return {facts::WorkingCounter{.address = address, .received = received}, position};
}

Error named(Error error, std::uint16_t position) {
  error.slave = position;
  return error;
}

}  // namespace

Result<bool> Bus::try_read(SlaveRef slave, std::uint16_t address, std::span<std::byte> data) {
  Request request{wire::Command::kFprd, wire::DatagramAddress::physical(slave.station, address), data};
  if (auto done = exchange_.exchange({&request, 1}); !done) return tl::unexpected(named(done.error(), slave.position));
  return request.working_counter != 0;
}

Result<bool> Bus::try_write(SlaveRef slave, std::uint16_t address, std::span<const std::byte> data) {
  std::vector<std::byte> copy(data.begin(), data.end());
  Request request{wire::Command::kFpwr, wire::DatagramAddress::physical(slave.station, address), copy};
  if (auto done = exchange_.exchange({&request, 1}); !done) return tl::unexpected(named(done.error(), slave.position));
  return request.working_counter != 0;
}

Result<void> Bus::read(SlaveRef slave, std::uint16_t address, std::span<std::byte> data) {
  auto touched = try_read(slave, address, data);
  if (!touched) return tl::unexpected(touched.error());
  if (!*touched) return tl::unexpected(wkc_error(slave.position, address, 0));
  return {};
}

Result<void> Bus::write(SlaveRef slave, std::uint16_t address, std::span<const std::byte> data) {
  auto touched = try_write(slave, address, data);
  if (!touched) return tl::unexpected(touched.error());
  if (!*touched) return tl::unexpected(wkc_error(slave.position, address, 0));
  return {};
}

Result<void> Bus::write_all(std::span<RegisterWrite> writes) {
  std::vector<Request> requests;
  for (auto& write : writes) {
    requests.push_back({wire::Command::kFpwr, wire::DatagramAddress::physical(write.slave.station, write.address),
                        write.data, 0, false});
  }
  if (auto done = exchange_.exchange(requests); !done) return done;
  for (std::size_t i = 0; i < writes.size(); ++i) {
    if (requests[i].working_counter == 0) {
      return tl::unexpected(wkc_error(writes[i].slave.position, writes[i].address, 0));
    }
  }
  return {};
}

Result<std::uint16_t> Bus::broadcast_read(std::uint16_t address, std::span<std::byte> data) {
  Request request{wire::Command::kBrd, wire::DatagramAddress::physical(0, address), data};
  return exchange_.exchange({&request, 1}).map([&] { return request.working_counter; });
}

Result<std::uint16_t> Bus::broadcast_write(std::uint16_t address, std::span<const std::byte> data) {
  std::vector<std::byte> copy(data.begin(), data.end());
  Request request{wire::Command::kBwr, wire::DatagramAddress::physical(0, address), copy};
  return exchange_.exchange({&request, 1}).map([&] { return request.working_counter; });
}

Result<void> Bus::write_at_position(std::uint16_t position, std::uint16_t address, std::span<const std::byte> data) {
  std::vector<std::byte> copy(data.begin(), data.end());
  Request request{wire::Command::kApwr, wire::DatagramAddress::position(position, address), copy};
  if (auto done = exchange_.exchange({&request, 1}); !done) return tl::unexpected(named(done.error(), position));
  if (request.working_counter != 1) return tl::unexpected(wkc_error(position, address, request.working_counter));
  return {};
}

}  // namespace driveline::ecat_master
