#pragma once

#include "driveline/canopen_wire/nmt.hpp"
#include "driveline/slaves/canopen/entry.hpp"
#include "driveline/slaves/canopen/outbox.hpp"

namespace driveline::slaves::cia301 {

/// Error control of a device: heartbeat producer (1017h), answers to guarding, life guarding (100Ch, 100Dh); CiA 301
/// 7.2.8.2.2. \rtsafe throughout.
class ErrorControlService {
 public:
  /// What has happened to life guarding.
  enum class Event : std::uint8_t { kNone, kLost, kBack };

  /// Both must outlive this.
  ErrorControlService(ObjectDictionary& dictionary, Outbox& outbox) noexcept;

  /// The boot-up message has just been sent: it is the first heartbeat. Toggle bit and life guarding start again.
  void restart(canopen::Identifier identifier, nanoseconds now) noexcept;
  /// A heartbeat is due at once when 1017h is written; with 0 they end.
  void written(const EntryRow& row, canopen::NmtState state, nanoseconds now) noexcept;
  /// A remote frame of the master: is answered unless there is a heartbeat, and begins life guarding.
  [[nodiscard]] Event remote(canopen::NmtState state, nanoseconds now) noexcept;
  /// Sends the heartbeat that is due, and ends the life time.
  [[nodiscard]] Event advance(canopen::NmtState state, nanoseconds now) noexcept;
  /// When advance() has something to do.
  [[nodiscard]] nanoseconds next_wake() const noexcept { return std::min(heartbeat_, life_end_); }
  /// Whether the life time is over and no remote frame has come since.
  [[nodiscard]] bool lost() const noexcept { return life_lost_; }
  /// Identifier of heartbeat and guarding.
  [[nodiscard]] canopen::Identifier identifier() const noexcept { return identifier_; }

 private:
  [[nodiscard]] nanoseconds period() const noexcept { return std::chrono::milliseconds{producer_time_.value()}; }
  void send(canopen::NmtState state, bool toggle) noexcept;

  Outbox* outbox_;
  Entry producer_time_;
  Entry guard_time_;
  Entry life_time_factor_;
  canopen::Identifier identifier_;
  nanoseconds heartbeat_ = kNever;  ///< the next one
  nanoseconds life_end_ = kNever;   ///< when the life time ends
  bool life_lost_ = false;
  bool toggle_ = false;
};

}  // namespace driveline::slaves::cia301
