#pragma once

#include <atomic>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

#include "driveline/ecat_master/error.hpp"
#include "driveline/wire/mailbox.hpp"

namespace driveline::ecat_master {

/// Number of bytes that fit behind the header in a slave's mailboxes.
struct MailboxRoom {
  std::size_t out = 0;  ///< to the slave
  std::size_t in = 0;   ///< from the slave
};

/// A task at a slave's mailbox in one protocol: services go out, answers come in, until it is done. Protocols (CoE,
/// FoE) derive from it; MailboxChannel executes it.
///
/// All functions but done() are called by the engine, never by two threads at once.
class MailboxDialogue {
 public:
  /// Reaction of a dialogue to a mailbox message.
  enum class Reaction : std::uint8_t {
    kForeign,  ///< not the expected answer; the message goes to the protocol's handler
    kSend,     ///< outgoing() holds the next service
    kPause,    ///< like kSend, after pause(), unless an answer arrives earlier
    kAwait,    ///< another answer follows without a request (fragments)
    kDone,     ///< the dialogue has ended, successfully or not
  };

  /// `priority`: 0 lowest to 3 highest; determines the order among the dialogues of a slave, and goes into the mailbox
  /// header.
  MailboxDialogue(wire::MailboxType type, std::uint8_t priority) noexcept
      : type_(type), priority_(priority > 3 ? 3 : priority) {}
  MailboxDialogue(const MailboxDialogue&) = delete;
  MailboxDialogue& operator=(const MailboxDialogue&) = delete;
  virtual ~MailboxDialogue() = default;

  /// Protocol of its messages.
  [[nodiscard]] wire::MailboxType type() const noexcept { return type_; }
  /// Priority, 0 to 3; 3 goes first.
  [[nodiscard]] std::uint8_t priority() const noexcept { return priority_; }
  /// True once the result may be read, by any thread.
  [[nodiscard]] bool done() const noexcept { return done_.load(std::memory_order_acquire); }

  /// Prepares the first service, for the slave at `position`.
  virtual void begin(std::uint16_t position, MailboxRoom room) = 0;
  /// The service to send, without mailbox header.
  [[nodiscard]] virtual std::span<const std::byte> outgoing() const noexcept = 0;
  /// False: the dialogue ends as soon as outgoing() has been handed to the slave.
  [[nodiscard]] virtual bool awaits_answer() const noexcept { return true; }
  /// Station address in the mailbox header: the slave that the message comes from; 0: the master (ETG.1000.4 5.6).
  [[nodiscard]] virtual std::uint16_t source() const noexcept { return 0; }
  /// Whether the slave may execute outgoing() twice without harm, so that it is sent again when no answer arrives.
  [[nodiscard]] virtual bool repeatable() const noexcept { return false; }
  /// Time-out of each answer; empty: the default of the slave.
  [[nodiscard]] virtual std::optional<std::chrono::nanoseconds> timeout() const noexcept { return std::nullopt; }
  /// After Reaction::kPause: time until the next service is sent.
  [[nodiscard]] virtual std::chrono::nanoseconds pause() const noexcept { return std::chrono::nanoseconds{0}; }
  /// Processes a message of the dialogue's protocol, without mailbox header.
  [[nodiscard]] virtual Reaction receive(std::span<const std::byte> service) = 0;
  /// Ends the dialogue with an error.
  virtual void fail(const Error& error) = 0;
  /// After fail() because no answer arrived: true when outgoing() is a final message that frees the slave (an SDO
  /// abort).
  [[nodiscard]] virtual bool takes_leave() { return false; }
  /// Called last, with no lock held.
  virtual void completed() {}

  /// Used by the engine: makes the result visible and calls completed().
  void complete() {
    done_.store(true, std::memory_order_release);
    completed();
  }

 private:
  wire::MailboxType type_;
  std::uint8_t priority_;
  std::atomic<bool> done_{false};
};

}  // namespace driveline::ecat_master
