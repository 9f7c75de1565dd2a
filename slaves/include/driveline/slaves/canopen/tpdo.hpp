#pragma once

#include "driveline/slaves/canopen/device_options.hpp"
#include "driveline/slaves/canopen/entry.hpp"
#include "driveline/slaves/canopen/outbox.hpp"

namespace driveline::slaves::cia301 {

/// A PDO that the device sends (1800h, 1A00h and following; CiA 301 7.2.2). Allocates only when it is constructed.
class Tpdo {
 public:
  /// Everything must outlive this. `number` counts from 0.
  Tpdo(ObjectDictionary& dictionary, std::size_t number, const DeviceOptions& options, Outbox& outbox);

  /// The device becomes operational: communication parameters and mapping are read, SYNCs and timers count from here,
  /// and there is an event, so that consumers get the first values. \rtsafe
  void start(nanoseconds now) noexcept;
  /// The device is not operational any more. \rtsafe
  void stop() noexcept { running_ = active_ = false; }
  /// Whether an entry of 18xxh may have this value. Error: kValueRange. \rtsafe
  [[nodiscard]] SdoResult<void> check(const EntryRow& row, std::uint32_t raw) const noexcept;
  /// The mapping or the communication parameters have changed. \rtsafe
  void written(const EntryRow& row, nanoseconds now) noexcept;
  /// An event of the application. \rtsafe
  void trigger(nanoseconds now) noexcept;
  /// Whether a SYNC concerns it. \rtsafe
  [[nodiscard]] bool waits_for_sync() const noexcept { return active_ && synchronous(); }
  /// Whether other values are an event. \rtsafe
  [[nodiscard]] bool waits_for_events() const noexcept {
    return active_ && (type_ == kAcyclicSynchronous || type_ > kRemoteEvent);
  }
  /// An event when a bit under `mask` is another one than in the last message. \rtsafe
  void watch(std::uint64_t mask, nanoseconds now) noexcept;
  /// A SYNC: types 0 to 240 and 252 take their values now. \rtsafe
  void sync(nanoseconds now) noexcept;
  /// Answers a remote frame of this PDO; false: it is none. \rtsafe
  bool remote(const Frame& frame, nanoseconds now) noexcept;
  /// Sends what timers have made due, where it waits_for_events(). \rtsafe
  void advance(nanoseconds now) noexcept;
  /// When advance() has something to do. \rtsafe
  [[nodiscard]] nanoseconds next_wake() const noexcept;

 private:
  using Data = std::array<std::byte, Frame::kMaxLength>;

  // Transmission types (CiA 301 Table 72).
  static constexpr std::uint32_t kAcyclicSynchronous = 0;
  static constexpr std::uint32_t kLastCyclic = 240;
  static constexpr std::uint32_t kRemoteSynchronous = 252;
  static constexpr std::uint32_t kRemoteEvent = 253;

  [[nodiscard]] bool synchronous() const noexcept { return type_ <= kLastCyclic || type_ == kRemoteSynchronous; }
  [[nodiscard]] Data sample() const noexcept;
  void send(const Data& data, nanoseconds now) noexcept;
  void start_event_timer(nanoseconds now) noexcept;

  ObjectDictionary* dictionary_;
  Outbox* outbox_;
  const DeviceOptions* options_;
  std::uint16_t mapping_index_;
  Entry cob_id_;
  Entry type_entry_;
  Entry inhibit_time_;
  Entry event_time_;
  PdoMap map_;
  Data last_{};  ///< of the last message, or sampled at the last SYNC
  nanoseconds inhibited_until_{0};
  nanoseconds event_timer_ = kNever;
  canopen::Identifier identifier_;
  std::uint32_t type_ = 0;   ///< transmission type
  std::uint32_t syncs_ = 0;  ///< since the last message
  bool running_ = false;
  bool active_ = false;  ///< is running, exists, and maps something
  bool event_ = false;   ///< waits for the inhibit time or the next SYNC
};

}  // namespace driveline::slaves::cia301
