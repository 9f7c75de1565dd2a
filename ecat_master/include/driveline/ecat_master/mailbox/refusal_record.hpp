#pragma once

#include <chrono>
#include <cstdint>

#include "driveline/wire/mailbox.hpp"

namespace driveline::ecat_master {

/// Decides when the master answers messages of a slave that it cannot process. Slaves whose firmware answers each error
/// reply with the next request or with an error reply must not keep the master busy.
///
/// Everything is \rtsafe.
class RefusalRecord {
 public:
  /// Notes that the master has sent a request in this protocol: late answers in it are no requests.
  void note_request(wire::MailboxType type) noexcept { requested_ |= bit_of(type); }

  /// Whether the master has sent a request in this protocol.
  [[nodiscard]] bool has_requested(wire::MailboxType type) const noexcept { return (requested_ & bit_of(type)) != 0; }
  /// Whether a message of this protocol, which the master does not support, is answered: once per protocol, because a
  /// slave that continues has not understood.
  [[nodiscard]] bool refuses_protocol(wire::MailboxType type) noexcept {
    const bool first = (refused_ & bit_of(type)) == 0;
    refused_ |= bit_of(type);
    return first;
  }

  /// Whether a request of the slave is refused now: at most one in kPause.
  [[nodiscard]] bool refuses_request(std::chrono::nanoseconds now) noexcept {
    if (now < next_) return false;
    next_ = now + kPause;
    return true;
  }

  /// Notes that the slave has taken an error reply.
  void note_sent(std::chrono::nanoseconds now) noexcept { echo_until_ = now + kEchoTime; }
  /// Whether an error reply of the slave answers an error reply of the master.
  [[nodiscard]] bool is_echo(std::chrono::nanoseconds now, wire::MailboxErrorCode code) const noexcept {
    return now < echo_until_ && code == wire::MailboxErrorCode::kUnsupportedProtocol;
  }

  /// Slaves that answer an error reply with an error reply do so within this time.
  static constexpr std::chrono::milliseconds kEchoTime{20};

 private:
  /// A slave that takes an error reply as the occasion for its next request gets the next reply after this time.
  static constexpr std::chrono::milliseconds kPause{100};

  [[nodiscard]] static constexpr std::uint16_t bit_of(wire::MailboxType type) noexcept {
    return static_cast<std::uint16_t>(1U << (static_cast<unsigned>(type) & 0x0FU));
  }

  std::uint16_t requested_ = 0;  ///< one bit per protocol
  std::uint16_t refused_ = 0;    ///< one bit per protocol
  std::chrono::nanoseconds echo_until_{0};
  std::chrono::nanoseconds next_{0};  ///< earliest time of the next refusal of a request
};

}  // namespace driveline::ecat_master
