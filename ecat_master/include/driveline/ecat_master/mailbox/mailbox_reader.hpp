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

/// The status of a slave's mailbox to the master as it came with the process data (an FMMU maps the sync manager's
/// status byte).
struct MailboxStatusSample {
  bool full = false;        ///< the slave has put a mail into it
  std::uint64_t cycle = 0;  ///< cycles that were over when it was looked at
};

/// The way of one slave's mailboxes from the slave: looks whether there is a mail, reads it, and asks for it again when
/// it was lost on the way (ETG.1000.4 6.6.3). For MailboxChannel.
class MailboxReader {
 public:
  /// What an answer of the slave has brought.
  enum class Found : std::uint8_t {
    kNothing,  ///< no news
    kStep,     ///< one step on the way to a mail
    kMail,     ///< mail() holds one
    kSilence,  ///< the slave does not answer any more
  };

  /// `patience`: a slave that never lets itself be read does not hold the reader for longer. `idle_poll`: interval of
  /// the looks while nothing is awaited.
  MailboxReader(SlaveRef slave, const MailboxWindow& window, std::chrono::nanoseconds patience,
                std::chrono::nanoseconds idle_poll);

  /// The next append() looks into the mailbox, due or not.
  void poll_now() noexcept;
  /// What the process data say about the mailbox now; nothing: it is asked for with a datagram of its own.
  void use_sample(std::optional<MailboxStatusSample> sample) noexcept;
  /// Nothing has been found in the mailbox since poll_now().
  [[nodiscard]] bool polled_empty() const noexcept { return fetch_ == Fetch::kPoll && next_idle_poll_.count() != 0; }
  /// Another mail is likely to stand behind the last one: it is read without looking.
  void expect_more() noexcept;
  /// Forgets what it was about to do.
  void reset() noexcept { fetch_ = Fetch::kPoll; }

  /// Appends what is to be done now. `awaited`: a mail is expected, so idle_poll does not count. False: nothing.
  [[nodiscard]] bool append(std::chrono::nanoseconds now, bool awaited, std::vector<Request>& batch);
  /// Takes the answer to what append() has appended.
  [[nodiscard]] Found take(std::chrono::nanoseconds now, const Request& answer);
  /// What append_ahead() has appended.
  enum class Ahead : std::uint8_t { kNothing, kLook, kRead };
  /// Appends what is likely to be done next, before the answer to the last append() is taken: a read when so many
  /// mails are `expected` that one is left behind the one that is being read (`reading`), or when one is known to be
  /// there; else a look.
  [[nodiscard]] Ahead append_ahead(bool reading, std::size_t expected, std::vector<Request>& batch);
  /// Takes the answer to what append_ahead() has appended, behind those to everything before it.
  [[nodiscard]] Found take_ahead(std::chrono::nanoseconds now, Ahead what, const Request& answer);
  /// The process data tell whether there is a mail.
  [[nodiscard]] bool has_sample() const noexcept { return sample_.has_value(); }
  /// The next append() reads a mail.
  [[nodiscard]] bool reads() const noexcept { return fetch_ == Fetch::kRead || fetch_ == Fetch::kGuess; }
  /// A mail was lost on the way and is being asked for again.
  [[nodiscard]] bool repeats() const noexcept { return !reads() && fetch_ != Fetch::kPoll; }
  /// After kMail: the mailbox, header and all.
  [[nodiscard]] std::span<const std::byte> mail() const noexcept { return mail_; }
  /// Mails asked for again.
  [[nodiscard]] std::uint64_t repeated() const noexcept { return repeated_; }
  /// The register that tells whether the mailbox is full.
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
  std::chrono::nanoseconds patience_;
  std::chrono::nanoseconds idle_poll_;
  Fetch fetch_ = Fetch::kPoll;
  std::array<std::vector<std::byte>, 2> wire_;  ///< of reads by turns: two may be on their way
  std::size_t side_ = 0;
  std::span<const std::byte> mail_;
  std::array<std::byte, 3> registers_{};             ///< status, activate, PDI control of sync manager 1
  std::array<std::array<std::byte, 1>, 2> looks_{};  ///< status, by turns
  bool repeat_bit_ = false;
  std::chrono::nanoseconds deadline_{0};
  std::chrono::nanoseconds repeat_deadline_{0};
  std::chrono::nanoseconds next_idle_poll_{0};
  std::optional<MailboxStatusSample> sample_;
  bool sample_is_old_ = false;     ///< the mailbox has been read since it was taken
  std::uint64_t sample_from_ = 0;  ///< first cycle whose sample counts
  unsigned silent_ = 0;
  std::uint64_t repeated_ = 0;
};

}  // namespace driveline::ecat_master
