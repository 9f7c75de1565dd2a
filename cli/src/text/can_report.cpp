#include "text/can_report.hpp"

#include <fmt/format.h>

#include <nlohmann/json.hpp>
#include <optional>

namespace driveline::cli {
namespace {

using canopen::BusState;

nlohmann::json counter_json(const std::optional<std::uint8_t>& counter) {
  return counter ? nlohmann::json(*counter) : nlohmann::json();
}

/// Null where it was not measured.
nlohmann::json load_json(const runtime::BusLoad& load, double value) {
  return load.samples > 0 ? nlohmann::json(value) : nlohmann::json();
}

double percent(double share) {
  return 100.0 * share;
}

}  // namespace

std::string_view bus_state_text(BusState state) {
  switch (state) {
    case BusState::kErrorActive:
      return "error active";
    case BusState::kErrorWarning:
      return "error warning";
    case BusState::kErrorPassive:
      return "error passive";
    case BusState::kBusOff:
      return "bus off";
    case BusState::kUnknown:
      break;
  }
  return "unknown";
}

nlohmann::json can_to_json(const runtime::RunReport& report) {
  if (!report.can) return nullptr;
  const auto& can = *report.can;
  return {{"bit_rate", can.bit_rate},
          {"sync_ns", report.period.count()},
          {"planned_load", can.planned_load},
          {"worst_load", can.worst_load},
          {"bus_load_mean", load_json(report.bus_load, report.bus_load.mean)},
          {"bus_load_max", load_json(report.bus_load, report.bus_load.maximum)},
          {"state", bus_state_text(can.port.state)},
          {"frames_sent", can.port.sent},
          {"frames_received", can.port.received},
          {"error_frames", can.port.error_frames},
          {"lost_by_adapter", can.port.lost},
          {"malformed", can.port.malformed},
          {"send_errors", counter_json(can.port.send_errors)},
          {"receive_errors", counter_json(can.port.receive_errors)},
          {"lost_pdos", can.lost_pdos},
          {"late_pdos", can.late_pdos},
          {"unsent_pdos", can.unsent_pdos},
          {"unsent_syncs", can.unsent_syncs},
          {"emergencies", can.emergencies}};
}

std::string can_to_text(const runtime::RunReport& report) {
  if (!report.can) return {};
  const auto& can = *report.can;
  auto text = fmt::format("\n  CAN bus: {:g} kbit/s, {}; PDOs take {:.0f} % without stuff bits, at most {:.0f} %",
                          can.bit_rate / 1000.0, bus_state_text(can.port.state), percent(can.planned_load),
                          percent(can.worst_load));
  if (report.bus_load.samples > 0) {
    text += fmt::format("; measured {:.1f} %, at most {:.1f} %", percent(report.bus_load.mean),
                        percent(report.bus_load.maximum));
  }
  text += fmt::format("\n    {} frames sent, {} received; PDOs: {} lost, {} late, {} not sent; {} emergencies\n",
                      can.port.sent, can.port.received, can.lost_pdos, can.late_pdos, can.unsent_pdos, can.emergencies);
  if (can.port.lost + can.port.malformed + can.unsent_syncs > 0) {
    text += fmt::format("    {} frames lost by the adapter, {} pieces of input that were no frame, {} SYNCs not sent\n",
                        can.port.lost, can.port.malformed, can.unsent_syncs);
  }
  return text;
}

}  // namespace driveline::cli
