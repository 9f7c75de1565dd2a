#include "driveline/ecat_master/state_machine.hpp"

#include <algorithm>
#include <array>

namespace driveline::ecat_master {
namespace {

using std::chrono::microseconds;

/// AL status 0x0130 .. AL status code 0x0135 in one read.
constexpr std::size_t kReportBytes = 6;
constexpr auto kPollInterval = microseconds{500};

Error state_error(ErrorKind kind, SlaveRef slave, wire::AlState target, const AlReport& report,
                  std::chrono::nanoseconds timeout) {
  Error error;
  error.kind = kind;
  error.slave = slave.position;
  error.requested = target;
  error.actual = report.status.state;
  error.code = static_cast<std::uint32_t>(report.code);
  if (kind == ErrorKind::kStateTimeout) {
    error.extra = static_cast<std::uint32_t>(std::chrono::duration_cast<microseconds>(timeout).count());
  }
  return error;
}

Result<void> write_al_control(Bus& bus, std::span<const SlaveRef> slaves, std::span<const std::uint16_t> values) {
  std::vector<std::array<std::byte, 2>> data(slaves.size());
  std::vector<Request> requests;
  for (std::size_t i = 0; i < slaves.size(); ++i) {
    data[i] = wire::to_le_bytes(values[i]);
    requests.push_back({wire::Command::kFpwr,
                        wire::DatagramAddress::physical(slaves[i].station, wire::reg::kAlControl.address), data[i]});
  }
  return bus.exchange().exchange(requests);
}

/// Sends reads of AL status and code, one per slave, and decodes the answers.
template <typename PositionOf>
Result<std::vector<AlReport>> collect_reports(Bus& bus, std::span<Request> requests, PositionOf position_of) {
  if (auto done = bus.exchange().exchange(requests); !done) return tl::unexpected(done.error());
  std::vector<AlReport> reports;
  for (std::size_t i = 0; i < requests.size(); ++i) {
    if (requests[i].working_counter != 1) {
      Error error;
      error.kind = ErrorKind::kWorkingCounter;
      error.slave = position_of(i);
      error.address = wire::reg::kAlStatus.address;
      error.expected = 1;
      error.received = requests[i].working_counter;
      return tl::unexpected(error);
    }
    const std::span<const std::byte> bytes = requests[i].data;
    reports.push_back({wire::AlStatus::from_raw(wire::load_le<std::uint16_t>(bytes)),
                       static_cast<wire::AlStatusCode>(wire::load_le<std::uint16_t>(bytes.subspan(4)))});
  }
  return reports;
}

/// Error indications are acknowledged by repeating the present state with the acknowledge bit (ETG.1000.6 5.3.1). Waits
/// until they are gone, or the old error would pass for an answer to the next request.
Result<void> acknowledge_errors(Bus& bus, std::span<const SlaveRef> slaves, wire::AlState target,
                                std::chrono::nanoseconds timeout) {
  const auto deadline = bus.exchange().now() + timeout;
  for (unsigned pass = 0;; ++pass) {
    const auto reports = read_al_status(bus, slaves);
    if (!reports) return tl::unexpected(reports.error());
    std::vector<SlaveRef> faulty;
    std::vector<std::uint16_t> values;
    std::size_t first = 0;
    for (std::size_t i = 0; i < slaves.size(); ++i) {
      const auto& [status, code] = (*reports)[i];
      if (!status.error) continue;
      if (faulty.empty()) first = i;
      // The controller of a slave without application copies AL control, acknowledge bit included, into AL status (ESC
      // data sheet I, device emulation): what looks like an error without code goes away when the bit is not written.
      const bool copied = pass > 0 && code == wire::AlStatusCode::kNoError;
      faulty.push_back(slaves[i]);
      values.push_back(wire::AlControl{status.state, !copied, false}.raw());
    }
    if (faulty.empty()) return {};
    if (bus.exchange().now() >= deadline) {
      return tl::unexpected(state_error(ErrorKind::kStateRefused, slaves[first], target, (*reports)[first], timeout));
    }
    if (pass > 1) {
      bus.exchange().pause(kPollInterval);
    } else if (auto done = write_al_control(bus, faulty, values); !done) {
      return done;
    }
  }
}

}  // namespace

Result<std::vector<AlReport>> read_al_status(Bus& bus, std::span<const SlaveRef> slaves) {
  std::vector<Request> requests;
  std::vector<std::array<std::byte, kReportBytes>> data(slaves.size());
  for (std::size_t i = 0; i < slaves.size(); ++i) {
    requests.push_back({wire::Command::kFprd,
                        wire::DatagramAddress::physical(slaves[i].station, wire::reg::kAlStatus.address), data[i]});
  }
  return collect_reports(bus, requests, [&](std::size_t i) { return slaves[i].position; });
}

Result<std::vector<AlReport>> peek_states(Bus& bus) {
  std::array<std::byte, 1> type{};
  const auto count = bus.broadcast_read(wire::reg::kType.address, type);
  if (!count) return tl::unexpected(count.error());
  if (*count == 0) {
    Error error;
    error.kind = ErrorKind::kNoSlaves;
    return tl::unexpected(error);
  }
  std::vector<Request> requests;
  std::vector<std::array<std::byte, kReportBytes>> data(*count);
  for (std::uint16_t i = 0; i < *count; ++i) {
    requests.push_back(
        {wire::Command::kAprd, wire::DatagramAddress::position(i, wire::reg::kAlStatus.address), data[i]});
  }
  return collect_reports(bus, requests, [](std::size_t i) { return static_cast<std::uint16_t>(i); });
}

Result<void> change_state(Bus& bus, std::span<const SlaveRef> slaves, wire::AlState target,
                          std::chrono::nanoseconds timeout) {
  if (slaves.empty()) return {};
  if (auto done = acknowledge_errors(bus, slaves, target, timeout); !done) return done;
  const std::vector<std::uint16_t> values(slaves.size(), wire::AlControl{target, false, false}.raw());
  if (auto done = write_al_control(bus, slaves, values); !done) return done;
  const auto deadline = bus.exchange().now() + timeout;
  for (;;) {
    const auto reports = read_al_status(bus, slaves);
    if (!reports) return tl::unexpected(reports.error());
    std::size_t arrived = 0;
    std::size_t late = slaves.size();
    for (std::size_t i = 0; i < slaves.size(); ++i) {
      const auto& report = (*reports)[i];
      if (report.status.error) {
        return tl::unexpected(state_error(ErrorKind::kStateRefused, slaves[i], target, report, timeout));
      }
      if (report.status.state == target) {
        ++arrived;
      } else {
        late = std::min(late, i);
      }
    }
    if (arrived == slaves.size()) return {};
    if (bus.exchange().now() >= deadline) {
      return tl::unexpected(state_error(ErrorKind::kStateTimeout, slaves[late], target, (*reports)[late], timeout));
    }
    bus.exchange().pause(kPollInterval);
  }
}

Result<void> lower_state(Bus& bus, std::span<const SlaveRef> slaves, wire::AlState target,
                         std::chrono::nanoseconds timeout) {
  Result<void> first{};
  std::vector<SlaveRef> above;
  for (const auto& slave : slaves) {
    const auto raw = bus.read(slave, wire::reg::kAlStatus);
    if (raw) {
      if (wire::AlStatus::from_raw(*raw).state > target) above.push_back(slave);
    } else if (raw.error().kind != ErrorKind::kWorkingCounter) {
      return tl::unexpected(raw.error());  // nobody can be reached
    } else if (first) {
      first = tl::unexpected(raw.error());
    }
  }
  auto lowered = change_state(bus, above, target, timeout);
  return first ? lowered : first;
}

}  // namespace driveline::ecat_master
