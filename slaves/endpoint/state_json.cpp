#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "cockpit.hpp"
#include "driveline/wire/al.hpp"

namespace driveline::endpoint {
namespace {

using nlohmann::ordered_json;
using slaves::DeviceStatus;

std::string text(const wire::IpV4Address& ip) {
  return fmt::format("{}.{}.{}.{}", ip[0], ip[1], ip[2], ip[3]);
}

std::string text(const wire::MacAddress& mac) {
  std::string line;
  for (const auto octet : mac) line += fmt::format("{}{:02x}", line.empty() ? "" : ":", static_cast<unsigned>(octet));
  return line;
}

std::string_view al_text(wire::AlState state) noexcept {
  switch (state) {
    case wire::AlState::kInit:
      return "INIT";
    case wire::AlState::kPreOp:
      return "PREOP";
    case wire::AlState::kBootstrap:
      return "BOOT";
    case wire::AlState::kSafeOp:
      return "SAFEOP";
    case wire::AlState::kOp:
      return "OP";
    default:
      return "unknown";
  }
}

ordered_json identity(const DeviceStatus& device) {
  return {{"maker", device.maker.view()},
          {"type", device.type.view()},
          {"name", device.name.view()},
          {"firmware", device.firmware.view()},
          {"vendor_id", fmt::format("0x{:08X}", device.vendor_id)},
          {"product_code", fmt::format("0x{:08X}", device.product_code)},
          {"revision", fmt::format("0x{:08X}", device.revision)},
          {"serial_number", device.serial_number}};
}

ordered_json drive(const DeviceStatus& device) {
  return {{"state", device.state.view()},
          {"mode", device.mode.view()},
          {"display", device.display.view()},
          {"control_word", fmt::format("0x{:04X}", device.control_word)},
          {"status_word", fmt::format("0x{:04X}", device.status_word)},
          {"fault", device.fault},
          {"error_code", fmt::format("0x{:04X}", device.error_code)},
          {"message", device.message.view()}};
}

ordered_json values(const DeviceStatus& device, DeviceStatus::Kind kind) {
  auto list = ordered_json::array();
  for (const auto& value : device.shown()) {
    if (value.kind != static_cast<std::uint32_t>(kind)) continue;
    list.push_back({{"name", value.name.view()}, {"value", value.value}, {"unit", value.unit.view()}});
  }
  return list;
}

ordered_json network(const CockpitState& state) {
  return {{"al_state", al_text(state.device.al_state)},
          {"link", state.link},
          {"mac", text(state.address.mac)},
          {"ip", text(state.address.ip)},
          {"subnet_mask", text(state.address.subnet_mask)},
          {"gateway", text(state.address.gateway)},
          {"frames_in", state.frames_in},
          {"frames_out", state.frames_out}};
}

}  // namespace

std::string state_json(const CockpitState& state) {
  const ordered_json document = {{"identity", identity(state.device)},
                                 {"drive", drive(state.device)},
                                 {"network", network(state)},
                                 {"values", values(state.device, DeviceStatus::Kind::kActual)},
                                 {"parameters", values(state.device, DeviceStatus::Kind::kParameter)},
                                 {"running_s", state.running.count()}};
  // Device names may have any encoding.
  return document.dump(2, ' ', false, ordered_json::error_handler_t::replace) + "\n";
}

}  // namespace driveline::endpoint
