#pragma once

#include <vector>

#include "driveline/canopen_wire/nmt.hpp"
#include "driveline/slaves/canopen/entry.hpp"
#include "driveline/slaves/canopen/outbox.hpp"

namespace driveline::slaves::cia301 {

/// Heartbeat consumer (1016h, CiA 301 7.5.2.19): monitors other nodes from their first heartbeat on. Each entry stands
/// for itself; unused ones may be anywhere. Allocates only when it is constructed.
class HeartbeatConsumer {
 public:
  /// What has happened to a monitored node.
  enum class Event : std::uint8_t { kNone, kLost, kBack, kBootUp };

  /// The dictionary must outlive this.
  explicit HeartbeatConsumer(ObjectDictionary& dictionary);

  /// Forgets what has been received. \rtsafe
  void restart() noexcept;
  /// Whether 1016h may have this value: no node twice (CiA 301). Error: kParameterIncompatible. \rtsafe
  [[nodiscard]] SdoResult<void> check(const EntryRow& row, std::uint32_t raw) const noexcept;
  /// A new entry monitors from the next heartbeat on. \rtsafe
  void written(const EntryRow& row) noexcept;
  /// A heartbeat or boot-up message of `node`. \rtsafe
  [[nodiscard]] Event receive(std::uint8_t node, canopen::NmtState state, nanoseconds now) noexcept;
  /// One node whose time is over; kNone when there is no other. \rtsafe
  [[nodiscard]] Event advance(nanoseconds now) noexcept;
  /// When advance() has something to do. \rtsafe
  [[nodiscard]] nanoseconds next_wake() const noexcept;
  /// Whether any monitored node is lost. \rtsafe
  [[nodiscard]] bool any_lost() const noexcept;

 private:
  enum class State : std::uint8_t { kUnknown, kAlive, kLost };
  struct Monitor {
    Entry entry;
    State state = State::kUnknown;
    nanoseconds deadline = kNever;

    [[nodiscard]] std::uint8_t node() const noexcept { return static_cast<std::uint8_t>(entry.value() >> 16); }
    [[nodiscard]] nanoseconds time() const noexcept { return std::chrono::milliseconds{entry.value() & 0xFFFFU}; }
  };

  std::vector<Monitor> monitors_;
};

}  // namespace driveline::slaves::cia301
