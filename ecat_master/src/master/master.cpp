#include "driveline/ecat_master/master.hpp"

#include <algorithm>

#include "dc/bring_up.hpp"
#include "driveline/ecat_master/configuration/configuration_check.hpp"
#include "driveline/ecat_master/configuration/description_plan.hpp"
#include "driveline/ecat_master/configuration/state_refusal.hpp"
#include "driveline/ecat_master/dc/sync_objects.hpp"
#include "driveline/ecat_master/discovery/device_identification.hpp"
#include "master/newcomers.hpp"

namespace driveline::ecat_master {

Master::Master(port::Port& port, rt::Clock& clock, const Settings& settings)
    : port_(port),
      clock_(clock),
      settings_(settings),
      direct_(port, clock, settings.exchange),
      exchange_(direct_),
      bus_(exchange_),
      engine_(bus_) {
  engine_.handle(wire::MailboxType::kCoe, emergencies_);
  engine_.handle(wire::MailboxType::kSoe, soe_messages_);
}

Master::~Master() {
  stop_cycle();
}

Result<std::vector<AlReport>> Master::peek_states() {
  return ecat_master::peek_states(bus_);
}

Result<Master::Owner> Master::find_owner(std::chrono::nanoseconds timeout) {
  constexpr auto kBetweenLooks = std::chrono::milliseconds{5};
  const auto end = clock_.now() + timeout;
  for (;;) {
    const auto states = peek_states();
    if (!states) return tl::unexpected(states.error());
    const auto in_op = std::find_if(states->begin(), states->end(),
                                    [](const AlReport& report) { return report.status.state == wire::AlState::kOp; });
    if (in_op == states->end()) return Owner{};
    const Owner owner{static_cast<std::uint16_t>(in_op - states->begin()), exchange_statistics().frames_of_masters > 0};
    if (owner.heard || clock_.now() >= end) return owner;
    clock_.sleep_until(clock_.now() + kBetweenLooks);
  }
}

Result<void> Master::scan() {
  auto found = discover(bus_);
  if (!found) return tl::unexpected(found.error());
  engine_.close_all();
  slaves_.clear();
  refs_.clear();
  for (auto& info : *found) {
    refs_.push_back(info.ref);
    slaves_.push_back({std::move(info), {}, nullptr});
  }
  facts_.assign(slaves_.size(), {});
  auto facts = read_port_facts(bus_, refs_);
  if (!facts) return tl::unexpected(facts.error());
  // An undetermined topology does not prevent the line from running.
  topology_ = build_topology(*facts).value_or(Topology{});
  return {};
}

Result<void> Master::enter_pre_op() {
  std::vector<SlaveInfo> infos;
  std::vector<StateTimeouts> timeouts;
  std::vector<MailboxTimeouts> mailbox_timeouts;
  for (const auto& slave : slaves_) {
    // Slaves that are not on the line are at the end.
    if (!slave.present) break;
    infos.push_back(slave.info);
    timeouts.push_back(slave.plan.timeouts);
    mailbox_timeouts.push_back(slave.plan.mailbox_timeouts);
  }
  auto mailboxes = ecat_master::enter_pre_op(engine_, infos, timeouts, mailbox_timeouts);
  if (!mailboxes) return tl::unexpected(mailboxes.error());
  for (std::size_t i = 0; i < mailboxes->size(); ++i) slaves_[i].mailbox = std::move((*mailboxes)[i]);
  return {};
}

Result<void> Master::identify_devices() {
  const auto ids = read_device_ids(bus_, refs_);
  if (!ids) return tl::unexpected(ids.error());
  for (std::size_t i = 0; i < slaves_.size(); ++i) slaves_[i].info.device_id = (*ids)[i];
  return {};
}

std::optional<std::size_t> Master::position_of(std::size_t plan) const noexcept {
  const auto& plans = comparison_.plan_of_slave;
  const auto found = std::find(plans.begin(), plans.end(), std::optional(plan));
  if (found == plans.end()) return std::nullopt;
  return static_cast<std::size_t>(found - plans.begin());
}

/// Finds the slave of each plan; any difference is an error.
Result<void> Master::match(std::span<const SlavePlan> plans) {
  drop_absent();
  const bool by_id =
      std::any_of(plans.begin(), plans.end(), [](const SlavePlan& p) { return p.device_id.has_value(); });
  if (by_id) {
    if (auto done = identify_devices(); !done) return done;
  }
  std::vector<SlaveInfo> infos;
  for (const auto& slave : slaves_) infos.push_back(slave.info);
  const auto expected = expected_slaves(plans);
  comparison_ = compare_line(expected, infos, settings_.accept_swapped_ports ? Topology{} : topology_);
  if (comparison_.matches()) return {};
  return tl::unexpected(to_error(comparison_.differences.front(), expected, infos));
}

Result<void> Master::configure(std::vector<SlavePlan> plans) {
  startup_notes_.clear();
  if (auto done = match(plans); !done) return done;
  for (std::size_t i = 0; i < slaves_.size(); ++i) {
    const auto plan = comparison_.plan_of_slave[i];
    slaves_[i].plan = plan ? std::move(plans[*plan]) : SlavePlan{};
    if (!plan) slaves_[i].plan.own_pdos = true;
    if (!slaves_[i].plan.esi && settings_.describe) slaves_[i].plan.esi = settings_.describe(slaves_[i].info);
    apply_description(slaves_[i]);
    // The remarks are about the EEPROM, which a description file replaces.
    if (!slaves_[i].plan.esi) add_new(startup_notes_, slaves_[i].info.remarks);
  }
  for (const auto number : comparison_.absent) add_absent(number, std::move(plans[number]));
  // No process data are laid out yet: a refusal can only concern the mailboxes.
  image_ = {};
  if (auto done = enter_pre_op(); !done) {
    return tl::unexpected(explain_state_error(bus_, slaves_, image_, done.error()));
  }
  auto image = configure_process_data(engine_, slaves_, settings_.layout, startup_notes_);
  if (!image) return tl::unexpected(image.error());
  image_ = std::move(*image);
  if (auto done = synchronise_clocks(); !done) return done;
  if (auto done = learn_facts(); !done) return done;
  if (auto done = raise_to(wire::AlState::kSafeOp); !done) return tl::unexpected(explain(done.error()));
  return {};
}

/// Adds the causes that the master finds in the slave and that its drives name.
Error Master::explain(const Error& error) {
  return explain_by_drives(engine_, slaves_, explain_state_error(bus_, slaves_, image_, error), startup_notes_);
}

/// Reads the facts of the controllers; slaves that are not on the line are at the end and have none.
Result<void> Master::learn_facts() {
  auto facts = read_controller_facts(bus_, reachable());
  if (!facts) return tl::unexpected(facts.error());
  facts_ = std::move(*facts);
  facts_.resize(slaves_.size());
  return {};
}

Result<std::vector<RegisterChange>> Master::changed_registers(std::size_t slave) {
  const auto* clocks = watch_ ? &watch_->clocks() : nullptr;
  return find_changes(bus_, refs_[slave], guarded_registers(slaves_[slave], image_, clocks, facts_[slave]));
}

Result<void> Master::synchronise_clocks() {
  clocks_.reset();
  if (!clock_plan_) return {};
  // Check before writing anything to a slave.
  if (auto done = dc::check_plan(*clock_plan_); !done) return done;
  for (std::size_t i = 0; i < slaves_.size(); ++i) {
    if (auto done = tell_sync_type(i); !done) return done;
  }
  auto clocks = dc::bring_up_clocks(bus_, reachable(), topology_, *clock_plan_);
  if (!clocks) return tl::unexpected(clocks.error());
  clocks_ = std::move(*clocks);
  // Slaves that may join later have no clock yet.
  clocks_->slaves.resize(refs_.size());
  return {};
}

/// Writes 1C32h and 1C33h of a slave with signals.
Result<void> Master::tell_sync_type(std::size_t slave) {
  if (!slaves_[slave].present || slave >= clock_plan_->slaves.size() || !clock_plan_->slaves[slave].signals.active())
    return {};
  const auto& one = slaves_[slave];
  if (!one.mailbox || !one.info.description.mailbox.coe) return {};
  StartupNotes notes;
  const auto done = dc::write_sync_objects(engine_, refs_[slave].position, clock_plan_->slaves[slave].signals,
                                           one.plan.needs.sync_objects, notes);
  add_new(startup_notes_, notes);
  return done;
}

Result<void> Master::await_clocks() {
  constexpr std::chrono::milliseconds kPoll{5};
  const auto deadline = clock_.now() + settings_.clock_timeout;
  for (;;) {
    if (auto done = watch_->poll(); !done) return done;
    const auto status = follower_->status();
    const auto late = watch_->out_of_window();
    if (status.locked && !late) return {};
    if (clock_.now() >= deadline) {
      if (!status.locked) return tl::unexpected(dc::not_locked(status, *follower_));
      return tl::unexpected(Error{
          facts::NotSynchronised{.difference = watch_->clocks().slaves[*late].difference, .window = watch_->window()},
          *late});
    }
    pass(kPoll);
  }
}

tl::expected<void, rt::RealtimeError> Master::start_cycle(motion::MotionControl* motion, motion::SampleRings rings,
                                                          CyclicCore::Settings settings,
                                                          const MakeRunner& make_runner) {
  settings.slaves = static_cast<std::uint16_t>(reachable().size());
  newcomers_ = std::make_unique<Newcomers>(Newcomers::Line{bus_, slaves_, refs_, topology_, comparison_});
  watch_.reset();
  follower_ = clocks_ ? std::make_unique<dc::ClockFollower>(*clocks_) : nullptr;
  settings.clocks = follower_.get();
  settings.instance = direct_.instance();
  core_ = std::make_unique<CyclicCore>(port_, clock_, image_, motion, rings, settings);
  // Without process data, as for clocks in PREOP, working counters contain no information about slaves.
  for (std::size_t i = 0; i < image_.places().size(); ++i) core_->set_recovering(i, !slaves_[i].present);
  runner_ = make_runner(*core_);
  if (auto started = runner_->start(); !started) {
    runner_.reset();
    core_.reset();
    return started;
  }
  cyclic_ = std::make_unique<CyclicExchange>(core_->acyclic(), clock_,
                                             [this](std::chrono::nanoseconds duration) { runner_->pass(duration); });
  cycling_ = true;
  exchange_.use(*cyclic_);
  engine_.use_status(&mailbox_status_);
  if (clocks_) {
    watch_ = std::make_unique<dc::ClockWatch>(bus_, refs_, *clocks_, *follower_);
  }
  if (watch_ && ring_ != nullptr) watch_->use_ring(*ring_);
  return {};
}

bool Master::supports_eoe(std::size_t slave) const noexcept {
  return slaves_[slave].info.description.mailbox.eoe;
}

Result<std::shared_ptr<EoePort>> Master::open_eoe(std::size_t slave, EoeReceiver& receiver) {
  if (!supports_eoe(slave)) return tl::unexpected(Error{facts::NoEoe{}, refs_[slave].position});
  return eoe_.open(refs_[slave].position, receiver);
}

/// Raises all slaves at once, each with its own time limit.
Result<void> Master::raise_to(wire::AlState target) {
  std::vector<StateTarget> targets;
  for (const auto& slave : slaves_) {
    if (!slave.present) continue;
    const auto& plan = slave.plan;
    const auto timeout = rise_timeout(slave, target);
    targets.push_back({slave.info.ref, std::min(timeout, settings_.state_timeout.value_or(timeout)),
                       target == wire::AlState::kSafeOp ? plan.safe_op_retries : StateRetries{0}});
  }
  return first_failure(change_states(bus_, targets, target, &startup_notes_));
}

/// A slave in OP without process data is worse than one in SAFEOP: wait until the cycle has worked once.
Result<void> Master::await_exchange() {
  constexpr int kPeriods = 100;
  constexpr std::chrono::milliseconds kAtLeast{100};  // for a thread that starts slowly
  const auto& settings = core_->settings();
  const auto deadline = clock_.now() + std::max<std::chrono::nanoseconds>(kPeriods * settings.period, kAtLeast);
  const auto first = core_->cycles();
  const auto late = core_->stale_frames();
  while (core_->al_status().slaves == 0) {
    if (clock_.now() >= deadline) {
      return tl::unexpected(Error{facts::NoExchange{.window = settings.receive_window,
                                                    .cycles = static_cast<std::uint32_t>(core_->cycles() - first),
                                                    .late = static_cast<std::uint32_t>(core_->stale_frames() - late)}});
    }
    pass(settings.period);
  }
  return {};
}

Result<void> Master::go_operational() {
  if (auto done = await_exchange(); !done) return done;
  if (watch_) {
    if (auto done = await_clocks(); !done) return done;
  }
  if (auto done = write_startup_values(engine_, slaves_, motion::StartupState::kSafeOperational, startup_notes_); !done)
    return done;
  if (auto done = raise_to(wire::AlState::kOp); !done) return tl::unexpected(explain(done.error()));
  return {};
}

std::optional<MailboxStatusSample> Master::CycleMailboxStatus::mailbox_status(std::uint16_t position) const noexcept {
  const auto places = master_.image_.places();
  if (!master_.core_ || position >= places.size() || places[position].mailbox_offset == ProcessDataPlace::kNone)
    return std::nullopt;
  // Read the cycle number first: the report then belongs to that cycle or a later one.
  const auto cycle = master_.core_->cycles();
  const auto report = master_.core_->slave_report(position);
  if (!report.valid) return std::nullopt;
  return MailboxStatusSample{report.mailbox_full, cycle};
}

Result<std::vector<AlReport>> Master::al_status() {
  auto reports = read_al_status(bus_, reachable());
  if (!reports) return reports;
  AlReport absent;
  absent.status.state = wire::AlState::kNone;
  for (std::size_t i = 0; i < slaves_.size(); ++i) {
    if (!slaves_[i].present) reports->insert(reports->begin() + static_cast<std::ptrdiff_t>(i), absent);
  }
  return reports;
}

void Master::pass(std::chrono::nanoseconds duration) {
  exchange_.pause(duration);
}

void Master::stop_cycle() {
  if (!runner_) return;
  engine_.use_status(nullptr);
  runner_->stop();
  cycling_ = false;
  exchange_.use(direct_);
}

Result<void> Master::shut_down() {
  if (refs_.empty()) return {};
  Result<void> first{};
  auto note = [&first](Result<void> done) {
    if (!done && first) first = done;
  };
  // Hot-connect slaves may be missing.
  std::vector<SlaveRef> refs;
  for (std::size_t i = 0; i < slaves_.size(); ++i) {
    const bool here = slaves_[i].present && (!slaves_[i].plan.hot_connect || al_status_of(i));
    if (here) refs.push_back(refs_[i]);
  }
  const auto timeout = settings_.state_timeout.value_or(kOpTimeout);
  if (runner_) note(lower_state(bus_, refs, wire::AlState::kSafeOp, timeout));
  stop_cycle();
  note(lower_state(bus_, refs, wire::AlState::kPreOp, timeout));
  if (clocks_) note(dc::stop_signals(bus_));
  note(lower_state(bus_, refs, wire::AlState::kInit, timeout));
  return first;
}

}  // namespace driveline::ecat_master
