#include "text/slave_text.hpp"

#include <fmt/format.h>
#include <algorithm>

#include "text/sii_text.hpp"

namespace driveline::cli {
namespace {

using ecat_master::EscInformation;

std::string_view port_type(const EscInformation& controller, unsigned port) {
  using enum EscInformation::PortType;
  switch (controller.port_type(port)) {
    case kNotImplemented:
      return "N/A";
    case kNotConfigured:
      return "N/C";
    case kEbus:
      return "EBUS";
    case kMii:
      return "MII";
  }
  return "?";
}

std::string controller_text(const EscInformation& controller) {
  const bool clocks = (controller.features & ecat_master::esc_feature::kDistributedClocks) != 0;
  const bool wide = (controller.features & ecat_master::esc_feature::kDc64Bit) != 0;
  const auto name = ecat_master::esc_type_name(controller.type);
  std::string text = "DL information:\n";
  text += fmt::format("  Controller: {}type 0x{:02x}, revision {}, build {}\n",
                      name.empty() ? "" : fmt::format("{}, ", name), controller.type, controller.revision,
                      controller.build);
  text += fmt::format("  FMMUs: {}, sync managers: {}, RAM: {} KiB\n", controller.fmmus, controller.sync_managers,
                      controller.ram_kib);
  text += fmt::format("  FMMU bit operation: {}\n",
                      (controller.features & ecat_master::esc_feature::kFmmuBytesOnly) != 0 ? "no" : "yes");
  text += fmt::format("  Distributed clocks: {}\n", !clocks ? "no" : wide ? "yes, 64 bit" : "yes, 32 bit");
  return text;
}

std::string ports_text(const SlaveFacts& facts) {
  const auto& controller = facts.controller;
  std::string text = "Port  Type  Link  Loop    Signal  NextSlave  RxTime [ns]  Diff [ns]\n";
  for (unsigned port = 0; port < 4; ++port) {
    const auto& status = controller.dl_status.ports[port];
    const bool active = status.communication;
    const auto time = controller.receive_time_ns[port];
    const auto difference = static_cast<std::int32_t>(time - controller.receive_time_ns[0]);
    text += fmt::format("   {}  {:<4}  {:<4}  {:<6}  {:<6}  {:>9}  {:>11}  {:>9}\n", port, port_type(controller, port),
                        status.link ? "up" : "down", status.loop_closed ? "closed" : "open", active ? "yes" : "no",
                        facts.neighbours[port] ? fmt::format("{}", *facts.neighbours[port]) : "-",
                        active ? fmt::format("{}", time) : "-", active ? fmt::format("{}", difference) : "-");
  }
  return text;
}

std::string sync_managers_text(const esi::SiiImage& sii) {
  std::string text;
  const auto* channels = sii.find<std::vector<esi::SiiSyncManager>>(esi::SiiCategoryType::kSyncManager);
  for (std::size_t i = 0; channels != nullptr && i < channels->size(); ++i) {
    text += sync_manager_text(i, (*channels)[i]);
  }
  return text;
}

}  // namespace

std::string state_text(wire::AlState state) {
  return wire::is_known(state) ? std::string(wire::to_text(state))
                               : fmt::format("0x{:X}", static_cast<unsigned>(state));
}

std::string slave_table(std::span<const SlaveView> slaves) {
  std::size_t position = 0;
  std::size_t alias = 0;
  std::size_t state = 0;
  for (const auto& view : slaves) {
    position = std::max(position, fmt::format("{}", view.slave.ref.position).size());
    alias = std::max(alias, view.alias_position.size());
    state = std::max(state, state_text(view.slave.al.status.state).size());
  }
  std::string text;
  for (const auto& view : slaves) {
    const auto& status = view.slave.al.status;
    text += fmt::format("{:<{}}  {:<{}}  {:<{}}  {}  {}\n", view.slave.ref.position, position, view.alias_position,
                        alias, state_text(status.state), state, status.error ? 'E' : '+',
                        view.trouble.empty() ? view.name() : view.trouble);
  }
  return text;
}

std::array<std::optional<std::uint16_t>, 4> neighbours_of(const ecat_master::Topology& topology, std::size_t position) {
  std::array<std::optional<std::uint16_t>, 4> neighbours{};
  if (position >= topology.slaves.size()) return neighbours;
  const auto& node = topology.slaves[position];
  neighbours = node.children;
  if (node.parent) neighbours[node.entry_port] = node.parent->slave;
  return neighbours;
}

std::string slave_details(const SlaveView& view, const SlaveFacts& facts) {
  const auto& [status, code] = view.slave.al;
  std::string text = slave_heading(view.slave.ref.position);
  text += fmt::format("Alias: {}\nStation address: 0x{:04x}\nState: {}\nFlag: {}\n", view.slave.alias,
                      view.slave.ref.station, state_text(status.state), status.error ? 'E' : '+');
  if (status.error) {
    text += fmt::format("AL status code: 0x{:04x} ({})\n", static_cast<unsigned>(code), wire::to_text(code));
  }
  if (!view.trouble.empty()) text += fmt::format("Trouble: {}\n", view.trouble);
  if (view.sii) text += identity_text(*view.sii);
  text += controller_text(facts.controller) + ports_text(facts);
  if (view.sii) {
    text += mailbox_and_general_text(*view.sii) + sync_managers_text(*view.sii) + fmmu_and_clock_text(*view.sii);
  }
  return text + "\n";
}

nlohmann::json slave_json(const SlaveView& view, const SlaveFacts& facts) {
  const auto& controller = facts.controller;
  const auto& [status, code] = view.slave.al;
  nlohmann::json row = {{"position", view.slave.ref.position},
                        {"station_address", view.slave.ref.station},
                        {"alias", view.slave.alias},
                        {"state", state_text(status.state)},
                        {"error", status.error},
                        {"al_status_code", static_cast<unsigned>(code)},
                        {"vendor_id", nullptr},
                        {"product_code", nullptr},
                        {"revision", nullptr},
                        {"serial_number", nullptr},
                        {"name", view.name()}};
  if (!view.trouble.empty()) row["trouble"] = view.trouble;
  if (view.sii) {
    row["vendor_id"] = view.sii->vendor_id;
    row["product_code"] = view.sii->product_code;
    row["revision"] = view.sii->revision;
    row["serial_number"] = view.sii->serial_number;
    row["sii"] = to_json(*view.sii);
  }
  auto ports = nlohmann::json::array();
  for (unsigned port = 0; port < 4; ++port) {
    const auto& state = controller.dl_status.ports[port];
    nlohmann::json port_row = {{"type", port_type(controller, port)},
                               {"link", state.link},
                               {"loop_closed", state.loop_closed},
                               {"communication", state.communication},
                               {"next_slave", nullptr},
                               {"receive_time_ns", controller.receive_time_ns[port]}};
    if (facts.neighbours[port]) port_row["next_slave"] = *facts.neighbours[port];
    ports.push_back(std::move(port_row));
  }
  row["controller"] = {
      {"type", controller.type},
      {"revision", controller.revision},
      {"build", controller.build},
      {"fmmus", controller.fmmus},
      {"sync_managers", controller.sync_managers},
      {"ram_kib", controller.ram_kib},
      {"distributed_clocks", (controller.features & ecat_master::esc_feature::kDistributedClocks) != 0},
      {"ports", ports}};
  return row;
}

}  // namespace driveline::cli
