#include "driveline/canopen_master/master_event.hpp"

#include <fmt/format.h>

#include "driveline/motion/cia402/error_code.hpp"

namespace driveline::canopen {
namespace {

std::string manufacturer_bytes(const Emergency& emergency) {
  std::string text;
  for (const auto byte : emergency.manufacturer) text += fmt::format(" {:02X}", std::to_integer<unsigned>(byte));
  return text;
}

/// Name of a communication error of CiA 301 Table 26; those of drives are in motion::cia402.
std::string_view communication_error(std::uint16_t code) noexcept {
  switch (code) {
    case emergency_code::kCanOverrun:
      return "CAN overrun";
    case emergency_code::kErrorPassive:
      return "CAN error passive";
    case emergency_code::kErrorControl:
      return "life guarding or heartbeat error";
    case emergency_code::kRecoveredFromBusOff:
      return "recovered from bus off";
    case emergency_code::kPdoTooShort:
      return "PDO too short";
    case emergency_code::kPdoTooLong:
      return "PDO too long";
    default:
      return {};
  }
}

std::string emergency_words(const Emergency& emergency) {
  const auto known = communication_error(emergency.code);
  const auto code =
      known.empty() ? motion::cia402::error_text(emergency.code) : fmt::format("0x{:04X}, {}", emergency.code, known);
  return fmt::format("emergency {}; error register 0x{:02X}, manufacturer bytes{}", code, emergency.error_register,
                     manufacturer_bytes(emergency));
}

std::string node_event(const MasterEvent& event) {
  switch (event.kind) {
    case MasterEvent::Kind::kNodeLost:
      return fmt::format("lost: gave no sign of life for {} ms", event.waited_ms);
    case MasterEvent::Kind::kNodeBack:
      return "is configured and Operational again";
    case MasterEvent::Kind::kNodeJoined:
      return "has joined the line and is Operational";
    case MasterEvent::Kind::kNodeRebooted:
      return "has started anew: it was switched off, or reset";
    case MasterEvent::Kind::kWrongState:
      return fmt::format("left Operational, is {}", to_text(event.state));
    case MasterEvent::Kind::kEmergency:
      return emergency_words(event.emergency);
    case MasterEvent::Kind::kErrorReset:
      return fmt::format("error reset; error register 0x{:02X}", event.emergency.error_register);
    case MasterEvent::Kind::kGuardToggle:
      return "an answer to node guarding had the wrong toggle bit: it was repeated, or one was lost";
    case MasterEvent::Kind::kDoubleAnswers:
      return "answers came that nobody had asked for: two devices may have this node-ID";
    default:
      return "an unknown event";
  }
}

std::string line_event(const MasterEvent& event) {
  switch (event.kind) {
    case MasterEvent::Kind::kBusOff:
      return "the CAN adapter has left the bus (bus off): no frame passes";
    case MasterEvent::Kind::kBusBack:
      return "the CAN adapter is on the bus again";
    default:
      return "the CAN adapter or its connection is gone";
  }
}

}  // namespace

std::string_view to_text(NodePhase phase) noexcept {
  switch (phase) {
    case NodePhase::kNotSeen:
      return "not seen";
    case NodePhase::kBooting:
      return "booting";
    case NodePhase::kConfigured:
      return "configured";
    case NodePhase::kStarting:
      return "starting";
    case NodePhase::kOperational:
      return "operational";
    case NodePhase::kLost:
      return "lost";
    case NodePhase::kFailed:
      return "failed";
    case NodePhase::kReleased:
      return "released";
  }
  return "unknown";
}

std::string describe(const MasterEvent& event, std::string_view name) {
  switch (event.kind) {
    case MasterEvent::Kind::kBusOff:
    case MasterEvent::Kind::kBusBack:
    case MasterEvent::Kind::kBusDown:
      return line_event(event);
    case MasterEvent::Kind::kOtherMaster: {
      NodeError error{NodeErrorKind::kOtherMaster};
      error.other = event.other;
      return describe(error, name);
    }
    case MasterEvent::Kind::kStranger:
      return fmt::format("node {} is on this bus and not in the line description", event.id);
    case MasterEvent::Kind::kRecoveryFailed:
    case MasterEvent::Kind::kNote:
      return describe(event.error, name);
    default:
      return fmt::format("node {} ({}): {}", event.id, name, node_event(event));
  }
}

}  // namespace driveline::canopen
