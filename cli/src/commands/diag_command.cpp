#include <fmt/format.h>

#include "commands/commands.hpp"
#include "driveline/ecat_master/diagnosis/diagnosis.hpp"
#include "line/line_view.hpp"
#include "text/json_text.hpp"
#include "text/slave_text.hpp"

namespace driveline::cli {
namespace {

using ecat_master::FaultPlace;
using ecat_master::LineDiagnosis;

struct DiagOptions {
  BusOptions bus;
  bool clear = false;
  bool json = false;
};

std::string_view kind_text(FaultPlace::Kind kind) {
  switch (kind) {
    using enum FaultPlace::Kind;
    case kDamagedFrames:
      return "damaged_frames";
    case kLostLink:
      return "lost_link";
    case kNoLink:
      return "no_link";
    case kNoAnswer:
      return "no_answer";
    case kBadFrames:
      return "bad_frames";
    case kPdi:
      return "pdi";
  }
  return "unknown";
}

nlohmann::json to_json(const ecat_master::SlaveDiagnosis& slave) {
  auto ports = nlohmann::json::array();
  for (const auto& port : slave.ports) {
    ports.push_back({{"link", port.status.link},
                     {"communication", port.status.communication},
                     {"invalid_frames", port.invalid_frames},
                     {"receive_errors", port.receive_errors},
                     {"forwarded_errors", port.forwarded},
                     {"lost_links", port.lost_links}});
  }
  return {{"position", slave.ref.position},
          {"name", slave.name},
          {"answers", slave.answers},
          {"state", state_text(slave.al.status.state)},
          {"error", slave.al.status.error},
          {"al_status_code", static_cast<unsigned>(slave.al.code)},
          {"processing_unit_errors", slave.processing_unit_errors},
          {"pdi_errors", slave.pdi_errors},
          {"ports", ports}};
}

nlohmann::json to_json(const FaultPlace& place) {
  nlohmann::json row = {{"kind", kind_text(place.kind)},
                        {"slave", place.slave},
                        {"port", place.port},
                        {"count", place.count},
                        {"sentence", ecat_master::describe(place)}};
  row["other"] = place.other ? nlohmann::json(*place.other) : nlohmann::json();
  return row;
}

nlohmann::json to_json(const LineDiagnosis& diagnosis) {
  nlohmann::json document = {{"slaves", nlohmann::json::array()}, {"places", nlohmann::json::array()}};
  for (const auto& slave : diagnosis.slaves) document["slaves"].push_back(to_json(slave));
  for (const auto& place : diagnosis.places) document["places"].push_back(to_json(place));
  return document;
}

/// The slaves as the diagnosis wants them: who they are and how they are addressed.
std::vector<ecat_master::ConfiguredSlave> known_slaves(LineView& line) {
  std::vector<ecat_master::ConfiguredSlave> slaves;
  for (const auto& view : line.read_all()) {
    ecat_master::ConfiguredSlave slave;
    slave.info.ref = view.slave.ref;
    slave.plan.name = view.name();
    const auto position = view.slave.ref.position;
    if (line.session().has_config() && position < line.session().config().slaves.size()) {
      slave.plan.name = line.session().config().slaves[position].name;
    }
    slaves.push_back(std::move(slave));
  }
  return slaves;
}

Outcome<int> diagnose(const DiagOptions& options) {
  auto line = LineView::open(options.bus);
  if (!line) return tl::unexpected(line.error());
  LineDiagnosis diagnosis;
  diagnosis.time = (*line)->session().clock().now();
  auto slaves = ecat_master::read_slave_diagnosis((*line)->bus(), known_slaves(**line));
  if (!slaves) return bus_failure(slaves.error());
  diagnosis.slaves = std::move(*slaves);
  // Ports that fit no tree are shown all the same; who is at the other end of a cable is not known then.
  diagnosis.places =
      ecat_master::locate_faults(diagnosis.slaves, (*line)->topology().value_or(ecat_master::Topology{}));
  if (options.json) {
    fmt::print("{}", json_text(to_json(diagnosis)));
  } else {
    fmt::print("{}", ecat_master::to_text(diagnosis));
  }
  if (!options.clear) return 0;
  if (auto cleared = ecat_master::clear_error_counters((*line)->bus()); !cleared) return bus_failure(cleared.error());
  return 0;
}

}  // namespace

Execute prepare_diag(Arguments& to) {
  auto options = std::make_shared<DiagOptions>();
  add_bus_options(to, options->bus);
  to.flag("--clear", options->clear, "Set the error counters to zero afterwards");
  add_json_flag(to, options->json);
  return [options] { return diagnose(*options); };
}

}  // namespace driveline::cli
