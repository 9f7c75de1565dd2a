#include "driveline/canopen_master/node_error.hpp"

#include <fmt/format.h>

namespace driveline::canopen {
namespace {

std::string entry_words(SdoObject object) {
  return fmt::format("0x{:04X}:{:02X}", object.index, object.subindex);
}

std::string pdo_words(const NodeError& error) {
  return fmt::format("{}PDO {}", error.rpdo ? 'R' : 'T', error.pdo);
}

std::string reason(const NodeError& error) {
  return error.request ? ": " + describe(*error.request) : std::string{};
}

std::string_view sign_words(OtherMasterSign sign) {
  switch (sign) {
    case OtherMasterSign::kNmt:
      return "NMT commands were heard";
    case OtherMasterSign::kSync:
      return "SYNC was heard, which a node may produce, too (1005h)";
    case OtherMasterSign::kHeartbeat:
      return "a heartbeat with the node-ID of this master was heard";
    case OtherMasterSign::kRpdo:
      return "setpoints to nodes of this line were heard";
  }
  return "unknown frames were heard";
}

std::string plan_words(const NodeError& error) {
  switch (error.fault) {
    case PlanFault::kNodeId:
      return fmt::format("{} is no node-ID: 1 to 127", error.found);
    case PlanFault::kNodeIdTwice:
      return fmt::format("node-ID {} is there twice", error.found);
    case PlanFault::kBothControls:
      return "heartbeat and node guarding exclude one another";
    case PlanFault::kTime:
      if (error.wanted != 0) {
        return fmt::format("a tolerance of {} ms is not longer than the heartbeat of {} ms", error.found, error.wanted);
      }
      return fmt::format("a time of {} ms for error control: the objects hold up to 65535 ms", error.found);
    case PlanFault::kMasterHeartbeat:
      return error.found == 0
                 ? fmt::format("the node expects a heartbeat of the master within {} ms, and it sends none",
                               error.wanted)
                 : fmt::format("the node expects a heartbeat of the master within {} ms, and it sends one every {} ms",
                               error.wanted, error.found);
    case PlanFault::kPdoNumber:
      return fmt::format("{}: the number is not 1 to 512, or there twice", pdo_words(error));
    case PlanFault::kPdoIdentifier:
      return error.found == 0
                 ? fmt::format("{} has no identifier: only PDO 1 to 4 have one of their own", pdo_words(error))
                 : fmt::format("{}: identifier 0x{:X} is used by another message, or reserved", pdo_words(error),
                               error.found);
    case PlanFault::kPdoTooLong:
      return fmt::format("{} has {} bits: 64 fit", pdo_words(error), error.found);
    case PlanFault::kTransmission:
      return fmt::format("{}: transmission type {} is reserved: 0 to 240, 254, 255", pdo_words(error), error.found);
    case PlanFault::kCompleteAccess:
      return fmt::format("start-up SDO {}: all sub-indices at once are possible on EtherCAT only",
                         entry_words(error.object));
  }
  return "the plan cannot be carried out";
}

std::string refusal_words(const NodeError& error) {
  if (!error.request) {  // the heartbeat consumer has no place that is free
    return fmt::format("none of the {} entries of 0x1016 is free for the heartbeat of the master", error.found);
  }
  return fmt::format("0x{:X} in {} instead of 0x{:X} was refused{}", error.wanted, entry_words(error.object),
                     error.found, reason(error));
}

std::string mapping_words(const NodeError& error) {
  switch (error.kind) {
    case NodeErrorKind::kFrozenMapping:
      return fmt::format("the mapping of {} cannot be changed: {} is 0x{:08X}, wanted is 0x{:08X}{}", pdo_words(error),
                         entry_words(error.object), error.found, error.wanted, reason(error));
    case NodeErrorKind::kEmptyMapping:
      return fmt::format("neither the line description nor the node has a mapping for {}", pdo_words(error));
    default:
      return error.wanted != 0
                 ? fmt::format("the node has mapped {} bits to {}: 64 fit", error.wanted, pdo_words(error))
                 : fmt::format("{} has {} objects, by {}: 64 are possible", pdo_words(error), error.found,
                               entry_words(error.object));
  }
}

std::string what(const NodeError& error) {
  switch (error.kind) {
    case NodeErrorKind::kAbsent:
      return error.step == BootStep::kStart
                 ? "gave no sign of life any more"
                 : fmt::format("sent no boot-up message and did not answer within {} ms", error.waited_ms);
    case NodeErrorKind::kRequestFailed:
      if (error.step == BootStep::kDeviceType && error.request && error.request->kind == ClientErrorKind::kNoAnswer) {
        return fmt::format("sent its boot-up message, but its SDO server did not answer within {} ms", error.waited_ms);
      }
      return fmt::format("{} failed{}", to_text(error.step), reason(error));
    case NodeErrorKind::kOtherDevice:
      return fmt::format("is another device: {} is 0x{:08X}, wanted is 0x{:08X}", entry_words(error.object),
                         error.found, error.wanted);
    case NodeErrorKind::kRefused:
      return refusal_words(error);
    case NodeErrorKind::kNotTaken:
      return fmt::format("accepted 0x{:08X} in {} and has 0x{:08X} there", error.wanted, entry_words(error.object),
                         error.found);
    case NodeErrorKind::kFrozenMapping:
    case NodeErrorKind::kEmptyMapping:
    case NodeErrorKind::kBadMapping:
      return mapping_words(error);
    case NodeErrorKind::kBadValue:
      return fmt::format("{} has {} bytes, wanted are {}", entry_words(error.object), error.found, error.wanted);
    case NodeErrorKind::kWrongState:
      return fmt::format("is {} instead of {}, whatever it is told", to_text(error.found_state),
                         to_text(error.wanted_state));
    case NodeErrorKind::kRestarts:
      return "starts again and again while it is configured: its supply or another master may be the cause";
    case NodeErrorKind::kNoRemote:
      return "node guarding needs remote frames, which the CAN adapter cannot carry: use heartbeats";
    case NodeErrorKind::kNoGuarding:
      return fmt::format("did not answer the remote frame of node guarding within {} ms", error.waited_ms);
    case NodeErrorKind::kNoPdo:
      return fmt::format("is Operational, but not all of its PDOs came within {} ms", error.waited_ms);
    case NodeErrorKind::kShortPdo:
      return fmt::format("{} is shorter than its mapping: {} bytes are expected, {} came", pdo_words(error),
                         error.wanted, error.found);
    case NodeErrorKind::kUnwatched:
      return "nothing watches this node, as it has neither heartbeat nor node guarding: it counts as Operational until "
             "a PDO of it that is due with SYNC fails";
    case NodeErrorKind::kBadPlan:
      return plan_words(error);
    case NodeErrorKind::kOtherMaster:
    case NodeErrorKind::kBusDown:
      break;
  }
  return "the CAN bus cannot be reached: the adapter takes no frame, or its connection has ended";
}

}  // namespace

std::string_view to_text(BootStep step) noexcept {
  switch (step) {
    case BootStep::kReset:
      return "reset communication";
    case BootStep::kDeviceType:
      return "device type (1000h)";
    case BootStep::kIdentity:
      return "identity (1018h)";
    case BootStep::kQuiet:
      return "switching error control off";
    case BootStep::kStartupSdos:
      return "start-up SDO";
    case BootStep::kSync:
      return "SYNC (1005h, 1006h)";
    case BootStep::kPdos:
      return "PDO configuration";
    case BootStep::kErrorControl:
      return "error control";
    case BootStep::kConfigured:
      return "configured";
    case BootStep::kStart:
      return "NMT start";
  }
  return "unknown step";
}

std::string describe(const NodeError& error, std::string_view name) {
  if (error.kind == NodeErrorKind::kOtherMaster) {
    return fmt::format("another master is on this bus: {}", sign_words(error.other));
  }
  if (error.kind == NodeErrorKind::kBusDown) return what(error);
  return fmt::format("node {} ({}): {}", error.id, name, what(error));
}

}  // namespace driveline::canopen
