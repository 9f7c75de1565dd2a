#pragma once

#include <optional>

#include "driveline/canopen_wire/sync.hpp"
#include "driveline/slaves/canopen/entry.hpp"
#include "driveline/slaves/canopen/outbox.hpp"

namespace driveline::slaves::cia301 {

/// SYNC consumer and producer (1005h, 1006h, 1019h; CiA 301 7.2.5). \rtsafe throughout.
class SyncService {
 public:
  /// Both must outlive this.
  SyncService(ObjectDictionary& dictionary, Outbox& outbox) noexcept;

  /// Starts the counter again; a producer sends its first SYNC one period later.
  void restart(nanoseconds now) noexcept;
  /// Whether 1005h, 1006h or 1019h may have this value. Errors: kValueRange: the identifier is locked while bit 30 is
  /// set, or the counter overflow is 1 or above 240; kDeviceState: the overflow is locked while 1006h is not 0;
  /// kValueTooLow: no bus has room for this period.
  [[nodiscard]] SdoResult<void> check(const EntryRow& row, std::uint32_t raw) const noexcept;
  /// Starts or stops to produce.
  void written(const EntryRow& row, nanoseconds now) noexcept;
  /// The SYNC in this frame: empty when it is none, or has the wrong length, which is counted.
  [[nodiscard]] std::optional<canopen::Sync> receive(const Frame& frame) noexcept;
  /// Produces the SYNC that is due and returns it.
  [[nodiscard]] std::optional<canopen::Sync> advance(nanoseconds now) noexcept;
  /// When advance() has something to do.
  [[nodiscard]] nanoseconds next_wake() const noexcept { return next_; }
  /// SYNCs of the wrong length.
  [[nodiscard]] std::uint64_t ignored() const noexcept { return ignored_; }

 private:
  void schedule(nanoseconds now) noexcept;

  Outbox* outbox_;
  Entry cob_id_;
  Entry period_;
  Entry overflow_;
  nanoseconds next_ = kNever;
  std::uint8_t counter_ = 0;
  std::uint64_t ignored_ = 0;
};

}  // namespace driveline::slaves::cia301
