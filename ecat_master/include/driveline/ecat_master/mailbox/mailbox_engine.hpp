#pragma once

#include <condition_variable>
#include <map>
#include <memory>
#include <mutex>
#include <vector>

#include "driveline/ecat_master/mailbox/dialogue_request.hpp"
#include "driveline/ecat_master/mailbox/mailbox_channel.hpp"

namespace driveline::ecat_master {

/// Handles the unsolicited messages of a protocol.
class MailboxProtocolHandler {
 public:
  virtual ~MailboxProtocolHandler() = default;
  /// `service`: the data behind the mailbox header; `now`: time of arrival. Called by the thread that steps the engine;
  /// must not call the engine.
  virtual void receive(SlaveRef slave, std::span<const std::byte> service, std::chrono::nanoseconds now) = 0;
  /// Whether the message asks the master for something. The master serves nothing: the slave gets a mailbox error
  /// reply, and the message is not received.
  [[nodiscard]] virtual bool is_request(std::span<const std::byte> /*service*/) const noexcept { return false; }
};

/// Source of the mailbox status from the process data.
class MailboxStatusSource {
 public:
  virtual ~MailboxStatusSource() = default;
  /// Empty: not mapped for the slave at `position`, or the process data are invalid. Any thread.
  [[nodiscard]] virtual std::optional<MailboxStatusSample> mailbox_status(std::uint16_t position) const noexcept = 0;
};

/// The mailboxes of all slaves of a line. One step() combines the datagrams of all slaves into one batch, so the time
/// for many slaves is that of the slowest slave, and a slow or silent slave delays no other. A message whose header
/// addresses another slave is passed to that slave with the address of its sender, and so is the answer.
///
/// Any ordinary thread may submit dialogues and wait for them; a waiting thread drives the engine, one thread at a
/// time. When no thread waits, a user thread calls step() regularly (MailboxWorker). The cycle's requests are
/// registered with watch() (SdoRequest). Nothing here is \rtsafe. If several threads are used, the exchange of the bus
/// must allow that.
class MailboxEngine {
 public:
  /// Time-outs and polling intervals for the slaves.
  using Settings = MailboxChannel::Settings;
  /// Time between two polls for messages.
  static constexpr std::chrono::nanoseconds kPollInterval = std::chrono::microseconds{200};

  /// `bus` must outlive the engine.
  explicit MailboxEngine(Bus& bus, Settings settings = {}) : bus_(bus), settings_(settings) {}
  MailboxEngine(const MailboxEngine&) = delete;
  MailboxEngine& operator=(const MailboxEngine&) = delete;
  /// Dialogues in progress fail with Cancelled.
  ~MailboxEngine();

  /// Opens the mailboxes of a slave, starting with the counter after MailboxWindow::last_counter. Dialogues of a
  /// previously open mailbox fail with Cancelled.
  void open(SlaveRef slave, MailboxWindow window);
  /// Closes the mailboxes of the slave at `position`; its dialogues fail with Cancelled.
  void close(std::uint16_t position);
  /// Closes all mailboxes; their dialogues end with Cancelled.
  void close_all();
  /// Registers the handler of a protocol, which receives its unsolicited messages and makes it known. A protocol
  /// without handler is known to a mailbox once a request has been sent in it; a message of an unknown protocol is
  /// answered with a mailbox error reply, once (ETG.1000.4 5.6). The handler must outlive the engine.
  void handle(wire::MailboxType type, MailboxProtocolHandler& handler);

  /// While the cycle runs: reads from `source`, instead of from the slave, whether a mailbox is full. Null ends that.
  void use_status(const MailboxStatusSource* source);

  /// Sends the messages of `stream` to the slave at `position` between its dialogues whenever its mailboxes are open,
  /// also after they are reopened. One stream per slave; closes the previous one.
  void open_stream(std::uint16_t position, std::shared_ptr<MailboxStream> stream);
  /// Closes the stream of the slave at `position`.
  void close_stream(std::uint16_t position);

  /// Queues a dialogue; fails it with NoMailbox when the slave has no open mailbox.
  void submit(std::uint16_t position, std::shared_ptr<MailboxDialogue> dialogue);
  /// Steps the engine until `dialogue` is done.
  void wait(const MailboxDialogue& dialogue);
  /// One round of datagrams for all slaves. Returns true when there was progress. Does nothing while another thread
  /// steps.
  bool step();
  /// Does a step, or waits for the step of another thread; pauses when there is no progress.
  void drive();
  /// Fetches all unsolicited messages of the slave at `position`. Errors: those of the bus.
  [[nodiscard]] Result<void> poll(std::uint16_t position);

  /// Polls `request`, as long as it exists, and executes its dialogues.
  void watch(std::weak_ptr<DialogueRequest> request);

  /// Counters of a slave's mailboxes.
  [[nodiscard]] MailboxStatistics statistics(std::uint16_t position);
  /// The bus that carries the messages.
  [[nodiscard]] Bus& bus() noexcept { return bus_; }
  /// The settings given to the constructor.
  [[nodiscard]] const Settings& settings() const noexcept { return settings_; }

 private:
  struct Submission {
    std::uint16_t position = 0;
    std::shared_ptr<MailboxDialogue> dialogue;
  };

  /// Datagrams of several channels, with their owners.
  struct Batch {
    /// Requests first to first + count belong to `channel`.
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
    /// Whether a request failed; those behind it are then not sent.
    [[nodiscard]] bool failed() const noexcept;
    /// Records that the requests appended behind `first` belong to the channel.
    void note(MailboxChannel& channel, std::size_t first);
  };

  /// Requires step_mutex_.
  bool step_locked(MailboxChannel::Finished& finished);
  void prepare(std::chrono::nanoseconds now, MailboxChannel::Finished& finished);
  bool evaluate(const Batch& batch, MailboxChannel::Finished& finished);
  void lose_begun(MailboxChannel::Finished& finished);
  void use_stream(std::uint16_t position, std::shared_ptr<MailboxStream> stream);
  void take_submissions(MailboxChannel::Finished& finished);
  void take_requests();
  /// See MailboxChannel::Outlets.
  std::optional<wire::MailboxErrorCode> deliver(SlaveRef slave, wire::MailboxType type,
                                                std::span<const std::byte> service);
  /// See MailboxChannel::Outlets.
  tl::expected<bool, wire::MailboxErrorCode> forward(SlaveRef from, const wire::MailboxHeader& header,
                                                     std::span<const std::byte> service);
  void pause();
  static void complete(MailboxChannel::Finished& finished);

  Bus& bus_;
  Settings settings_;

  std::mutex step_mutex_;  ///< channels_, streams_, status_, handlers_, batches: one thread steps at a time
  std::map<std::uint16_t, MailboxChannel> channels_;
  std::map<std::uint16_t, std::shared_ptr<MailboxStream>> streams_;
  const MailboxStatusSource* status_ = nullptr;
  std::map<wire::MailboxType, MailboxProtocolHandler*> handlers_;
  Batch begun_;  ///< in flight since the previous step
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
