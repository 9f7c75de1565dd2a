#include "driveline/ecat_master/discovery/device_identification.hpp"

#include <algorithm>

#include "bus/poll_timeout.hpp"
#include "driveline/wire/al.hpp"

namespace driveline::ecat_master {
namespace {

constexpr std::size_t kReportBytes = 6;  // AL status 0x0130 .. AL status code 0x0135
constexpr auto kPollInterval = std::chrono::microseconds{500};

using Reports = std::vector<std::array<std::byte, kReportBytes>>;

Result<std::vector<bool>> read_reports(Bus& bus, std::span<const SlaveRef> slaves, Reports& data) {
  std::vector<Request> requests;
  data.assign(slaves.size(), {});
  for (std::size_t i = 0; i < slaves.size(); ++i) {
    requests.push_back({wire::Command::kFprd,
                        wire::DatagramAddress::physical(slaves[i].station, wire::reg::kAlStatus.address), data[i], 0,
                        false});
  }
  if (auto done = bus.exchange().exchange(requests); !done) return tl::unexpected(done.error());
  std::vector<bool> answered;
  for (const auto& request : requests) answered.push_back(request.working_counter == 1);
  return answered;
}

Result<void> write_requests(Bus& bus, std::span<const SlaveRef> slaves, const std::vector<wire::AlStatus>& before,
                            const std::vector<bool>& asked, bool request_id) {
  std::vector<Request> requests;
  std::vector<std::array<std::byte, 2>> data(slaves.size());
  for (std::size_t i = 0; i < slaves.size(); ++i) {
    if (!asked[i]) continue;
    data[i] = bytes::to_le_bytes(wire::AlControl{before[i].state, false, request_id}.raw());
    requests.push_back({wire::Command::kFpwr,
                        wire::DatagramAddress::physical(slaves[i].station, wire::reg::kAlControl.address), data[i], 0,
                        false});
  }
  return requests.empty() ? Result<void>{} : bus.exchange().exchange(requests);
}

}  // namespace

Result<std::vector<std::optional<std::uint16_t>>> read_device_ids(Bus& bus, std::span<const SlaveRef> slaves,
                                                                  std::chrono::nanoseconds timeout) {
  std::vector<std::optional<std::uint16_t>> ids(slaves.size());
  Reports data;
  auto asked = read_reports(bus, slaves, data);
  if (!asked) return tl::unexpected(asked.error());
  std::vector<wire::AlStatus> before;
  for (std::size_t i = 0; i < slaves.size(); ++i) {
    before.push_back(wire::AlStatus::from_raw(bytes::load_le<std::uint16_t>(data[i])));
    if (before[i].error) (*asked)[i] = false;
  }
  if (auto done = write_requests(bus, slaves, before, *asked, true); !done) return tl::unexpected(done.error());
  PollTimeout poll_timeout(bus.exchange().now(), timeout);
  for (;;) {
    const auto answered = read_reports(bus, slaves, data);
    if (!answered) return tl::unexpected(answered.error());
    bool all = true;
    for (std::size_t i = 0; i < slaves.size(); ++i) {
      if (!(*asked)[i] || ids[i]) continue;
      const std::span<const std::byte> report = data[i];
      const auto status = wire::AlStatus::from_raw(bytes::load_le<std::uint16_t>(report));
      if ((*answered)[i] && status.id_loaded && !status.error) {
        ids[i] = bytes::load_le<std::uint16_t>(report.subspan(4));
      } else {
        all = false;
      }
    }
    if (all || poll_timeout.over(bus.exchange().now())) break;
    bus.exchange().pause(kPollInterval);
  }
  if (auto done = write_requests(bus, slaves, before, *asked, false); !done) return tl::unexpected(done.error());
  return ids;
}

}  // namespace driveline::ecat_master
