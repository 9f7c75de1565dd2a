// From the search for nodes to the state in which the cycle can start.
#include <fmt/format.h>

#include <algorithm>

#include "can/can_bus.hpp"
#include "can/process_names.hpp"
#include "driveline/motion/drive/axis_objects.hpp"
#include "driveline/motion/drive/drive_objects.hpp"
#include "driveline/runtime/can/master_plan.hpp"
#include "driveline/runtime/event.hpp"
#include "driveline/runtime/setup/drive_facts.hpp"

namespace driveline::runtime {

Result<void> CanBus::bring_up(bool force) {
  canopen::CanMaster::Settings settings;
  settings.force = force;
  // The line in this process has no other master; listening for one would only take time.
  if (session_.simulated_line() != nullptr) settings.listen = {};
  settings.recover = config_.recovery.axes != motion::LossPolicy::kStop;
  master_ =
      std::make_unique<canopen::CanMaster>(session_.port(), session_.clock(), make_master_plan(config_), settings);
  progress(events::CanPortOpened{session_.bus_name(), config_.can->bit_rate, config_.can->master_node});
  if (auto booted = boot(); !booted) return booted;
  if (auto fits = check_bus(); !fits) return fits;
  if (auto asked = ask_drives(); !asked) return asked;
  return name_process_data();
}

/// A line that is too much for its bus is refused before anything is sent, where its PDOs are known from the plan.
Result<void> CanBus::boot() {
  if (const auto image = canopen::PdoImage::build(master_->plan())) {
    budget_ = canopen::bus_budget(master_->plan(), *image);
    if (auto fits = check_bus(); !fits) return fits;
  }
  const auto booted = master_->boot();
  tell_notes();
  if (!booted) return fail_nodes(booted.error());
  budget_ = canopen::bus_budget(master_->plan(), master_->image());
  state_ = "Pre-operational";
  progress(events::SlavesFound{nodes_there()});
  for (std::size_t i = 0; i < config_.slaves.size(); ++i) {
    if (master_->node(i).phase == canopen::NodePhase::kNotSeen) {
      tell(events::SlaveNotConnected{i, name_of(i)}, Severity::kNotice);
    }
  }
  listener_.slaves_change();
  return {};
}

Result<void> CanBus::check_bus() const {
  if (budget_.fits) return {};
  return fail(ErrorKind::kSetting, describe(budget_, config_.axes.empty() ? "nodes" : "axes"), "[bus]");
}

std::size_t CanBus::nodes_there() const {
  std::size_t there = 0;
  for (std::size_t i = 0; i < config_.slaves.size(); ++i) {
    if (master_->node(i).phase != canopen::NodePhase::kNotSeen) ++there;
  }
  return there;
}

/// Completes the axes with data from their drives.
Result<void> CanBus::ask_drives() {
  for (auto& axis : config_.axes) {
    if (axis.is_virtual()) continue;
    const auto& pdos = master_->image().configuration(axis.slave);
    const auto missing =
        motion::missing_objects(axis.mode, motion::pdos_of_drive(pdos, axis.drive), axis.feed_forward.any());
    if (!missing.empty()) {
      return fail(ErrorKind::kSetting,
                  fmt::format("axis {}, node {} ({}): {}", axis.name, config_.slaves[axis.slave].can.node,
                              name_of(axis.slave), motion::describe_missing(axis.mode, missing, pdos, axis.drive)));
    }
    // An optional drive that is not there keeps what the description says of it.
    if (master_->node(axis.slave).phase == canopen::NodePhase::kNotSeen) continue;
    if (auto asked = ask_drive(axis); !asked) return asked;
  }
  return {};
}

Result<void> CanBus::ask_drive(motion::AxisConfig& axis) {
  std::optional<canopen::ClientError> failed;
  const auto read = [&](std::uint16_t index, std::uint8_t subindex) -> std::optional<std::vector<std::byte>> {
    if (failed) return std::nullopt;
    auto data = master_->upload(axis.slave, {motion::object_of_drive(index, axis.drive), subindex});
    if (data) return std::move(*data);
    if (data.error().kind != canopen::ClientErrorKind::kAborted) failed = data.error();
    return std::nullopt;
  };
  const auto facts = ask_drive_facts(read);
  if (failed) return fail(ErrorKind::kLine, canopen::describe(*failed), name_of(axis.slave));
  const auto difference = take_drive_facts(axis, facts);
  if (!difference) return tl::unexpected(difference.error());
  if (*difference) {
    tell(events::ScaleDiffers{axis.name, (*difference)->described, (*difference)->reported_by_drive},
         Severity::kNotice);
  }
  return {};
}

Result<void> CanBus::name_process_data() {
  auto named = runtime::name_process_data(config_, can_variables(master_->plan(), master_->image()));
  if (!named) return tl::unexpected(named.error());
  process_data_ = std::move(*named);
  progress(events::NodesConfigured{nodes_there(), budget_});
  if (process_data_->variables.all().empty()) progress(events::NoProcessData{});
  return {};
}

}  // namespace driveline::runtime
