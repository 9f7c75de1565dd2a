#include "recovery_deeds.hpp"

#include <algorithm>
#include <array>

namespace driveline::bus_test {
namespace {

using canopen::MasterEvent;
using canopen::NmtState;
using canopen::NodeErrorKind;
using Told = MasterEvent::Kind;
using std::chrono::milliseconds;
using std::chrono::nanoseconds;

/// Time after the end of a deed in which its consequences may be told: a node is missed after 60 ms, a boot that hangs
/// fails after 150 ms and is repeated after 60 ms, and a complete boot takes up to 550 ms.
constexpr nanoseconds kConsequences = milliseconds{800};

constexpr std::array<const char*, kDeedKinds> kDeedNames{
    "power off", "node bus off", "adapter bus off", "heartbeat lost", "master unheard", "reset",
    "stop",      "pre-op",       "silent SDO",      "other device",   "fault"};

/// Whether a deed is about the node of an event.
bool concerns(const Deed& deed, const MasterEvent& event) {
  if (deed.kind == DeedKind::kAdapterBusOff || deed.kind == DeedKind::kMasterUnheard) return true;
  return event.id != 0 && deed.node == event.node;
}

/// Whether the master hears nothing of the node.
bool silences(const Deed& deed) {
  switch (deed.kind) {
    case DeedKind::kPowerOff:
    case DeedKind::kNodeBusOff:
    case DeedKind::kAdapterBusOff:
    case DeedKind::kHeartbeatLost:
    case DeedKind::kOtherDevice:
      return true;
    default:
      return false;
  }
}

/// Whether the node starts anew.
bool restarts(const Deed& deed) {
  switch (deed.kind) {
    case DeedKind::kPowerOff:
    case DeedKind::kNodeBusOff:
    case DeedKind::kReset:
    case DeedKind::kSilentSdo:
    case DeedKind::kOtherDevice:
      return true;
    default:
      return false;
  }
}

bool names_other_device(const canopen::NodeError& error) {
  return error.kind == NodeErrorKind::kOtherDevice && error.object == canopen::SdoObject{0x1018, 4} &&
         error.found != error.wanted;
}

bool is_silence(const canopen::NodeError& error) {
  if (error.kind == NodeErrorKind::kAbsent || error.kind == NodeErrorKind::kNoGuarding) return true;
  return error.kind == NodeErrorKind::kRequestFailed && error.request &&
         error.request->kind == canopen::ClientErrorKind::kNoAnswer;
}

/// The codes of CiA 301 for the communication; of a drive, its fault 12 (MSD manual 13.1).
bool is_of_the_communication(const canopen::Emergency& emergency) {
  constexpr unsigned kCommunication = 0x81;
  constexpr std::uint16_t kOfTheDrive = 0xFF00;
  constexpr std::byte kFieldBus{12};
  return emergency.code >> 8U == kCommunication ||
         (emergency.code == kOfTheDrive && emergency.manufacturer[0] == kFieldBus);
}

}  // namespace

const char* to_text(DeedKind kind) noexcept {
  return kDeedNames.at(static_cast<std::size_t>(kind));
}

bool RecoveryDeeds::explains_failure(const Deed& deed, const canopen::NodeError& error) {
  switch (deed.kind) {
    case DeedKind::kOtherDevice:
      return names_other_device(error) || is_silence(error);
    case DeedKind::kHeartbeatLost:
      // The node is there, and the master does not hear that it has started.
      return is_silence(error) || error.kind == NodeErrorKind::kWrongState;
    case DeedKind::kAdapterBusOff:
      return is_silence(error) || error.kind == NodeErrorKind::kWrongState || error.kind == NodeErrorKind::kBusDown;
    case DeedKind::kPowerOff:
    case DeedKind::kNodeBusOff:
      return is_silence(error) || error.kind == NodeErrorKind::kWrongState;
    case DeedKind::kSilentSdo:
    case DeedKind::kStop:  // of a node that is being configured: no SDO in Stopped (CiA 301 7.3.2.2.4)
      return is_silence(error);
    default:
      return false;
  }
}

/// A drive tells of its fault; every node tells that it misses the master.
bool RecoveryDeeds::explains_emergency(const Deed& deed, const MasterEvent& event) const {
  if (deed.kind == DeedKind::kFault) return event.emergency.code == facts(deed.fault).error_code;
  if (!is_of_the_communication(event.emergency)) return false;
  switch (deed.kind) {
    case DeedKind::kNodeBusOff:
      return true;
    case DeedKind::kAdapterBusOff:
      return nodes_[event.node].hears_master || nodes_[event.node].guarded;
    case DeedKind::kMasterUnheard:
      return nodes_[event.node].hears_master;
    default:
      // Life guarding runs out while the node is asked nothing: it is lost, or its boot failed and is to be repeated.
      return nodes_[event.node].guarded &&
             (silences(deed) || deed.kind == DeedKind::kStop || deed.kind == DeedKind::kSilentSdo);
  }
}

bool RecoveryDeeds::explains(const Deed& deed, const MasterEvent& event) const {
  const bool by_other =
      deed.kind == DeedKind::kReset || deed.kind == DeedKind::kStop || deed.kind == DeedKind::kPreOperational;
  switch (event.kind) {
    case Told::kNodeLost:
      return silences(deed);
    case Told::kNodeRebooted:
      return restarts(deed);
    case Told::kWrongState:
      if (event.state == NmtState::kStopped) return deed.kind == DeedKind::kStop;
      if (event.state != NmtState::kPreOperational) return false;
      if (deed.kind == DeedKind::kPreOperational) return true;
      // A node that misses its master leaves Operational (1029h), as one does whose boot-up message was not heard.
      if (deed.kind == DeedKind::kMasterUnheard) return nodes_[event.node].hears_master;
      return silences(deed);
    case Told::kRecoveryFailed:
      return explains_failure(deed, event.error);
    case Told::kEmergency:
      return explains_emergency(deed, event);
    case Told::kGuardToggle:
      return nodes_[event.node].guarded && silences(deed);
    case Told::kOtherMaster:
      return by_other && event.other == canopen::OtherMasterSign::kNmt;
    case Told::kBusOff:
    case Told::kBusBack:
      return deed.kind == DeedKind::kAdapterBusOff;
    case Told::kDoubleAnswers:
      return deed.kind == DeedKind::kOtherDevice;
    default:
      return false;
  }
}

bool RecoveryDeeds::explains(const MasterEvent& event) const {
  // That something has ended is judged by what had begun.
  if (event.kind == Told::kNodeBack || event.kind == Told::kErrorReset) return true;
  return std::any_of(deeds_.begin(), deeds_.end(), [&](const Deed& deed) {
    const bool then = deed.begin <= event.time && event.time <= deed.end + kConsequences;
    return then && (event.id == 0 || concerns(deed, event)) && explains(deed, event);
  });
}

bool RecoveryDeeds::told(const Deed& deed, const History& since) {
  const auto tells = [&](Told kind, auto&& holds) {
    return std::any_of(since.begin(), since.end(), [&](const MasterEvent& event) {
      return event.kind == kind && concerns(deed, event) && holds(event);
    });
  };
  const auto any = [](const MasterEvent& /*event*/) { return true; };
  const auto state = [](NmtState wanted) {
    return [wanted](const MasterEvent& event) { return event.state == wanted; };
  };
  switch (deed.kind) {
    case DeedKind::kPowerOff:
    case DeedKind::kNodeBusOff:
    case DeedKind::kHeartbeatLost:
      return tells(Told::kNodeLost, any) && tells(Told::kNodeBack, any);
    case DeedKind::kAdapterBusOff:
      return tells(Told::kBusOff, any) && tells(Told::kBusBack, any) && tells(Told::kNodeLost, any);
    case DeedKind::kMasterUnheard:
      return tells(Told::kWrongState, state(NmtState::kPreOperational));
    case DeedKind::kReset:
      return tells(Told::kNodeRebooted, any) && tells(Told::kNodeBack, any);
    case DeedKind::kStop:
      return tells(Told::kWrongState, state(NmtState::kStopped)) && tells(Told::kNodeBack, any);
    case DeedKind::kPreOperational:
      return tells(Told::kWrongState, state(NmtState::kPreOperational)) && tells(Told::kNodeBack, any);
    case DeedKind::kSilentSdo:
      return tells(Told::kRecoveryFailed, [](const MasterEvent& event) { return is_silence(event.error); }) &&
             tells(Told::kNodeBack, any);
    case DeedKind::kOtherDevice:
      return tells(Told::kRecoveryFailed, [](const MasterEvent& event) { return names_other_device(event.error); }) &&
             tells(Told::kNodeBack, any);
    case DeedKind::kFault:
      return tells(Told::kEmergency,
                   [&](const MasterEvent& event) { return event.emergency.code == facts(deed.fault).error_code; });
    case DeedKind::kCount:
      break;
  }
  return false;
}

std::string RecoveryDeeds::text() const {
  std::string all;
  for (const auto& deed : deeds_) {
    const auto ms = [](nanoseconds time) {
      return std::to_string(std::chrono::duration_cast<milliseconds>(time).count());
    };
    all += "  " + ms(deed.begin) + " to " + ms(deed.end) + " ms: " + to_text(deed.kind) + ", node " +
           std::to_string(deed.node) + "\n";
  }
  return all;
}

}  // namespace driveline::bus_test
