#include "driveline/runtime/ethercat/configure_line.hpp"

#include <fmt/format.h>

#include <optional>
#include <utility>
#include <variant>

#include "driveline/ecat_master/configuration/configuration_check.hpp"
#include "driveline/runtime/event.hpp"
#include "driveline/runtime/setup/composition.hpp"

namespace driveline::runtime {
namespace {

std::vector<ecat_master::SlaveInfo> found_on(const ecat_master::Master& master) {
  std::vector<ecat_master::SlaveInfo> found;
  for (const auto& slave : master.slaves()) found.push_back(slave.info);
  return found;
}

}  // namespace

void tell_problems(const ecat_master::Master& master, Observer& observer) {
  const auto found = found_on(master);
  for (const auto& slave : found) {
    if (slave.problem) observer.event({events::SlaveUnusable{*slave.problem}});
  }
  for (auto& duplicate : ecat_master::find_duplicate_aliases(found))
    observer.event({events::AliasNotUnique{std::move(duplicate)}});
}

std::string startup_idn_place(const ecat_master::Error& error, std::span<const ecat_master::ConfiguredSlave> slaves) {
  using Datum = std::optional<ecat_master::facts::SoeDatum>;
  const auto datum = std::visit(
      [](const auto& facts) {
        if constexpr (requires { Datum(facts.datum); }) return Datum(facts.datum);
        return Datum{};
      },
      error.facts);
  if (!datum) return {};
  for (const auto& slave : slaves) {
    if (slave.info.ref.position != error.slave) continue;
    for (const auto& idn : slave.plan.startup_idns) {
      if (idn.at == *datum) return idn.place;
    }
  }
  return {};
}

Result<void> configure_line(ecat_master::Master& master, const LineConfig* config, Observer& observer) {
  auto plans = config != nullptr ? make_slave_plans(*config) : std::vector<ecat_master::SlavePlan>{};
  auto planned = ecat_master::expected_slaves(plans);
  const auto done = master.configure(std::move(plans));
  // A refused state is often the consequence of a refused write.
  for (const auto& note : master.startup_notes()) observer.event({events::StartupNoted{note}, Severity::kNotice});
  if (done) return {};
  const auto& differences = master.comparison().differences;
  if (!differences.empty())
    observer.event({events::LineDiffers{master.comparison(), std::move(planned), found_on(master)}});
  auto text = ecat_master::describe_with_findings(master.bus(), master.slaves(), master.image(), done.error());
  if (differences.size() > 1) text += fmt::format("; the first of {} differences", differences.size());
  auto place = startup_idn_place(done.error(), master.slaves());
  return tl::unexpected(Error{ErrorKind::kLine, std::move(place), std::move(text), {}, 0, done.error()});
}

}  // namespace driveline::runtime
