#pragma once

#include "driveline/slaves/canopen/application.hpp"
#include "driveline/slaves/canopen/emergency_service.hpp"
#include "driveline/slaves/canopen/rpdo.hpp"
#include "driveline/slaves/canopen/tpdo.hpp"

namespace driveline::slaves::cia301 {

/// All PDOs of a device. They exist from start() to stop(), which is in Operational only. Allocates only when it is
/// constructed.
class PdoService {
 public:
  /// First of the numbers by which the EMCYs of different RPDOs differ.
  static constexpr std::uint8_t kFirstSource = 3;

  /// Everything must outlive this.
  PdoService(ObjectDictionary& dictionary, Application& application, EmergencyService& emergency,
             const DeviceOptions& options, Outbox& outbox);

  /// The device becomes operational.
  void start(nanoseconds now) noexcept;
  /// The device is not operational any more; what waits for a SYNC is dropped.
  void stop() noexcept;
  /// Whether an entry of PDO communication or mapping may have this value.
  [[nodiscard]] SdoResult<void> check(const EntryRow& row, std::uint64_t raw) const;
  /// An entry of the dictionary was written.
  void written(const EntryRow& row, nanoseconds now) noexcept;
  /// A frame that may be an RPDO, or the remote frame of a TPDO.
  void receive(const Frame& frame, nanoseconds now);
  /// RPDOs that wait for a SYNC are applied.
  void apply(nanoseconds now) { apply(true, now); }
  /// Synchronous TPDOs are sampled.
  void sample(nanoseconds now) noexcept;
  /// An event of a TPDO, counted from 0.
  void trigger(std::size_t tpdo, nanoseconds now) noexcept;
  /// Compares the values of the TPDOs with the last messages.
  void watch(nanoseconds now) noexcept;
  /// Applies and sends what is due.
  void advance(nanoseconds now);
  /// When advance() has something to do.
  [[nodiscard]] nanoseconds next_wake() const noexcept;

 private:
  /// Places of PDOs among those of their direction. A cycle touches no others: most of its time is memory that is not
  /// in the cache.
  using Places = std::vector<std::uint16_t>;
  /// An RPDO that exists and maps something.
  struct Consumed {
    canopen::Identifier identifier;
    std::uint16_t place = 0;
  };

  void select() noexcept;
  void judge(std::size_t number, Rpdo::Result result, nanoseconds now);
  void apply(bool synchronous, nanoseconds now);
  void plan_cycle(nanoseconds now) noexcept;

  ObjectDictionary* dictionary_;
  Application* application_;
  EmergencyService* emergency_;
  const DeviceOptions* options_;
  std::vector<Rpdo> rpdos_;
  std::vector<Tpdo> tpdos_;
  std::vector<Consumed> rpdos_in_use_;
  Places tpdos_with_sync_;      ///< exist, map something, and a SYNC concerns them
  Places tpdos_with_events_;    ///< and those that other values, or a timer, concern
  nanoseconds cycle_ = kNever;  ///< when event-driven RPDOs that wait are applied
  bool running_ = false;
};

}  // namespace driveline::slaves::cia301
