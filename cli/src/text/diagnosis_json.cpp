#include "text/diagnosis_json.hpp"

#include "text/histogram_json.hpp"
#include "text/json_text.hpp"
#include "text/slave_text.hpp"

namespace driveline::cli {
namespace {

using ecat_master::CyclicEvent;
using ecat_master::ExchangeGroupDiagnosis;
using ecat_master::FaultPlace;
using ecat_master::LineDiagnosis;
using ecat_master::LineEvent;

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

nlohmann::json to_json(const ExchangeGroupDiagnosis& group) {
  return {{"exchanges", group.exchanges},
          {"lost_frames", group.lost_frames},
          {"wkc_errors", group.wkc_errors},
          {"bad_cycles", group.bad_cycles},
          {"longest_bad", group.longest_bad},
          {"working_counter", group.working_counter},
          {"expected_working_counter", group.expected_working_counter},
          {"outputs_zeroed", group.outputs_zeroed}};
}

nlohmann::json to_json(const port::RingStatus& ring) {
  using State = port::RingStatus::State;
  const auto* state = ring.state == State::kOpen ? "open" : ring.state == State::kClosed ? "closed" : "unknown";
  return {{"state", state}, {"primary_slaves", ring.primary_slaves}, {"secondary_slaves", ring.secondary_slaves}};
}

nlohmann::json to_json(const LineEvent& event) {
  return {{"time_ns", event.time.count()}, {"slave", event.slave}, {"sentence", ecat_master::what_happened(event)}};
}

nlohmann::json to_json(const CyclicEvent& event) {
  return {{"time_ns", event.time_ns}, {"cycle", event.cycle}, {"sentence", ecat_master::describe(event)}};
}

nlohmann::json to_json(const ecat_master::EmergencyRecord& record) {
  return {{"time_ns", record.time.count()}, {"slave", record.slave}, {"sentence", ecat_master::describe(record)}};
}

nlohmann::json to_json(const motion::CycleStatistics& cycle) {
  return {{"cycles", cycle.cycles},
          {"missed_periods", cycle.missed_periods},
          {"wkc_errors", cycle.wkc_errors},
          {"lost_frames", cycle.lost_frames},
          {"longest_absence_ns", cycle.longest_absence.count()},
          {"wake_latency_ns", percentiles_json(cycle.wake_latency)},
          {"cycle_cost_ns", percentiles_json(cycle.cost)},
          {"round_trip_ns", percentiles_json(cycle.round_trip)}};
}

template <typename Entries>
nlohmann::json list(const Entries& entries) {
  auto rows = nlohmann::json::array();
  for (const auto& entry : entries) rows.push_back(to_json(entry));
  return rows;
}

/// Adds the keys about the running cycle.
void add_exchange(nlohmann::json& document, const LineDiagnosis& diagnosis) {
  document["groups"] = list(diagnosis.groups);
  document["stale_frames"] = diagnosis.stale_frames;
  document["foreign_frames"] = diagnosis.foreign_frames;
  document["events"] = list(diagnosis.events);
  document["exchange_history"] = list(diagnosis.exchange_history);
  document["state_history"] = list(diagnosis.state_history);
  document["emergencies"] = list(diagnosis.emergencies);
  if (const auto& guard = diagnosis.guard) {
    document["registers"] = {{"looks", guard->looks},
                             {"rounds", guard->rounds},
                             {"changes", guard->changes},
                             {"last_round_ns", guard->last_round.count()}};
  }
  if (!diagnosis.statistics) return;
  document["cycle"] = to_json(*diagnosis.statistics);
  document["cycle"]["round_trip_modelled"] = diagnosis.round_trip_modelled;
}

}  // namespace

nlohmann::json to_json(const LineDiagnosis& diagnosis) {
  nlohmann::json document = {
      {"slaves", list(diagnosis.slaves)}, {"places", list(diagnosis.places)}, {"problems", diagnosis.problems}};
  if (diagnosis.ring) document["ring"] = to_json(*diagnosis.ring);
  if (!diagnosis.groups.empty()) add_exchange(document, diagnosis);
  return document;
}

}  // namespace driveline::cli
