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
#include "driveline/ecat_master/mailbox/refusal_record.hpp"
#include "driveline/ecat_master/mailbox/repetition_filter.hpp"
#include "driveline/wire/mailbox.hpp"

namespace driveline::ecat_master {

/// Counters of a channel.
struct MailboxStatistics {
  std::uint64_t sent = 0;       ///< messages to the slave
  std::uint64_t received = 0;   ///< messages from the slave
  std::uint64_t repeated = 0;   ///< replies requested again because they were lost in transit
  std::uint64_t malformed = 0;  ///< messages with an invalid header or length
  std::uint64_t unclaimed = 0;  ///< messages that no dialogue waited for
  std::uint64_t refused = 0;    ///< messages of unknown protocols, and requests that cannot be served or forwarded
  std::uint64_t forwarded = 0;  ///< messages to other slaves
  std::uint64_t timeouts = 0;   ///< dialogues without an answer in time
  std::uint64_t resent = 0;     ///< requests sent again because no answer had arrived
  /// Answers taken although they have the counter of the previous message: the slave does not advance its counter.
  std::uint64_t same_counter = 0;
  std::uint64_t repetitions = 0;  ///< messages dropped as repetitions: counter and content of the previous message
};

/// The mailboxes of a slave: executes one dialogue after another, in the order of their priorities, and sends messages
/// of a stream whenever no dialogue has anything to send. It never waits; each step contributes the datagrams it
/// currently needs to a batch shared by all slaves, and processes the answers. Counter, polling of the sync manager
/// status, and repetition of replies lost on the wire follow ETG.1000.4 5.6 and 6.6.3.
///
/// One thread at a time; see MailboxEngine.
class MailboxChannel {
 public:
  /// Time-outs and polling intervals for the slave.
  struct Settings {
    std::chrono::nanoseconds reply_timeout = std::chrono::seconds{2};  ///< time-out of each answer
    /// A mailbox error reply names no request: after it, the expected answer may still arrive for this time.
    std::chrono::nanoseconds error_grace = std::chrono::milliseconds{50};
    std::chrono::nanoseconds idle_poll = std::chrono::milliseconds{10};  ///< polling interval for unsolicited messages
    /// After activity a stream is likely to continue: the slave is polled without pause for this time.
    std::chrono::nanoseconds stream_poll = std::chrono::milliseconds{20};
  };
  /// Where messages go that no dialogue waits for.
  struct Outlets {
    /// Receives a message for the master. Returns why the master cannot process it; empty: it has.
    std::function<std::optional<wire::MailboxErrorCode>(SlaveRef, wire::MailboxType,
                                                        std::span<const std::byte> service)>
        deliver;
    /// Passes a message to the slave that its header addresses. Returns false when no open mailbox has this address, or
    /// why the message cannot be passed on.
    std::function<tl::expected<bool, wire::MailboxErrorCode>(SlaveRef from, const wire::MailboxHeader& header,
                                                             std::span<const std::byte> service)>
        forward;
  };
  /// Most messages of other slaves that wait for this slave.
  static constexpr std::size_t kMaxForwarded = 8;
  /// Dialogues that have ended.
  using Finished = std::vector<std::shared_ptr<MailboxDialogue>>;

  /// `window`: mailboxes for which the sync managers are set up.
  MailboxChannel(SlaveRef slave, MailboxWindow window, Settings settings);

  /// Queues a dialogue behind those of the same priority.
  void submit(std::shared_ptr<MailboxDialogue> dialogue);
  /// Queues a message of the slave with station address `source`. Returns why it cannot be sent; empty: it is queued.
  [[nodiscard]] std::optional<wire::MailboxErrorCode> send_for(std::uint16_t source, wire::MailboxType type,
                                                               std::span<const std::byte> service);
  /// Whether a dialogue is in progress or waiting.
  [[nodiscard]] bool busy() const noexcept { return active_ != nullptr || !queue_.empty(); }
  /// From now on also sends the messages of this stream; null: of no stream. Notifies the previous stream that it is
  /// closed.
  void use_stream(std::shared_ptr<MailboxStream> stream);
  /// Makes the next prepare() poll the mailbox, whether or not a poll is due.
  void poll_now() noexcept { reader_.poll_now(); }
  /// Current mailbox status from the process data; empty: the status is read with a separate datagram.
  void use_sample(std::optional<MailboxStatusSample> sample) noexcept { reader_.use_sample(sample); }
  /// Whether nothing has been found in the mailbox since poll_now().
  [[nodiscard]] bool polled_empty() const noexcept { return reader_.polled_empty(); }

  /// Appends the datagrams that this slave needs now to `batch`; dialogues that cannot start go to `finished`.
  void prepare(std::chrono::nanoseconds now, std::vector<Request>& batch, Finished& finished);
  /// Appends to `batch` the datagrams that follow when all goes well, before the answers to the last turn are
  /// processed: messages of the stream, or the read of the answer to a dialogue's request. `alone`: no other slave
  /// needs the bandwidth, so messages are read without checking for them first.
  void prepare_ahead(std::chrono::nanoseconds now, bool alone, std::vector<Request>& batch);
  /// Processes the answers to the datagrams of prepare(), or of prepare_ahead() in the previous turn. Returns true when
  /// there was progress, so that no pause is needed.
  bool evaluate(std::chrono::nanoseconds now, std::span<const Request> answers, const Outlets& outlets,
                Finished& finished);
  /// Ends all dialogues with `error`.
  void fail_all(Error error, Finished& finished);

  /// The slave of these mailboxes.
  [[nodiscard]] SlaveRef slave() const noexcept { return slave_; }
  /// Position of the mailboxes in the slave's memory.
  [[nodiscard]] const MailboxWindow& window() const noexcept { return window_; }
  /// Service bytes that fit into a message to the slave.
  [[nodiscard]] std::size_t max_service() const noexcept { return writer_.room(); }
  /// Counters since the channel was opened.
  [[nodiscard]] MailboxStatistics statistics() const noexcept;

 private:
  /// Sender of the message that the slave has not taken yet.
  enum class Sender : std::uint8_t { kNone, kDialogue, kStream };

  /// Datagrams appended to a batch.
  struct Turn {
    bool wrote = false;    ///< writes a message
    bool fetched = false;  ///< reads something about the slave's mailbox
    bool reads = false;    ///< and that is a message
    /// Kind of datagram appended by prepare_ahead().
    std::optional<MailboxReader::Ahead> ahead;
  };

  /// Message of the dialogue in progress.
  struct Outgoing {
    bool owed = false;          ///< waits until the slave has taken a message of the stream
    bool attempted = false;     ///< may have been taken by the slave
    bool leaving = false;       ///< is the final message after a failure
    bool again = false;         ///< is sent again with the same counter
    std::uint8_t counter = 0;   ///< mailbox counter
    std::uint32_t taken = 0;    ///< how often the slave has taken it
    std::uint32_t dropped = 0;  ///< messages dropped as repetitions since it was sent first
    std::chrono::nanoseconds repeat_at{0};
    std::chrono::nanoseconds deadline{0};
    std::optional<std::uint16_t> error_reply{};
    std::optional<std::chrono::nanoseconds> resume_at{};  ///< the slave is busy; resume at this time
  };

  /// Times of the stream.
  struct StreamTimes {
    std::chrono::nanoseconds deadline{0};      ///< time limit for the slave to take its message
    std::chrono::nanoseconds active_until{0};  ///< until then the stream counts as active
    std::chrono::nanoseconds echo_until{0};    ///< until then an error reply may refer to a message of the stream
  };

  [[nodiscard]] std::chrono::nanoseconds request_timeout() const noexcept;
  /// Time-out of the answers of the dialogue in progress.
  [[nodiscard]] std::chrono::nanoseconds reply_timeout() const noexcept;
  /// Whether the slave has not yet taken the message of the dialogue in progress.
  [[nodiscard]] bool sending() const noexcept { return request_.owed || sender_ == Sender::kDialogue; }

  void start_next(std::chrono::nanoseconds now, Finished& finished);
  [[nodiscard]] bool load_outgoing(std::chrono::nanoseconds now);
  void load_mail(std::chrono::nanoseconds now);
  void load_request();
  /// Interval at which the request is sent again; 0: never.
  [[nodiscard]] std::chrono::nanoseconds repeat_interval() const noexcept;
  [[nodiscard]] bool repeat_due(std::chrono::nanoseconds now) const noexcept;
  void repeat(std::chrono::nanoseconds now);
  void read_ahead(std::size_t expected, std::vector<Request>& batch);
  [[nodiscard]] std::size_t expected(bool alone) const;
  [[nodiscard]] bool append_mail_behind(std::vector<Request>& batch);
  [[nodiscard]] bool append_first_mail(std::chrono::nanoseconds now, std::vector<Request>& batch);
  void send_stream(std::chrono::nanoseconds now) noexcept;
  void stop_stream() noexcept;
  void withdraw() noexcept;
  bool take_written(std::chrono::nanoseconds now, const Request& answer, Finished& finished);
  bool take_found(std::chrono::nanoseconds now, MailboxReader::Found found, const Outlets& outlets, Finished& finished);
  void take_mail(std::chrono::nanoseconds now, const Outlets& outlets, Finished& finished);
  /// Whether the dialogue in progress waits for messages of this protocol.
  [[nodiscard]] bool awaits(wire::MailboxType type) const noexcept;
  void enqueue(std::shared_ptr<MailboxDialogue> dialogue);
  /// Whether the header addresses another station.
  [[nodiscard]] bool is_for_another(const wire::MailboxHeader& header) const noexcept;
  bool forward(std::chrono::nanoseconds now, const wire::MailboxHeader& header, std::span<const std::byte> service,
               const Outlets& outlets);
  void pass_on(std::chrono::nanoseconds now, const wire::MailboxHeader& header, std::span<const std::byte> service,
               const Outlets& outlets);
  void refuse(wire::MailboxType type);
  void refuse_request(std::chrono::nanoseconds now, const wire::MailboxHeader& header, wire::MailboxErrorCode code);
  void resume(std::chrono::nanoseconds now, Finished& finished);
  void take_error(std::chrono::nanoseconds now, std::span<const std::byte> service, Finished& finished);
  void react(std::chrono::nanoseconds now, MailboxDialogue::Reaction reaction, Finished& finished);
  void check_deadlines(std::chrono::nanoseconds now, Finished& finished);
  void finish(Finished& finished);
  void finish(Finished& finished, const Error& error);
  [[nodiscard]] Error error(ErrorFacts facts) const noexcept;

  SlaveRef slave_;
  MailboxWindow window_;
  Settings settings_;
  MailboxStatistics statistics_;
  MailboxWriter writer_;
  MailboxReader reader_;
  Sender sender_ = Sender::kNone;  ///< sender of the message in writer_

  std::deque<std::shared_ptr<MailboxDialogue>> queue_;
  std::shared_ptr<MailboxDialogue> active_;  ///< dialogue in progress
  Outgoing request_;                         ///< its message
  std::shared_ptr<MailboxStream> stream_;
  StreamTimes stream_times_;

  RefusalRecord refusals_;
  RepetitionFilter repetitions_;

  Turn turn_;   ///< turn whose answers are processed next
  Turn ahead_;  ///< the following turn
};

}  // namespace driveline::ecat_master
