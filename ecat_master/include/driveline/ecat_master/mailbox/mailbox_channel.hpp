#pragma once

#include <deque>
#include <functional>
#include <memory>
#include <optional>
#include <vector>

#include "driveline/ecat_master/bus/bus.hpp"
#include "driveline/ecat_master/mailbox/dialogue.hpp"

namespace driveline::ecat_master {

/// Patience with the mailboxes of one slave; none: as for all (MailboxChannel::Settings).
struct MailboxTimeouts {
  std::optional<std::chrono::nanoseconds> request;   ///< until it takes a mailbox
  std::optional<std::chrono::nanoseconds> response;  ///< until it answers
  constexpr bool operator==(const MailboxTimeouts&) const = default;
};

/// Where a slave has its mailboxes: sync manager 0 (to the slave) and 1 (from the slave).
struct MailboxWindow {
  std::uint16_t out_address = 0;  ///< of the master's mails, in the slave's memory
  std::uint16_t out_length = 0;   ///< bytes
  std::uint16_t in_address = 0;   ///< of the slave's mails, in the slave's memory
  std::uint16_t in_length = 0;    ///< bytes
  MailboxTimeouts timeouts{};     ///< of this slave
  std::uint8_t last_counter = 0;  ///< of the last mail it has had, 1 to 7; 0: none since INIT
  constexpr bool operator==(const MailboxWindow&) const = default;
};

/// The status of a slave's mailbox to the master as it came with the process data (an FMMU maps the sync manager's
/// status byte).
struct MailboxStatusSample {
  bool full = false;        ///< the slave has put a mail into it
  std::uint64_t cycle = 0;  ///< cycles that were over when it was looked at
};

/// What a channel has seen.
struct MailboxStatistics {
  std::uint64_t sent = 0;       ///< mails to the slave
  std::uint64_t received = 0;   ///< mails from the slave
  std::uint64_t repeated = 0;   ///< replies asked for again because they were lost on the way
  std::uint64_t malformed = 0;  ///< header or length that cannot be
  std::uint64_t unclaimed = 0;  ///< mails that nobody waited for
  std::uint64_t refused = 0;    ///< mails of protocols that nobody knows
  std::uint64_t timeouts = 0;   ///< dialogues that got no answer in time
};

/// The mailboxes of one slave: carries out one dialogue after the other, in the order of their priorities. It never
/// waits; each step contributes the datagrams it needs now to a batch that travels for all slaves together, and takes
/// the answers. Counter, polling of the sync manager's status, and repetition of replies that were lost on the wire as
/// in ETG.1000.4 5.6 and 6.6.3.
///
/// One thread at a time; see MailboxEngine.
class MailboxChannel {
 public:
  /// Patience with the slave.
  struct Settings {
    std::chrono::nanoseconds reply_timeout = std::chrono::seconds{2};  ///< for each answer
    /// A mailbox error reply names no request: the awaited answer may still come this long.
    std::chrono::nanoseconds error_grace = std::chrono::milliseconds{50};
    std::chrono::nanoseconds idle_poll = std::chrono::milliseconds{10};  ///< for what slaves send unasked
  };
  /// Mails that no dialogue waits for. False: of a protocol that nobody knows.
  using Deliver = std::function<bool(SlaveRef, wire::MailboxType, std::span<const std::byte> service)>;
  /// Dialogues that are over.
  using Finished = std::vector<std::shared_ptr<MailboxDialogue>>;

  /// `window`: of the sync managers that are set up for it.
  MailboxChannel(SlaveRef slave, MailboxWindow window, Settings settings);

  /// Puts a dialogue into the queue, behind those of the same priority.
  void submit(std::shared_ptr<MailboxDialogue> dialogue);
  /// True while a dialogue is in progress or waiting.
  [[nodiscard]] bool busy() const noexcept { return active_ != nullptr || !queue_.empty(); }
  /// The next prepare() looks into the mailbox, due or not.
  void poll_now() noexcept {
    next_idle_poll_ = {};
    sample_is_old_ = true;
  }
  /// What the process data say about the mailbox now; nothing: it is asked for with a datagram of its own.
  void use_sample(std::optional<MailboxStatusSample> sample) noexcept;
  /// Nothing has been found in the mailbox since poll_now().
  [[nodiscard]] bool polled_empty() const noexcept { return fetch_ == Fetch::kPoll && next_idle_poll_.count() != 0; }

  /// Appends what this slave needs now to `batch`; dialogues that cannot even begin go to `finished`.
  void prepare(std::chrono::nanoseconds now, std::vector<Request>& batch, Finished& finished);
  /// Takes the answers to what prepare() has appended. True: something has moved on, no need to pause.
  bool evaluate(std::chrono::nanoseconds now, std::span<const Request> answers, const Deliver& deliver,
                Finished& finished);
  /// Ends all dialogues with `error`.
  void fail_all(Error error, Finished& finished);

  /// Whose mailboxes these are.
  [[nodiscard]] SlaveRef slave() const noexcept { return slave_; }
  /// Where they are.
  [[nodiscard]] const MailboxWindow& window() const noexcept { return window_; }
  /// Service bytes that fit into one mailbox to the slave.
  [[nodiscard]] std::size_t max_service() const noexcept;
  /// Since the channel was opened.
  [[nodiscard]] const MailboxStatistics& statistics() const noexcept { return statistics_; }

 private:
  [[nodiscard]] std::chrono::nanoseconds request_timeout() const noexcept;
  /// Of the dialogue in progress.
  [[nodiscard]] std::chrono::nanoseconds reply_timeout() const noexcept;
  enum class Fetch : std::uint8_t { kPoll, kRead, kRepeatLook, kRepeatToggle, kRepeatWait };

  [[nodiscard]] bool wants_poll(std::chrono::nanoseconds now) noexcept;
  void start_next(std::chrono::nanoseconds now, Finished& finished);
  [[nodiscard]] bool load_outgoing(std::chrono::nanoseconds now);
  bool take_written(std::chrono::nanoseconds now, const Request& answer, Finished& finished);
  bool take_fetched(std::chrono::nanoseconds now, const Request& answer, const Deliver& deliver, Finished& finished);
  void take_mail(std::chrono::nanoseconds now, const Deliver& deliver, Finished& finished);
  void refuse(wire::MailboxType type);
  void resume(std::chrono::nanoseconds now, Finished& finished);
  void take_error(std::chrono::nanoseconds now, std::span<const std::byte> service, Finished& finished);
  void react(std::chrono::nanoseconds now, MailboxDialogue::Reaction reaction, Finished& finished);
  void look_at_clock(std::chrono::nanoseconds now, Finished& finished);
  void finish(Finished& finished);
  void finish(Finished& finished, const Error& error);
  [[nodiscard]] Error error(ErrorFacts facts) const noexcept;

  SlaveRef slave_;
  MailboxWindow window_;
  Settings settings_;
  MailboxStatistics statistics_;
  std::deque<std::shared_ptr<MailboxDialogue>> queue_;
  std::shared_ptr<MailboxDialogue> active_;

  // The way out.
  std::vector<std::byte> outgoing_;  ///< the mailbox as it is to be written
  std::vector<std::byte> out_wire_;  ///< its copy in the datagram
  std::uint8_t counter_ = 0;
  bool sending_ = false;    ///< not taken by the slave yet
  bool attempted_ = false;  ///< may have been taken
  bool leaving_ = false;    ///< the last word of a dialogue that has failed
  std::optional<std::uint16_t> error_reply_;
  std::uint16_t known_ = 0;    ///< a bit per protocol in which something has been asked
  std::uint16_t refused_ = 0;  ///< a bit per protocol that has been refused
  std::chrono::nanoseconds echo_until_{0};
  std::chrono::nanoseconds deadline_{0};
  std::optional<std::chrono::nanoseconds> resume_at_;  ///< the slave has asked to be left alone until then

  // The way in.
  Fetch fetch_ = Fetch::kPoll;
  std::vector<std::byte> in_wire_;
  std::array<std::byte, 3> registers_{};  ///< status, activate, PDI control of sync manager 1
  bool repeat_bit_ = false;
  std::chrono::nanoseconds repeat_deadline_{0};
  std::chrono::nanoseconds next_idle_poll_{0};
  std::uint8_t last_received_ = 0;
  std::optional<MailboxStatusSample> sample_;
  bool sample_is_old_ = false;     ///< the mailbox has been read since it was taken
  std::uint64_t sample_from_ = 0;  ///< first cycle whose sample counts
  unsigned silent_ = 0;

  // What prepare() has appended.
  bool wrote_ = false;
  bool fetched_ = false;
};

}  // namespace driveline::ecat_master
