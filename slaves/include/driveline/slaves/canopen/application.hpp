#pragma once

#include "driveline/canopen_wire/nmt.hpp"
#include "driveline/canopen_wire/sync.hpp"
#include "driveline/slaves/can/node.hpp"
#include "driveline/slaves/od/object_dictionary.hpp"

namespace driveline::slaves::cia301 {

using can::nanoseconds;

/// What starts the initialisation of a device.
enum class Reset : std::uint8_t {
  kPowerOn,        ///< the first one
  kNode,           ///< application and communication
  kCommunication,  ///< communication only
};

/// Failures of the communication, and their end.
enum class CommunicationEvent : std::uint8_t {
  kHeartbeatLost,      ///< of a monitored node (1016h)
  kHeartbeatBack,      ///< of the same node
  kMonitoredNodeBoot,  ///< a monitored node has started again
  kLifeGuardingLost,   ///< no remote frame of the master within the life time
  kLifeGuardingBack,   ///< a remote frame of the master again
  kBusOff,             ///< the CAN controller takes no part in the bus
  kBusRecovered,       ///< it takes part again
};

/// What is behind the communication of a device: a drive. Called on the thread that advances the bus.
class Application : public DictionaryOwner {
 public:
  /// Node-ID that counts from this reset on, 1 to 127; any other: the device stays off the bus, without boot-up.
  [[nodiscard]] virtual std::uint8_t node_id(Reset reset) = 0;
  /// Bit rate that counts from this reset on, in bit/s; 0: as it is.
  [[nodiscard]] virtual std::uint32_t bit_rate(Reset reset);
  /// The application starts again; its entries of the dictionary have the stored values. An application that stores by
  /// itself (DeviceOptions::stores) restores all of them here.
  virtual void restart(Reset reset, nanoseconds now);
  /// Restores the stored values of 1000h to 1FFFh, where the application stores by itself.
  virtual void restore_communication();
  /// Time from restart() to the boot-up message, during which the device is silent.
  [[nodiscard]] virtual nanoseconds start_up_time() const noexcept;
  /// Brings the application to this time: called when next_wake() has come, and before PDOs write or read its values.
  virtual void advance(nanoseconds now);
  /// When advance() must be called again; kNever for never.
  [[nodiscard]] virtual nanoseconds next_wake() const noexcept;
  /// Whether an NMT start is obeyed now. CiA 301 asks no more than that the node is initialised.
  [[nodiscard]] virtual bool may_start() const noexcept;
  /// The NMT state is another one.
  virtual void state_changed(canopen::NmtState state, nanoseconds now);
  /// A SYNC: RPDOs of types 0 to 240 are applied, synchronous TPDOs are sampled behind this call.
  virtual void sync(std::uint8_t counter, nanoseconds now);
  /// A frame of this RPDO, counted from 0, has come; it may wait for a SYNC.
  virtual void rpdo_received(std::size_t number, nanoseconds now);
  /// The values of this RPDO, counted from 0, have been applied.
  virtual void rpdo_applied(std::size_t number, nanoseconds now);
  /// The time of day was set by a TIME message.
  virtual void time(const canopen::TimeOfDay& time, nanoseconds now);
  /// A failure of the communication or its end.
  virtual void communication(CommunicationEvent event, nanoseconds now);
  /// Bits of a TPDO, in the order of its bytes, whose change is an event.
  [[nodiscard]] virtual std::uint64_t event_mask(std::size_t tpdo) const noexcept;
  /// Keeps the stored values beyond the end of the process; false: it cannot, the write is answered with 06060000h.
  [[nodiscard]] virtual bool keep(const ObjectDictionary& stored);
};

}  // namespace driveline::slaves::cia301
