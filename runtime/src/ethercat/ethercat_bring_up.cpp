// From the scan to the state in which the cycle can start.
#include <fmt/format.h>

#include <algorithm>

#include "driveline/runtime/ethercat/configure_line.hpp"
#include "driveline/runtime/event.hpp"
#include "driveline/runtime/observer.hpp"
#include "driveline/runtime/setup/clock_plan.hpp"
#include "driveline/runtime/setup/composition.hpp"
#include "driveline/runtime/setup/drive_facts.hpp"
#include "driveline/runtime/setup/process_data_plan.hpp"
#include "driveline/runtime/setup/wire_budget.hpp"
#include "ethercat/ethercat_bus.hpp"

namespace driveline::runtime {
namespace {

/// Longer than the watchdogs of process data, so that a line whose master has died has left OP when this time has
/// passed.
constexpr auto kListenForMasters = std::chrono::milliseconds{150};

/// Passes events on.
class EventForwarder final : public Observer {
 public:
  explicit EventForwarder(const LineMotion::Tell& take) : take_(take) {}
  void event(const Event& event) override { take_(event.facts, event.severity); }

 private:
  const LineMotion::Tell& take_;
};

}  // namespace

Result<void> EtherCatBus::bring_up(bool force) {
  if (auto free = must_be_free(force); !free) return free;
  if (auto found = find_slaves(); !found) return found;
  if (config_.clocks) {
    if (auto planned = bring_up_clocks(); !planned) return planned;
  }
  if (auto configured = configure(); !configured) return configured;
  if (auto complete = check_axis_objects(config_, master_); !complete) return complete;
  if (auto asked = ask_drives(); !asked) return asked;
  return name_process_data();
}

/// Refuses a line that another master controls. Masters of this program hold a claim (Session::claim()), others are
/// recognised by their frames.
Result<void> EtherCatBus::must_be_free(bool force) {
  if (force || !config_.interface) return {};
  const auto owner = master_.find_owner(kListenForMasters);
  // A line without slaves is reported by scan().
  if (!owner || !owner->in_op) return {};
  if (owner->heard) {
    return fail(ErrorKind::kLineDriven,
                fmt::format("slave {} is in OP and {}: this run would interrupt the other master", *owner->in_op,
                            ecat_master::describe_traffic(master_.exchange_statistics())));
  }
  progress(events::TakenOver{*owner->in_op, kListenForMasters});
  return {};
}

Result<void> EtherCatBus::find_slaves() {
  if (auto done = master_.scan(); !done) return fail_line(done.error());
  progress(events::SlavesFound{master_.slaves().size()});
  for (const auto& wire : session_.wires()) {
    progress(events::InterfaceOpened{wire.interface, wire.access_method, wire.steps_down});
  }
  EventForwarder events(listener_.tell);
  tell_problems(master_, events);
  if (!session_.has_config()) {
    session_.use_found_slaves(describe_found(master_.slaves()));
    config_.slaves = session_.config().slaves;
    progress(events::NoDescription{});
  }
  return check_planned_pdos(config_, master_.slaves());
}

Result<void> EtherCatBus::bring_up_clocks() {
  // The plan assigns SYNC signals to slaves, so slaves with a planned device ID must be identified first.
  const auto by_id = [](const SlaveConfig& slave) { return slave.plan.device_id.has_value(); };
  if (std::any_of(config_.slaves.begin(), config_.slaves.end(), by_id)) {
    if (auto done = master_.identify_devices(); !done) return fail_line(done.error());
  }
  auto plan = make_clock_plan(config_, master_.slaves(), session_.virtual_time());
  if (!plan) return tl::unexpected(plan.error());
  master_.use_clocks(std::move(*plan));
  if (session_.ring() != nullptr) master_.use_ring(*session_.ring());
  progress(events::ClocksBeingSet{});
  return {};
}

Result<void> EtherCatBus::configure() {
  EventForwarder events(listener_.tell);
  if (auto done = configure_line(master_, &config_, events); !done) return done;
  startup_notes_told_ = master_.startup_notes().size();
  state_ = "SAFEOP";
  configured_ = true;
  listener_.slaves_change();
  return {};
}

/// Completes the axes with data from their drives.
Result<void> EtherCatBus::ask_drives() {
  const auto facts = read_drive_facts(master_, config_);
  for (std::size_t i = 0; i < config_.axes.size(); ++i) {
    if (!facts[i]) return fail_line(facts[i].error());
    auto& axis = config_.axes[i];
    const auto difference = take_drive_facts(axis, *facts[i]);
    if (!difference) return tl::unexpected(difference.error());
    if (*difference) {
      tell(events::ScaleDiffers{axis.name, (*difference)->described, (*difference)->reported_by_drive},
           Severity::kNotice);
    }
  }
  return {};
}

Result<void> EtherCatBus::name_process_data() {
  auto named = runtime::name_process_data(config_, master_);
  if (!named) return tl::unexpected(named.error());
  process_data_ = std::move(*named);
  const auto wire = wire_budget(master_, config_);
  const auto& image = master_.image();
  progress(events::Configured{image.outputs().size(), image.frame_count(), wire, config_.interface.has_value()});
  if (image.outputs().empty() && image.inputs().empty()) progress(events::NoProcessData{});
  return check_budget(wire, config_.interface.has_value());
}

}  // namespace driveline::runtime
