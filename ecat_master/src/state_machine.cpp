#include "driveline/ecat_master/state_machine.hpp"

#include <algorithm>
#include <array>
#include <optional>

#include "driveline/wire/sii_access.hpp"

namespace driveline::ecat_master {
namespace {

using std::chrono::microseconds;

/// AL status 0x0130 .. AL status code 0x0135 in one read.
constexpr std::size_t kReportBytes = 6;
constexpr auto kPollInterval = microseconds{500};

AlReport decode_report(std::span<const std::byte> bytes) {
  return {wire::AlStatus::from_raw(bytes::load_le<std::uint16_t>(bytes)),
          static_cast<wire::AlStatusCode>(bytes::load_le<std::uint16_t>(bytes.subspan(4)))};
}

/// AL status codes of a refusal that may pass by itself; docs/real_drives.md lists them with the reasons. The names of
/// the codes are those of ETG.1020, "AL status codes"; whether a state may be requested again is not in the standard.
constexpr std::array kPassingRefusals = {
    // No reason is given, or it depends on the load of the slave.
    wire::AlStatusCode::kNoError,
    wire::AlStatusCode::kUnspecifiedError,
    wire::AlStatusCode::kNoMemory,
    // The application, its data or its hardware are not ready.
    wire::AlStatusCode::kNoValidInputs,
    wire::AlStatusCode::kNoValidOutputs,
    wire::AlStatusCode::kNoValidInputsAndOutputs,
    wire::AlStatusCode::kEepromNoAccess,
    wire::AlStatusCode::kExternalHardwareNotReady,
    wire::AlStatusCode::kSlaveRestartedLocally,
    // The slave still reports the loss of its previous master.
    wire::AlStatusCode::kSyncManagerWatchdog,
    wire::AlStatusCode::kBackgroundWatchdog,
    // Slaves that apply a mapping in the background compare the sync managers with the previous mapping: SOEM #79 and
    // #701 (0x001D, 0x001E), SOEM #530 (0x0024).
    wire::AlStatusCode::kInvalidOutputConfiguration,
    wire::AlStatusCode::kInvalidInputConfiguration,
    wire::AlStatusCode::kInvalidInputMapping,
    wire::AlStatusCode::kInvalidOutputMapping,
    // The slave has not locked to SYNC0 yet.
    wire::AlStatusCode::kSynchronizationError,
    wire::AlStatusCode::kFatalSyncError,
    wire::AlStatusCode::kNoSyncError,
    wire::AlStatusCode::kPllError,
    wire::AlStatusCode::kDcSyncIoError,
    wire::AlStatusCode::kDcSyncTimeout,
};
/// Codes from here on are those of vendors (ETG.1020). Their reasons are unknown, so they may pass.
constexpr std::uint16_t kFirstVendorCode = 0x8000;

/// A register of a slave and the value to be written.
struct RegisterValue {
  SlaveRef slave;
  std::uint16_t address = 0;
  std::array<std::byte, 2> data{};
  std::size_t bytes = 2;
};

/// Writes registers whose effect is checked elsewhere; the working counters do not matter.
Result<void> write_registers(Bus& bus, std::span<RegisterValue> writes) {
  std::vector<Request> requests;
  for (auto& write : writes) {
    requests.push_back({wire::Command::kFpwr, wire::DatagramAddress::physical(write.slave.station, write.address),
                        std::span(write.data).first(write.bytes)});
  }
  return bus.exchange().exchange(requests);
}

/// The error for a slave that did not answer.
Error silent(std::uint16_t position, std::uint16_t working_counter) {
  return {facts::WorkingCounter{.address = wire::reg::kAlStatus.address, .received = working_counter}, position};
}

/// Sends reads of AL status and code, one per slave, and decodes the answers.
template <typename PositionOf>
Result<std::vector<AlReport>> collect_reports(Bus& bus, std::span<Request> requests, PositionOf position_of) {
  if (auto done = bus.exchange().exchange(requests); !done) return tl::unexpected(done.error());
  std::vector<AlReport> reports;
  for (std::size_t i = 0; i < requests.size(); ++i) {
    if (requests[i].working_counter != 1) return tl::unexpected(silent(position_of(i), requests[i].working_counter));
    reports.push_back(decode_report(requests[i].data));
  }
  return reports;
}

/// The change of state of a slave. Error indications are acknowledged first, by repeating the current state with the
/// acknowledge bit (ETG.1000.6 5.3.1), and must be cleared before the request: the old error could be mistaken for the
/// answer to it.
class Change {
 public:
  Change(const StateTarget& slave, std::chrono::nanoseconds now)
      : slave_(slave.slave), timeout_(slave.timeout), retries_(slave.retries), deadline_(now + slave.timeout) {}

  [[nodiscard]] bool open() const noexcept { return !result_.has_value(); }
  [[nodiscard]] SlaveRef slave() const noexcept { return slave_; }
  [[nodiscard]] const Result<void>& result() const noexcept { return *result_; }
  /// The number of refusals, and the reason of the last one, after which the state was requested again.
  [[nodiscard]] unsigned refusals() const noexcept { return refusals_; }
  [[nodiscard]] wire::AlStatusCode refusal() const noexcept { return refusal_; }
  void fail(const Error& error) { result_ = tl::unexpected(error); }

  /// Counts a poll that the slave did not answer.
  void missed(std::uint16_t working_counter) {
    if (++missed_ >= kMissedPolls) fail(silent(slave_.position, working_counter));
  }
  /// The next register to be written; empty: wait.
  [[nodiscard]] std::optional<RegisterValue> take(const AlReport& report, wire::AlState target,
                                                  std::chrono::nanoseconds now) {
    missed_ = 0;
    const bool late = now >= deadline_;
    const auto refused = [&] {
      fail({facts::StateRefused{.requested = target, .actual = report.status.state, .code = report.code},
            slave_.position});
    };
    switch (phase_) {
      case Phase::kStart:
      case Phase::kAcknowledge:
        if (!report.status.error) {
          phase_ = Phase::kRequest;
          deadline_ = now + timeout_;
          return control({target, false, false});
        }
        if (late) refused();
        // The controller of a slave without application copies AL control, including the acknowledge bit, into AL
        // status (ESC data sheet I, device emulation): the apparent error without code disappears when the bit is not
        // written.
        if (phase_ == Phase::kAcknowledge && !copied_ && report.code == wire::AlStatusCode::kNoError) {
          copied_ = true;
          return control({report.status.state, false, false});
        }
        if (phase_ == Phase::kAcknowledge) return std::nullopt;
        phase_ = Phase::kAcknowledge;
        return control({report.status.state, true, false});
      case Phase::kPause:
        if (!late) break;
        phase_ = Phase::kStart;
        copied_ = false;
        deadline_ = now + timeout_;
        break;
      case Phase::kRequest:
        if (report.status.error && needs_eeprom(report, target)) {
          handed_over_ = true;
          phase_ = Phase::kStart;
          return RegisterValue{
              slave_, wire::reg::kSiiConfiguration.address, {std::byte{wire::sii_access::kConfigPdiOwns}}, 1};
        }
        if (report.status.error && refusals_ < retries_.count && may_pass(report.code)) {
          ++refusals_;
          refusal_ = report.code;
          phase_ = Phase::kPause;
          deadline_ = now + retries_.pause;
        } else if (report.status.error) {
          refused();
        } else if (report.status.state == target) {
          result_.emplace();
        } else if (late) {
          fail({facts::StateTimeout{
                    .requested = target, .actual = report.status.state, .code = report.code, .timeout = timeout_},
                slave_.position});
        }
        break;
    }
    return std::nullopt;
  }

 private:
  enum class Phase : std::uint8_t { kStart, kAcknowledge, kRequest, kPause };

  [[nodiscard]] RegisterValue control(wire::AlControl value) const noexcept {
    return {slave_, wire::reg::kAlControl.address, bytes::to_le_bytes(value.raw())};
  }
  /// Whether the slave refuses the state because it cannot read its EEPROM (ETG.1020: the master gives the interface to
  /// the application in the transition to PREOP).
  [[nodiscard]] bool needs_eeprom(const AlReport& report, wire::AlState target) const noexcept {
    return !handed_over_ && target != wire::AlState::kInit && report.code == wire::AlStatusCode::kEepromNoAccess;
  }

  /// A port that opens or closes may cost a poll.
  static constexpr unsigned kMissedPolls = 3;

  SlaveRef slave_;
  std::chrono::nanoseconds timeout_;
  StateRetries retries_;
  std::chrono::nanoseconds deadline_;  ///< end of the phase
  unsigned refusals_ = 0;
  wire::AlStatusCode refusal_ = wire::AlStatusCode::kNoError;
  Phase phase_ = Phase::kStart;
  bool copied_ = false;
  bool handed_over_ = false;  ///< the application has got the EEPROM interface
  unsigned missed_ = 0;
  std::optional<Result<void>> result_;
};

/// Polls all open changes once and writes the resulting registers.
Result<void> advance(Bus& bus, std::span<Change*> open, wire::AlState target) {
  std::vector<Request> requests;
  std::vector<std::array<std::byte, kReportBytes>> data(open.size());
  for (std::size_t i = 0; i < open.size(); ++i) {
    requests.push_back({wire::Command::kFprd,
                        wire::DatagramAddress::physical(open[i]->slave().station, wire::reg::kAlStatus.address),
                        data[i], 0, false});
  }
  if (auto done = bus.exchange().exchange(requests); !done) return done;
  std::vector<RegisterValue> writes;
  for (std::size_t i = 0; i < open.size(); ++i) {
    if (requests[i].working_counter != 1) {
      open[i]->missed(requests[i].working_counter);
      continue;
    }
    const auto value = open[i]->take(decode_report(data[i]), target, bus.exchange().now());
    if (value) writes.push_back(*value);
  }
  return writes.empty() ? Result<void>{} : write_registers(bus, writes);
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
  if (*count == 0) return tl::unexpected(Error{facts::NoSlaves{}});
  std::vector<Request> requests;
  std::vector<std::array<std::byte, kReportBytes>> data(*count);
  for (std::uint16_t i = 0; i < *count; ++i) {
    requests.push_back(
        {wire::Command::kAprd, wire::DatagramAddress::position(i, wire::reg::kAlStatus.address), data[i]});
  }
  return collect_reports(bus, requests, [](std::size_t i) { return static_cast<std::uint16_t>(i); });
}

std::chrono::nanoseconds StateTimeouts::limit(wire::AlState target, bool down) const noexcept {
  switch (target) {
    case wire::AlState::kOp:
      return to_op.value_or(kOpTimeout);
    case wire::AlState::kSafeOp:
      return down ? back_to_safe_op.value_or(std::chrono::milliseconds{200}) : to_safe_op.value_or(kOpTimeout);
    case wire::AlState::kInit:
      return back_to_init.value_or(std::chrono::seconds{5});
    default:
      return to_pre_op.value_or(kPreOpTimeout);
  }
}

bool may_pass(wire::AlStatusCode code) noexcept {
  return static_cast<std::uint16_t>(code) >= kFirstVendorCode ||
         std::find(kPassingRefusals.begin(), kPassingRefusals.end(), code) != kPassingRefusals.end();
}

std::vector<Result<void>> change_states(Bus& bus, std::span<const StateTarget> slaves, wire::AlState target,
                                        StartupNotes* notes) {
  std::vector<Change> changes;
  for (const auto& slave : slaves) changes.emplace_back(slave, bus.exchange().now());
  for (;;) {
    std::vector<Change*> open;
    for (auto& change : changes) {
      if (change.open()) open.push_back(&change);
    }
    if (open.empty()) break;
    if (auto done = advance(bus, open, target); !done) {
      for (auto* change : open) {
        Error error = done.error();
        error.slave = change->slave().position;
        change->fail(error);
      }
      break;
    }
    if (std::any_of(open.begin(), open.end(), [](const Change* change) { return change->open(); })) {
      bus.exchange().pause(kPollInterval);
    }
  }
  std::vector<Result<void>> results;
  for (const auto& change : changes) {
    results.push_back(change.result());
    if (notes == nullptr || change.refusals() == 0 || !change.result()) continue;
    notes->push_back({change.slave().position, notes::StateReachedLater{target, change.refusal(),
                                                                        static_cast<std::uint8_t>(change.refusals())}});
  }
  return results;
}

Result<void> change_state(Bus& bus, std::span<const SlaveRef> slaves, wire::AlState target,
                          std::chrono::nanoseconds timeout) {
  std::vector<StateTarget> targets;
  for (const auto& slave : slaves) targets.push_back({slave, timeout});
  return first_failure(change_states(bus, targets, target));
}

Result<void> first_failure(std::span<const Result<void>> results) {
  const Result<void>* worst = nullptr;
  for (const auto& result : results) {
    if (result) continue;
    if (result.error().is<facts::StateRefused>()) return result;
    if (worst == nullptr) worst = &result;
  }
  return worst == nullptr ? Result<void>{} : *worst;
}

Result<void> lower_state(Bus& bus, std::span<const SlaveRef> slaves, wire::AlState target,
                         std::chrono::nanoseconds timeout) {
  std::vector<Request> requests;
  std::vector<std::array<std::byte, kReportBytes>> data(slaves.size());
  for (std::size_t i = 0; i < slaves.size(); ++i) {
    requests.push_back({wire::Command::kFprd,
                        wire::DatagramAddress::physical(slaves[i].station, wire::reg::kAlStatus.address), data[i], 0,
                        false});
  }
  // No slave can be reached.
  if (auto done = bus.exchange().exchange(requests); !done) return done;
  Result<void> first{};
  std::vector<SlaveRef> above;
  for (std::size_t i = 0; i < slaves.size(); ++i) {
    if (requests[i].working_counter != 1) {
      if (first) first = tl::unexpected(silent(slaves[i].position, requests[i].working_counter));
    } else if (decode_report(data[i]).status.state > target) {
      above.push_back(slaves[i]);
    }
  }
  auto lowered = change_state(bus, above, target, timeout);
  return first ? lowered : first;
}

}  // namespace driveline::ecat_master
