#include "driveline/runtime/ethercat/configure_line.hpp"

#include <fmt/format.h>

#include <utility>

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
  return tl::unexpected(Error{ErrorKind::kLine, {}, std::move(text), {}, 0, done.error()});
}

}  // namespace driveline::runtime
