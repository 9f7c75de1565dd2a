#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "driveline/ecat_master/bus/bus.hpp"
#include "driveline/ecat_master/error.hpp"
#include "driveline/ecat_master/mailbox/dialogue.hpp"
#include "driveline/ecat_master/mailbox/mailbox_reader.hpp"
#include "driveline/ecat_master/mailbox/mailbox_stream.hpp"
#include "driveline/ecat_master/mailbox/mailbox_window.hpp"
#include "driveline/ecat_master/mailbox/mailbox_writer.hpp"
#include "driveline/wire/mailbox.hpp"

namespace driveline::ecat_master {

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

/// The mailboxes of one slave: carries out one dialogue after the other, in the order of their priorities, and lets the
/// mails of a stream through whenever no dialogue has anything to send. It never waits; each step contributes the
/// datagrams it needs now to a batch that travels for all slaves together, and takes the answers. Counter, polling of
/// the sync manager's status, and repetition of replies that were lost on the wire as in ETG.1000.4 5.6 and 6.6.3.
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
    /// A stream that has moved is likely to move again: the slave is polled without pause for this long.
    std::chrono::nanoseconds stream_poll = std::chrono::milliseconds{20};
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
  /// From now on the mails of this stream are sent, too; null: of none. Tells the stream before that it is closed.
  void use_stream(std::shared_ptr<MailboxStream> stream);
  /// The next prepare() looks into the mailbox, due or not.
  void poll_now() noexcept { reader_.poll_now(); }
  /// What the process data say about the mailbox now; nothing: it is asked for with a datagram of its own.
  void use_sample(std::optional<MailboxStatusSample> sample) noexcept { reader_.use_sample(sample); }
  /// Nothing has been found in the mailbox since poll_now().
  [[nodiscard]] bool polled_empty() const noexcept { return reader_.polled_empty(); }

  /// Appends what this slave needs now to `batch`; dialogues that cannot even begin go to `finished`.
  void prepare(std::chrono::nanoseconds now, std::vector<Request>& batch, Finished& finished);
  /// Appends to `batch` what follows when all goes well, before the answers to the last turn are taken: mails of the
  /// stream, or the answer to what a dialogue has asked. `alone`: no other slave needs the bytes on the wire, so mails
  /// are read without looking for them.
  void prepare_ahead(std::chrono::nanoseconds now, bool alone, std::vector<Request>& batch);
  /// Takes the answers to what prepare(), or prepare_ahead() in the turn before, has appended. True: something has
  /// moved on, no need to pause.
  bool evaluate(std::chrono::nanoseconds now, std::span<const Request> answers, const Deliver& deliver,
                Finished& finished);
  /// Ends all dialogues with `error`.
  void fail_all(Error error, Finished& finished);

  /// Whose mailboxes these are.
  [[nodiscard]] SlaveRef slave() const noexcept { return slave_; }
  /// Where they are.
  [[nodiscard]] const MailboxWindow& window() const noexcept { return window_; }
  /// Service bytes that fit into one mailbox to the slave.
  [[nodiscard]] std::size_t max_service() const noexcept { return writer_.room(); }
  /// Since the channel was opened.
  [[nodiscard]] MailboxStatistics statistics() const noexcept;

 private:
  /// Whose mail the slave has not taken yet.
  enum class Sender : std::uint8_t { kNobody, kDialogue, kStream };

  /// What has been appended to a batch.
  struct Turn {
    bool wrote = false;    ///< a mail
    bool fetched = false;  ///< something about the mailbox from the slave
    bool reads = false;    ///< and that is the read of a mail
    /// By prepare_ahead().
    std::optional<MailboxReader::Ahead> ahead;
  };

  [[nodiscard]] std::chrono::nanoseconds request_timeout() const noexcept;
  /// Of the dialogue in progress.
  [[nodiscard]] std::chrono::nanoseconds reply_timeout() const noexcept;
  /// The slave has not taken the mail of the dialogue in progress.
  [[nodiscard]] bool sending() const noexcept { return owed_ || sender_ == Sender::kDialogue; }

  void start_next(std::chrono::nanoseconds now, Finished& finished);
  [[nodiscard]] bool load_outgoing(std::chrono::nanoseconds now);
  void load_mail(std::chrono::nanoseconds now);
  void read_ahead(std::size_t expected, std::vector<Request>& batch);
  [[nodiscard]] std::size_t expected(bool alone) const;
  [[nodiscard]] bool append_mail_behind(std::vector<Request>& batch);
  [[nodiscard]] bool append_first_mail(std::chrono::nanoseconds now, std::vector<Request>& batch);
  void send_stream(std::chrono::nanoseconds now) noexcept;
  void stop_stream() noexcept;
  void withdraw() noexcept;
  bool take_written(std::chrono::nanoseconds now, const Request& answer, Finished& finished);
  bool take_found(std::chrono::nanoseconds now, MailboxReader::Found found, const Deliver& deliver, Finished& finished);
  void take_mail(std::chrono::nanoseconds now, const Deliver& deliver, Finished& finished);
  void pass_on(std::chrono::nanoseconds now, wire::MailboxType type, std::span<const std::byte> service,
               const Deliver& deliver);
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
  MailboxWriter writer_;
  MailboxReader reader_;
  Sender sender_ = Sender::kNobody;  ///< of the mail in writer_

  // The dialogue in progress, and those behind it.
  std::deque<std::shared_ptr<MailboxDialogue>> queue_;
  std::shared_ptr<MailboxDialogue> active_;
  bool owed_ = false;       ///< its service waits until the slave has taken a mail of the stream
  bool attempted_ = false;  ///< its mail may have been taken
  bool leaving_ = false;    ///< its mail is the last word after it has failed
  std::optional<std::uint16_t> error_reply_;
  std::chrono::nanoseconds deadline_{0};
  std::optional<std::chrono::nanoseconds> resume_at_;  ///< the slave has asked to be left alone until then

  std::shared_ptr<MailboxStream> stream_;
  std::chrono::nanoseconds stream_deadline_{0};     ///< for the slave to take its mail
  std::chrono::nanoseconds stream_moved_until_{0};  ///< a mail either way not long ago
  std::chrono::nanoseconds stream_echo_until_{0};   ///< an error reply may be about a mail of the stream

  std::uint16_t known_ = 0;    ///< a bit per protocol in which something has been asked
  std::uint16_t refused_ = 0;  ///< a bit per protocol that has been refused
  std::chrono::nanoseconds echo_until_{0};
  std::uint8_t last_received_ = 0;

  Turn turn_;   ///< whose answers are taken next
  Turn ahead_;  ///< behind it
};

}  // namespace driveline::ecat_master
