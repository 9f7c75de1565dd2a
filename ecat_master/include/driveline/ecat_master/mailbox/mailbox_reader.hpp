#pragma once

#include <array>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "driveline/ecat_master/bus/bus.hpp"
#include "driveline/ecat_master/mailbox/mailbox_window.hpp"

namespace driveline::ecat_master {

/// The status of a slave's mailbox to the master, as received with the process data (an FMMU maps the sync manager's
/// status byte).
struct MailboxStatusSample {
  bool full = false;        ///< the slave has put a message into it
  std::uint64_t cycle = 0;  ///< number of completed cycles when the status was taken
};

/// The receiving side of a slave's mailboxes: checks for a message, reads it, and requests it again when it was lost in
/// transit (ETG.1000.4 6.6.3). Used by MailboxChannel.
class MailboxReader {
 public:
  /// Result of an answer from the slave.
  enum class Found : std::uint8_t {
    kNothing,  ///< no news
    kStep,     ///< progress towards a message
    kMail,     ///< mail() holds a message
    kSilence,  ///< the slave no longer answers
  };

  /// `timeout`: longest time that an unreadable slave may block the reader. `idle_poll`: polling interval while no
  /// message is expected.
  MailboxReader(SlaveRef slave, const MailboxWindow& window, std::chrono::nanoseconds timeout,
                std::chrono::nanoseconds idle_poll);

  /// Makes the next append() poll the mailbox, whether or not a poll is due.
  void poll_now() noexcept;
  /// Current mailbox status from the process data; empty: the status is read with a separate datagram.
  void use_sample(std::optional<MailboxStatusSample> sample) noexcept;
  /// Whether nothing has been found in the mailbox since poll_now().
  [[nodiscard]] bool polled_empty() const noexcept { return fetch_ == Fetch::kPoll && next_idle_poll_.count() != 0; }
  /// Another message is likely to follow the last one: it is read without checking first.
  void expect_more() noexcept;
  /// Cancels the current operation.
  void reset() noexcept { fetch_ = Fetch::kPoll; }

  /// Appends the datagram that is needed now. `awaited`: a message is expected, so idle_poll does not apply. Returns
  /// false when none is needed.
  [[nodiscard]] bool append(std::chrono::nanoseconds now, bool awaited, std::vector<Request>& batch);
  /// Processes the answer to the datagram of append().
  [[nodiscard]] Found take(std::chrono::nanoseconds now, const Request& answer);
  /// Kind of datagram appended by append_ahead().
  enum class Ahead : std::uint8_t { kNothing, kPoll, kRead };
  /// Appends the datagram that is likely to be next, before the answer to the last append() is processed: a read when
  /// enough messages are `expected` that one remains after the one being read (`reading`), or when one is known to be
  /// there; else a status poll.
  [[nodiscard]] Ahead append_ahead(bool reading, std::size_t expected, std::vector<Request>& batch);
  /// Processes the answer to the datagram of append_ahead(), after all previous answers.
  [[nodiscard]] Found take_ahead(std::chrono::nanoseconds now, Ahead what, const Request& answer);
  /// Whether the process data report the mailbox status.
  [[nodiscard]] bool has_sample() const noexcept { return sample_.has_value(); }
  /// Whether the next append() reads a message.
  [[nodiscard]] bool reads() const noexcept { return fetch_ == Fetch::kRead || fetch_ == Fetch::kGuess; }
  /// Whether a message was lost in transit and is being requested again.
  [[nodiscard]] bool repeats() const noexcept { return !reads() && fetch_ != Fetch::kPoll; }
  /// After kMail: the mailbox content including the header.
  [[nodiscard]] std::span<const std::byte> mail() const noexcept { return mail_; }
  /// Number of messages requested again.
  [[nodiscard]] std::uint64_t repeated() const noexcept { return repeated_; }
  /// The register that shows whether the mailbox is full.
  [[nodiscard]] static std::uint16_t status_register() noexcept;

 private:
  enum class Fetch : std::uint8_t { kPoll, kRead, kGuess, kRepeatLook, kRepeatToggle, kRepeatWait };

  [[nodiscard]] bool wants_poll(std::chrono::nanoseconds now, bool awaited) noexcept;
  void append(wire::Command command, std::uint16_t address, std::span<std::byte> data, std::vector<Request>& batch);
  void append_read(std::vector<Request>& batch);
  void begin(Fetch fetch, std::chrono::nanoseconds now) noexcept;
  [[nodiscard]] Found take_status(std::chrono::nanoseconds now, bool touched);
  [[nodiscard]] Found take_read(std::chrono::nanoseconds now, const Request& answer);
  [[nodiscard]] Found take_repeat(std::chrono::nanoseconds now, bool touched);

  SlaveRef slave_;
  std::uint16_t address_;
  std::chrono::nanoseconds timeout_;
  std::chrono::nanoseconds idle_poll_;
  Fetch fetch_ = Fetch::kPoll;
  std::array<std::vector<std::byte>, 2> wire_;  ///< buffers for reads, used alternately: two may be in flight
  std::size_t side_ = 0;
  std::span<const std::byte> mail_;
  std::array<std::byte, 3> registers_{};             ///< status, activate, PDI control of sync manager 1
  std::array<std::array<std::byte, 1>, 2> polls_{};  ///< status bytes, used alternately
  bool repeat_bit_ = false;
  std::chrono::nanoseconds deadline_{0};
  std::chrono::nanoseconds repeat_deadline_{0};
  std::chrono::nanoseconds next_idle_poll_{0};
  std::optional<MailboxStatusSample> sample_;
  bool sample_is_old_ = false;     ///< the mailbox has been read since the sample was taken
  std::uint64_t sample_from_ = 0;  ///< first cycle whose sample is valid
  unsigned silent_ = 0;
  std::uint64_t repeated_ = 0;
};

}  // namespace driveline::ecat_master
