#pragma once

#include <optional>

#include "driveline/slaves/canopen/application.hpp"
#include "driveline/slaves/canopen/error_control.hpp"
#include "driveline/slaves/canopen/heartbeat_consumer.hpp"
#include "driveline/slaves/canopen/nmt_machine.hpp"
#include "driveline/slaves/canopen/pdo_service.hpp"
#include "driveline/slaves/canopen/sdo_server.hpp"
#include "driveline/slaves/canopen/store.hpp"
#include "driveline/slaves/canopen/sync_service.hpp"

namespace driveline::slaves::cia301 {

/// A CANopen device (CiA 301): the services of one object dictionary as a node of a bus. Services whose objects the
/// table does not have are not there. Allocates only when it is constructed.
class Device final : public can::Node, private DictionaryOwner {
 public:
  /// Everything must outlive this.
  Device(ObjectDictionary& dictionary, Application& application, const DeviceOptions& options = {});

  /// Starts the device as after power-on, at the time of the next advance().
  void power_on();
  /// Resets the communication like the NMT command, at the time of the next advance().
  void restart_communication() noexcept;
  /// An error of the application: see EmergencyService::raise().
  void raise(const Emergency& emergency, nanoseconds now);
  /// The error with this code has gone.
  void clear(std::uint16_t code, nanoseconds now);
  /// An event of a TPDO, counted from 0.
  void trigger(std::size_t tpdo, nanoseconds now) { pdos_.trigger(tpdo, now); }
  /// Compares the values of the TPDOs with the last messages; the application calls it when its values may have
  /// changed.
  void watch(nanoseconds now) { pdos_.watch(now); }

  /// NMT state. \rtsafe
  [[nodiscard]] NmtState state() const noexcept { return nmt_.state(); }
  /// Enters another state of a device that has started: what a drive does by itself. \rtsafe
  void enter(NmtState state, nanoseconds now);
  /// Node-ID in use; 0: the device is not on the bus. \rtsafe
  [[nodiscard]] std::uint8_t node_id() const noexcept { return node_id_; }
  /// Whether a failure of the communication persists: the event is the one that began it. \rtsafe
  [[nodiscard]] bool persists(CommunicationEvent event) const noexcept;
  /// The CAN controller; nullptr before the device is on a bus. \rtsafe
  [[nodiscard]] can::Controller* controller() const noexcept { return outbox_.controller(); }
  /// Time of the call under way, or of the last one. \rtsafe
  [[nodiscard]] nanoseconds now() const noexcept { return now_; }
  /// Stored parameters. Precondition: DeviceOptions::stores.
  [[nodiscard]] Store& store() noexcept { return *store_; }
  /// Messages that were ignored for their length, command or node. \rtsafe
  [[nodiscard]] std::uint64_t ignored() const noexcept { return nmt_.ignored() + sdo_.ignored() + sync_.ignored(); }

  void connected(can::Controller& controller) override;
  void receive(const Frame& frame, nanoseconds now) override;
  void advance(nanoseconds now) override;
  [[nodiscard]] nanoseconds next_wake() const noexcept override;
  void transmitted(const Frame& frame, nanoseconds now) override;
  void error_state_changed(can::ErrorState state, nanoseconds now) override;

 private:
  static constexpr std::uint8_t kApplicationSource = 0;  ///< of errors in EmergencyService
  static constexpr std::uint8_t kStackSource = 1;        ///< of errors of the communication as a whole
  static constexpr std::uint8_t kGuardingSource = 2;     ///< of life guarding
  static constexpr std::uint8_t kLastSource = 0xFF;      ///< behind those of the PDOs

  [[nodiscard]] SdoResult<void> accept(const EntryRow& row, std::uint64_t raw) override;
  void written(const EntryRow& row) override;
  [[nodiscard]] bool power_stage_on() const noexcept override { return application_->power_stage_on(); }

  void reset(Reset reset, nanoseconds now);
  void restart_controller(Reset reset) noexcept;
  void restore(Reset reset, nanoseconds now);
  /// Whether EMCY messages may leave: the boot-up message, whose identifier is beaten by theirs, is the first one.
  [[nodiscard]] bool tells_errors() const noexcept { return nmt_.configurable() && announced_; }
  void boot_up(nanoseconds now);
  void receive_nmt(const Frame& frame, nanoseconds now);
  void nmt(const Frame& frame, nanoseconds now);
  void obey_nmt(nanoseconds now);
  void state_changed(nanoseconds now);
  void sdo(const Frame& frame, nanoseconds now);
  void answer_sdo(const SdoBytes& answer, nanoseconds now);
  void sync(const canopen::Sync& sync, nanoseconds now);
  void receive_error_control(const Frame& frame, nanoseconds now);
  void monitored(HeartbeatConsumer::Event event, nanoseconds now);
  void guarded(ErrorControlService::Event event, nanoseconds now);
  void communication_failed(CommunicationEvent event, nanoseconds now);
  void receive_time(const Frame& frame, nanoseconds now);
  void raise_stack_error(std::uint16_t code, std::uint8_t source, nanoseconds now);
  void raise_failure(std::uint16_t code, std::uint8_t source, nanoseconds now);

  ObjectDictionary* dictionary_;
  Application* application_;
  DeviceOptions options_;
  Outbox outbox_;
  NmtMachine nmt_;
  NmtQueue nmt_queue_;
  ErrorControlService error_control_;
  HeartbeatConsumer heartbeats_;
  SyncService sync_;
  EmergencyService emergency_;
  SdoServer sdo_;
  std::optional<Store> store_;
  PdoService pdos_;
  Entry time_cob_id_;
  Entry error_behaviour_;
  std::uint8_t node_id_ = 0;
  std::uint8_t next_node_id_ = 0;    ///< counts from the boot-up message on
  nanoseconds boot_up_at_ = kNever;  ///< end of the initialisation
  std::optional<Reset> pending_;     ///< a reset that begins with the next advance()
  nanoseconds obey_at_ = kNever;     ///< when NMT requests that wait are obeyed
  bool announced_ = true;            ///< no boot-up message waits
  bool bus_off_ = false;
  nanoseconds now_{0};  ///< of the call under way, for what a write of an object starts
};

}  // namespace driveline::slaves::cia301
