#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "driveline/slaves/device.hpp"
#include "driveline/slaves/esc/esc.hpp"

namespace driveline::slaves {

/// Transfers mailbox messages between the two mailbox sync managers and the device, and retains sent messages for
/// repeat requests of the master (ETG.1000.4 6.6.3). Does not allocate after construction; run() is \rtsafe if the
/// device's mailbox functions are.
class MailboxTransport {
 public:
  /// Simulated faults of the mailbox.
  enum class Fault : std::uint8_t {
    kNone,
    kSilent,     ///< requests are accepted, no reply is ever sent
    kBusy,       ///< requests are not accepted: the master finds the mailbox full
    kMalformed,  ///< the length of replies is set to 3 bytes
    kOversized,  ///< the length of replies exceeds the mailbox
    kLate,       ///< replies are delayed
    kForeign,    ///< a message of an unknown protocol precedes each reply
  };

  /// Both references must outlive this. Allocates memory for the largest mailbox.
  MailboxTransport(Esc& esc, Device& device);

  /// Discards everything in flight.
  void reset() noexcept;
  /// Transfers mailbox messages in both directions if possible. To be called while the mailboxes are running.
  void run(std::chrono::nanoseconds now);
  /// Starts a fault; kNone ends it. `delay` applies to kLate.
  void set_fault(Fault fault, std::chrono::nanoseconds delay = {}) noexcept;

 private:
  void accept_request();
  void repeat_last();
  bool send_next(std::chrono::nanoseconds now);
  [[nodiscard]] bool fetch(std::chrono::nanoseconds now);
  void spoil() noexcept;
  bool publish(std::span<const std::byte> mail) noexcept;

  Esc& esc_;
  Device& device_;
  unsigned out_ = 0;  ///< sync manager that the master writes
  unsigned in_ = 0;   ///< sync manager that the master reads
  bool present_ = false;
  Fault fault_ = Fault::kNone;
  std::chrono::nanoseconds delay_{0};
  std::chrono::nanoseconds release_{0};  ///< time when held_ may be sent
  std::vector<std::byte> scratch_;
  std::vector<std::byte> last_;      ///< message published last
  std::vector<std::byte> previous_;  ///< message published before last_
  std::vector<std::byte> waiting_;   ///< displaced by a repetition, to be sent next
  std::vector<std::byte> held_;      ///< delayed by the fault, to be sent after waiting_
};

}  // namespace driveline::slaves
