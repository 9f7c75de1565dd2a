#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "driveline/slaves/device.hpp"
#include "driveline/slaves/esc/esc.hpp"

namespace driveline::slaves {

/// Carries mailboxes between the two mailbox sync managers and the device, and keeps what it has sent so that the
/// master may ask for it again (repeat request, ETG.1000.4 6.6.3). Allocates nothing after construction; run() is
/// \rtsafe as far as the device's mailbox functions are.
class MailboxTransport {
 public:
  /// Faults of the mailbox a test can stage.
  enum class Fault : std::uint8_t {
    kNone,
    kSilent,     ///< requests are taken, no reply is ever sent
    kBusy,       ///< requests are not taken: the master finds the mailbox full
    kMalformed,  ///< replies end behind the third byte of their service
    kOversized,  ///< replies say that they are longer than the mailbox
    kLate,       ///< replies are held back for a while
    kForeign,    ///< a mail of a protocol that nobody knows comes ahead of each reply
  };

  /// Both must outlive this. Allocates room for the largest mailbox.
  MailboxTransport(Esc& esc, Device& device);

  /// Forgets everything in flight.
  void reset() noexcept;
  /// Transfers mailboxes in both directions as far as possible. To be called while the mailboxes are running.
  void run(std::chrono::nanoseconds now);
  /// From now on; kNone ends it. `delay`: of kLate.
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
  unsigned out_ = 0;  ///< sync manager the master writes
  unsigned in_ = 0;   ///< sync manager the master reads
  bool present_ = false;
  Fault fault_ = Fault::kNone;
  std::chrono::nanoseconds delay_{0};
  std::chrono::nanoseconds release_{0};  ///< of held_
  std::vector<std::byte> scratch_;
  std::vector<std::byte> last_;      ///< published last
  std::vector<std::byte> previous_;  ///< published before that
  std::vector<std::byte> waiting_;   ///< displaced by a repetition, to be sent next
  std::vector<std::byte> held_;      ///< held back by the fault, to be sent behind that
};

}  // namespace driveline::slaves
