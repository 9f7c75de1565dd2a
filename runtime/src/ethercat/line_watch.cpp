#include "ethercat/line_watch.hpp"

#include "driveline/runtime/event.hpp"

#include <algorithm>
#include <utility>

namespace driveline::runtime {
namespace {

using ecat_master::LineEvent;
using std::chrono::nanoseconds;

/// After this time without valid process data the line counts as unreachable.
constexpr nanoseconds kCommunicationTimeout = std::chrono::milliseconds{100};
/// Interval at which the propagation delays to the clocks are measured.
constexpr auto kDelayInterval = std::chrono::seconds{10};
/// Time-out per state transition of a slave in recovery; a stop of the user waits for it.
constexpr auto kRecoveryTimeout = std::chrono::seconds{3};

ecat_master::LineSupervisor::Settings supervision(const RecoveryConfig& recovery) {
  ecat_master::LineSupervisor::Settings settings;
  settings.recover = recovery.axes != motion::LossPolicy::kStop;
  settings.state_timeout = kRecoveryTimeout;
  return settings;
}

std::vector<LossWatch::Losable> losable(const ecat_master::Master& master) {
  std::vector<LossWatch::Losable> slaves;
  for (const auto& slave : master.slaves()) slaves.push_back({slave.plan.hot_connect});
  return slaves;
}

}  // namespace

LineWatch::LineWatch(ecat_master::Master& master, const port::RedundantPort* ring, LineMotion* motion,
                     const LineConfig& config, rt::Clock& clock, Listener listener)
    : master_(master),
      motion_(motion),
      config_(config),
      clock_(clock),
      listener_(std::move(listener)),
      supervisor_(master, ring, supervision(config.recovery)),
      losses_({&config, &clock, motion,
               [&core = *master.core()](motion::MasterAbsence& absence) { return core.take_absence(absence); }},
              losable(master), listener_),
      last_emergency_(clock.now()),
      next_delays_(clock.now() + kDelayInterval) {
  for (std::size_t i = 0; i < master.slaves().size(); ++i) {
    if (!master.slaves()[i].present) notice(events::SlaveNotConnected{i, name_of(i)});
  }
}

bool LineWatch::poll() {
  if (!losses_.master_was_there() || !frames_come_back()) return false;
  supervisor_.poll();
  const bool line = take_line_events();
  if (motion_ != nullptr) motion_->poll(listener_);
  fetch_messages();
  const bool motion = losses_.motion_goes_on();
  return line && motion && !waits_in_vain() && clocks_answer();
}

/// Checked before any slave is asked: on a line that is cut off at the master, every request would wait for its
/// time-out.
bool LineWatch::frames_come_back() {
  auto& core = *master_.core();
  const bool silent = core.bad_cycles() * config_.period > kCommunicationTimeout && core.al_status().slaves == 0;
  if (!silent) {
    if (silent_since_ != nanoseconds{0}) notice(events::CommunicationBack{});
    silent_since_ = {};
    stale_before_ = core.stale_frames();
    return true;
  }
  const events::CommunicationLost lost{core.bad_cycles(), core.stale_frames() - stale_before_};
  if (config_.recovery.axes == LossPolicy::kStop) {
    state_ = "LOST";
    end(lost);
    return false;
  }
  const auto now = clock_.now();
  if (silent_since_ == nanoseconds{0}) {
    silent_since_ = now;
    fault(lost);
  }
  if (config_.recovery.give_up.count() == 0 || now - silent_since_ < config_.recovery.give_up) return true;
  state_ = "LOST";
  end(events::CommunicationNotBack{config_.recovery.give_up});
  return false;
}

bool LineWatch::take_line_events() {
  bool goes_on = true;
  const auto& history = supervisor_.history();
  const auto fresh = std::min<std::uint64_t>(supervisor_.events() - events_taken_, history.size());
  for (auto event = history.end() - static_cast<std::ptrdiff_t>(fresh); event != history.end(); ++event) {
    if (!take(*event)) goes_on = false;
  }
  events_taken_ = supervisor_.events();
  return goes_on;
}

bool LineWatch::take(const LineEvent& event) {
  using Kind = LineEvent::Kind;
  const bool of_slave = event.kind == Kind::kLeftOp || event.kind == Kind::kGone || event.kind == Kind::kRecovered ||
                        event.kind == Kind::kJoined || event.kind == Kind::kRecoveryFailed ||
                        event.kind == Kind::kRegistersChanged || event.kind == Kind::kRegistersRestored;
  events::LineChanged changed{event, of_slave ? name_of(event.slave) : std::string(), std::nullopt};
  if (event.kind == Kind::kLeftOp) changed.after = losses_.cause_of(event.time);
  switch (event.kind) {
    case Kind::kLeftOp:
    case Kind::kGone:
    case Kind::kRegistersChanged:
      losses_.lost(event.slave, event.time);
      if (losses_.expendable(event.slave)) {
        fault(std::move(changed));
        return true;
      }
      state_ = event.kind != Kind::kLeftOp
                   ? "INCOMPLETE"
                   : std::string(wire::to_text(event.state.state)) + (event.state.error ? "+ERROR" : "");
      end(std::move(changed));
      return false;
    case Kind::kJoined:
    case Kind::kRecovered:
      losses_.back(event.slave);
      [[fallthrough]];
    case Kind::kRingClosed:
      notice(std::move(changed));
      return true;
    case Kind::kOtherMaster:
      // Tools that only read or use mailboxes are no fault.
      if (ecat_master::harm_of(event.other.command, event.other.ado) < 2) {
        notice(std::move(changed));
        return true;
      }
      [[fallthrough]];
    case Kind::kRecoveryFailed:
    case Kind::kRingBroken:
    case Kind::kOutputsZeroed:
    case Kind::kRegistersRestored:
      fault(std::move(changed));
      return true;
  }
  return true;
}

bool LineWatch::waits_in_vain() {
  const auto missed = losses_.missed_too_long();
  if (!missed) return false;
  state_ = "INCOMPLETE";
  end(events::SlaveNotBack{*missed, name_of(*missed), config_.recovery.give_up});
  return true;
}

/// Fetches unsolicited messages of the slaves: one round of the mailboxes per poll(); slaves without a mailbox take no
/// time.
void LineWatch::fetch_messages() {
  if (silent_since_ != nanoseconds{0}) return;
  static_cast<void>(master_.mailboxes().step());
  auto newest = last_emergency_;
  for (const auto& record : master_.emergencies().all()) {
    if (record.time <= last_emergency_) continue;
    newest = std::max(newest, record.time);
    notice(events::Emergency{record, name_of(record.slave)});
  }
  last_emergency_ = newest;
  for (const auto& record : master_.soe_messages().take()) notice(events::SoeMessage{record, name_of(record.slave)});
}

/// Checks the clocks. Events are reported and a lost lock is a fault, but neither ends the run: a drive that needs its
/// clock reports the loss itself. False: the bus does not answer.
bool LineWatch::clocks_answer() {
  auto* watch = master_.clock_watch();
  // A lost slave does not answer; recovery waits for it.
  if (watch == nullptr || silent_since_ != nanoseconds{0}) return true;
  using Kind = ecat_master::dc::ClockEvent::Kind;
  auto polled = watch->poll();
  if (const auto now = clock_.now(); polled && now >= next_delays_ && supervisor_.all_operational()) {
    next_delays_ = now + kDelayInterval;
    polled = master_.remeasure_delays();
  }
  for (const auto& event : watch->take_events()) {
    const bool lost = event.kind == Kind::kLockLost || event.kind == Kind::kNoReference;
    const auto grave = config_.recovery.axes == LossPolicy::kStop ? Severity::kFailure : Severity::kFault;
    listener_(events::ClocksChanged{event}, lost ? grave : Severity::kNotice);
  }
  if (polled || config_.recovery.axes != LossPolicy::kStop) return true;
  end(events::BusFailed{polled.error()});
  return false;
}

void LineWatch::tell_rest() {
  if (motion_ != nullptr) motion_->poll(listener_);
  losses_.tell_rest(master_.core()->absences_dropped());
  const auto missed = losses_.first_missed();
  if (!missed || state_ != "OP") return;
  state_ = "INCOMPLETE";
  end(events::SlaveNotBack{*missed, name_of(*missed), std::nullopt});
}

}  // namespace driveline::runtime
