#include "text/node_diagnosis.hpp"

#include <fmt/format.h>

#include <nlohmann/json.hpp>
#include <optional>

#include "driveline/motion/cia402/error_code.hpp"
#include "text/can_report.hpp"

namespace driveline::cli {
namespace {

using canopen::NodeView;

std::string_view nmt_text(const NodeView& node) {
  return node.state ? to_text(*node.state) : std::string_view("not heard");
}

std::string emergency_text(const NodeView& node) {
  if (!node.emergency || node.emergency->code == 0) return {};
  return motion::cia402::error_text(node.emergency->code);
}

nlohmann::json number_json(const std::optional<std::uint8_t>& number) {
  return number ? nlohmann::json(*number) : nlohmann::json();
}

}  // namespace

std::string nodes_text(canopen::CanMaster& master) {
  auto text = fmt::format("{:<4}{:>6}  {:<20}{:<13}{:<17}{:>11}{:>6}{:>6}{:>6}\n", "", "node", "name", "phase",
                          "NMT state", "recoveries", "EMCY", "lost", "late");
  const auto& nodes = master.plan().nodes;
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    const auto& node = master.node(i);
    const auto report = master.cycle()->node_report(i);
    text +=
        fmt::format("{:<4}{:>6}  {:<20}{:<13}{:<17}{:>11}{:>6}{:>6}{:>6}\n", i, nodes[i].id, nodes[i].name,
                    to_text(node.phase), nmt_text(node), node.recoveries, node.emergencies, report.lost, report.late);
    if (const auto emergency = emergency_text(node); !emergency.empty()) {
      text += fmt::format("            last EMCY: {}\n", emergency);
    }
    if (node.error) text += fmt::format("            {}\n", describe(*node.error, nodes[i].name));
  }
  const auto port = master.port_statistics();
  text += fmt::format("adapter: {}, {} frames sent, {} received, {} lost, {} error frames\n",
                      bus_state_text(port.state), port.sent, port.received, port.lost, port.error_frames);
  return text;
}

nlohmann::json nodes_json(canopen::CanMaster& master) {
  auto rows = nlohmann::json::array();
  const auto& nodes = master.plan().nodes;
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    const auto& node = master.node(i);
    const auto report = master.cycle()->node_report(i);
    nlohmann::json row = {{"name", nodes[i].name},
                          {"node", nodes[i].id},
                          {"phase", to_text(node.phase)},
                          {"state", nmt_text(node)},
                          {"operational", report.operational},
                          {"heartbeats", node.heartbeats},
                          {"boot_ups", node.boot_ups},
                          {"recoveries", node.recoveries},
                          {"emergencies", node.emergencies},
                          {"lost_pdos", report.lost},
                          {"late_pdos", report.late},
                          {"emergency", nullptr},
                          {"error", nullptr}};
    if (const auto emergency = emergency_text(node); !emergency.empty()) row["emergency"] = emergency;
    if (node.error) row["error"] = describe(*node.error, nodes[i].name);
    rows.push_back(std::move(row));
  }
  const auto port = master.port_statistics();
  return {{"nodes", std::move(rows)},
          {"adapter",
           {{"state", bus_state_text(port.state)},
            {"frames_sent", port.sent},
            {"frames_received", port.received},
            {"frames_lost", port.lost},
            {"error_frames", port.error_frames},
            {"send_errors", number_json(port.send_errors)},
            {"receive_errors", number_json(port.receive_errors)}}}};
}

}  // namespace driveline::cli
