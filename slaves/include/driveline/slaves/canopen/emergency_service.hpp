#pragma once

#include <vector>

#include "driveline/canopen_wire/emergency.hpp"
#include "driveline/slaves/canopen/entry.hpp"
#include "driveline/slaves/canopen/outbox.hpp"

namespace driveline::slaves::cia301 {

using canopen::Emergency;

/// EMCY producer with error register and error history (1001h, 1003h, 1014h, 1015h; CiA 301 7.2.7). Allocates only when
/// it is constructed.
class EmergencyService {
 public:
  /// Both must outlive this.
  EmergencyService(ObjectDictionary& dictionary, Outbox& outbox);

  /// Forgets messages that wait, and the errors of the sources from `first` to `last`, without a message. \rtsafe
  void forget(std::uint8_t first, std::uint8_t last) noexcept;
  /// Writes the error register again, after values of the dictionary were restored. \rtsafe
  void update_register() noexcept;
  /// An error occurs: register bits, history, one message. `source` tells errors of the same code apart; one that is
  /// there already is no new event. \rtsafe
  void raise(const Emergency& emergency, std::uint8_t source, bool allowed, nanoseconds now) noexcept;
  /// An error has gone. With the last one the message 0000h is sent, which is no error itself: it is not in the
  /// history. \rtsafe
  void clear(std::uint16_t code, std::uint8_t source, bool allowed, nanoseconds now) noexcept {
    if (!errors_.empty()) remove(code, source, allowed, now);
  }
  /// Whether 1003h:00 or 1014h may have this value. Error: kValueRange. \rtsafe
  [[nodiscard]] SdoResult<void> check(const EntryRow& row, std::uint32_t raw) const noexcept;
  /// Clears the history when 0 was written to 1003h:00. \rtsafe
  void written(const EntryRow& row) noexcept;
  /// Sends the message that is due. Nothing is sent while the NMT state does not allow it; it waits. \rtsafe
  void advance(bool allowed, nanoseconds now) noexcept;
  /// When advance() has something to do. \rtsafe
  [[nodiscard]] nanoseconds next_wake(bool allowed) const noexcept;

 private:
  static constexpr std::size_t kErrors = 16;  ///< errors at the same time
  static constexpr std::size_t kWaiting = 8;  ///< messages that wait for the inhibit time
  struct Error {
    std::uint16_t code;
    std::uint8_t source;
    std::uint8_t register_bits;
  };

  void send(const Emergency& emergency, bool allowed, nanoseconds now) noexcept;
  void remove(std::uint16_t code, std::uint8_t source, bool allowed, nanoseconds now) noexcept;
  void log(const Emergency& emergency) noexcept;
  [[nodiscard]] nanoseconds inhibit() const noexcept { return std::chrono::microseconds{100 * inhibit_time_.value()}; }

  Outbox* outbox_;
  Entry register_;
  Entry history_count_;
  std::vector<Entry> history_;  ///< newest first
  Entry cob_id_;
  Entry inhibit_time_;
  std::vector<Error> errors_;
  std::vector<Emergency> waiting_;
  nanoseconds free_at_{0};  ///< end of the inhibit time
};

}  // namespace driveline::slaves::cia301
