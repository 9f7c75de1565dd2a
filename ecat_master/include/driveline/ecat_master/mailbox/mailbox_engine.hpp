#pragma once

#include <condition_variable>
#include <map>
#include <memory>
#include <mutex>
#include <vector>

#include "driveline/ecat_master/mailbox/dialogue_request.hpp"
#include "driveline/ecat_master/mailbox/mailbox_channel.hpp"

namespace driveline::ecat_master {

/// What a protocol does with mails that nobody has asked for.
class MailboxProtocolHandler {
 public:
  virtual ~MailboxProtocolHandler() = default;
  /// `service` is what follows the mailbox header; `now` the time of its arrival. Called by the thread that steps the
  /// engine; must not call the engine back.
  virtual void receive(SlaveRef slave, std::span<const std::byte> service, std::chrono::nanoseconds now) = 0;
};

/// Where the status of the mailboxes comes with the process data.
class MailboxStatusSource {
 public:
  virtual ~MailboxStatusSource() = default;
  /// Nothing: not mapped for the slave at `position`, or the process data are not valid. Any thread.
  [[nodiscard]] virtual std::optional<MailboxStatusSample> mailbox_status(std::uint16_t position) const noexcept = 0;
};

/// The mailboxes of all slaves of a line. One step() gathers what every slave needs into one batch of datagrams, so
/// that the time for many slaves is the time of the slowest, and a slave that is slow or silent delays nobody.
///
/// Any ordinary thread may submit dialogues and wait for them; whoever waits drives the engine, one at a time. Without
/// anybody who waits a thread of the user calls step() now and then (MailboxWorker). The cycle has its requests watched
/// (SdoRequest). Nothing here is \rtsafe. The exchange of the bus must allow several threads when several are used.
class MailboxEngine {
 public:
  /// Patience with slaves.
  using Settings = MailboxChannel::Settings;
  /// From one look for mails to the next.
  static constexpr std::chrono::nanoseconds kPollInterval = std::chrono::microseconds{200};

  /// `bus` must outlive the engine.
  explicit MailboxEngine(Bus& bus, Settings settings = {}) : bus_(bus), settings_(settings) {}
  MailboxEngine(const MailboxEngine&) = delete;
  MailboxEngine& operator=(const MailboxEngine&) = delete;
  /// Dialogues that are still open fail with Cancelled.
  ~MailboxEngine();

  /// Opens the mailboxes of a slave, with the counter behind MailboxWindow::last_counter. What was open before fails
  /// with Cancelled.
  void open(SlaveRef slave, MailboxWindow window);
  /// Closes the mailboxes of the slave at `position`; its dialogues fail with Cancelled.
  void close(std::uint16_t position);
  /// Closes all mailboxes; their dialogues end with Cancelled.
  void close_all();
  /// Makes a protocol known and tells who gets its mails that answer nothing. A protocol without handler is known to a
  /// mailbox once something has been asked in it; one that is not known is answered with a mailbox error reply, once
  /// (ETG.1000.4 5.6). The handler must outlive the engine.
  void handle(wire::MailboxType type, MailboxProtocolHandler& handler);

  /// While the cycle runs: asks `source` whether a mailbox is full, instead of the slave. Null ends that.
  void use_status(const MailboxStatusSource* source);

  /// The mails of `stream` go to the slave at `position` beside its dialogues whenever its mailboxes are open, also
  /// when they are opened anew; one stream per slave, what was open before is closed.
  void open_stream(std::uint16_t position, std::shared_ptr<MailboxStream> stream);
  /// Ends the stream of the slave at `position`.
  void close_stream(std::uint16_t position);

  /// Queues a dialogue; fails it with NoMailbox when the slave has no open mailbox.
  void submit(std::uint16_t position, std::shared_ptr<MailboxDialogue> dialogue);
  /// Steps the engine until `dialogue` is done.
  void wait(const MailboxDialogue& dialogue);
  /// One round of datagrams for all slaves. True: something has moved on. Does nothing while another thread steps.
  bool step();
  /// One step by this thread, or by another that is at it; pauses when nothing has moved on.
  void drive();
  /// Fetches everything the slave at `position` has put into its mailbox by itself. Errors: those of the bus.
  [[nodiscard]] Result<void> poll(std::uint16_t position);

  /// Looks after `request` until nobody else has it: what it asks for is carried out.
  void watch(std::weak_ptr<DialogueRequest> request);

  /// Of the mailboxes of one slave.
  [[nodiscard]] MailboxStatistics statistics(std::uint16_t position);
  /// That the mails go through.
  [[nodiscard]] Bus& bus() noexcept { return bus_; }
  /// As it was made.
  [[nodiscard]] const Settings& settings() const noexcept { return settings_; }

 private:
  struct Submission {
    std::uint16_t position = 0;
    std::shared_ptr<MailboxDialogue> dialogue;
  };

  /// Datagrams of several channels, and whose they are.
  struct Batch {
    /// Requests first to first + count are those of one channel.
    struct Part {
      MailboxChannel* channel = nullptr;
      std::size_t first = 0;
      std::size_t count = 0;
    };
    std::vector<Request> requests;
    std::vector<Part> parts;

    void clear() noexcept {
      requests.clear();
      parts.clear();
    }
    [[nodiscard]] bool has(const MailboxChannel& channel) const noexcept;
    /// What stands behind it is not sent.
    [[nodiscard]] bool failed() const noexcept;
    /// What was appended to `requests` behind `first` is the channel's.
    void note(MailboxChannel& channel, std::size_t first);
  };

  /// With step_mutex_ held.
  bool step_locked(MailboxChannel::Finished& finished);
  void prepare(std::chrono::nanoseconds now, MailboxChannel::Finished& finished);
  bool evaluate(const Batch& batch, MailboxChannel::Finished& finished);
  void lose_begun(MailboxChannel::Finished& finished);
  void use_stream(std::uint16_t position, std::shared_ptr<MailboxStream> stream);
  void take_submissions(MailboxChannel::Finished& finished);
  void take_requests();
  /// False: nobody knows the protocol.
  bool deliver(SlaveRef slave, wire::MailboxType type, std::span<const std::byte> service);
  void pause();
  static void complete(MailboxChannel::Finished& finished);

  Bus& bus_;
  Settings settings_;

  std::mutex step_mutex_;  ///< channels_, streams_, status_, handlers_, batches: one thread steps at a time
  std::map<std::uint16_t, MailboxChannel> channels_;
  std::map<std::uint16_t, std::shared_ptr<MailboxStream>> streams_;
  const MailboxStatusSource* status_ = nullptr;
  std::map<wire::MailboxType, MailboxProtocolHandler*> handlers_;
  Batch begun_;  ///< on its way since the step before
  Batch batch_;
  Batch next_;  ///< becomes begun_
  bool begun_is_held_ = false;

  std::mutex inbox_mutex_;
  std::vector<Submission> inbox_;
  std::vector<std::weak_ptr<DialogueRequest>> requests_;

  std::mutex wait_mutex_;
  std::condition_variable stepped_;
};

}  // namespace driveline::ecat_master
