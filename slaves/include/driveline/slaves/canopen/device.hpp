#pragma once

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
  /// Stored parameters.
  [[nodiscard]] Store& store() noexcept { return store_; }
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

  [[nodiscard]] SdoResult<void> accept(const EntryRow& row, std::uint64_t raw) override;
  void written(const EntryRow& row) override;
  [[nodiscard]] bool power_stage_on() const noexcept override { return application_->power_stage_on(); }

  void reset(Reset reset, nanoseconds now);
  void nmt(const Frame& frame, nanoseconds now);
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

  ObjectDictionary* dictionary_;
  Application* application_;
  DeviceOptions options_;
  Outbox outbox_;
  NmtMachine nmt_;
  ErrorControlService error_control_;
  HeartbeatConsumer heartbeats_;
  SyncService sync_;
  EmergencyService emergency_;
  SdoServer sdo_;
  Store store_;
  PdoService pdos_;
  Entry time_cob_id_;
  Entry error_behaviour_;
  std::uint8_t node_id_ = 0;
  bool start_pending_ = false;  ///< power has come
  bool bus_off_ = false;
  nanoseconds now_{0};  ///< of the call under way, for what a write of an object starts
};

}  // namespace driveline::slaves::cia301
