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

/// What fits behind the header of a slave's mailboxes, in bytes.
struct MailboxRoom {
  std::size_t out = 0;  ///< to the slave
  std::size_t in = 0;   ///< from the slave
};

/// One errand at a slave's mailbox in one protocol: services go out, answers come in, until it is done. Protocols (CoE,
/// FoE) derive from it; MailboxChannel carries it out.
///
/// All functions but done() are called by the engine, never by two threads at once.
class MailboxDialogue {
 public:
  /// What a dialogue makes of a mail.
  enum class Reaction : std::uint8_t {
    kForeign,  ///< not the awaited answer; the mail goes to the protocol's handler
    kSend,     ///< outgoing() holds the next service
    kPause,    ///< the same, after pause(), unless an answer comes until then
    kAwait,    ///< one more answer comes without asking (fragments)
    kDone,     ///< over, well or badly
  };

  /// `priority`: 0 lowest to 3 highest; the order among the dialogues of one slave, and in the mailbox header.
  MailboxDialogue(wire::MailboxType type, std::uint8_t priority) noexcept
      : type_(type), priority_(priority > 3 ? 3 : priority) {}
  MailboxDialogue(const MailboxDialogue&) = delete;
  MailboxDialogue& operator=(const MailboxDialogue&) = delete;
  virtual ~MailboxDialogue() = default;

  /// Protocol of its mails.
  [[nodiscard]] wire::MailboxType type() const noexcept { return type_; }
  /// 0 to 3, 3 goes first.
  [[nodiscard]] std::uint8_t priority() const noexcept { return priority_; }
  /// True once the result may be read, by any thread.
  [[nodiscard]] bool done() const noexcept { return done_.load(std::memory_order_acquire); }

  /// Makes the first service, for the slave at `position`.
  virtual void begin(std::uint16_t position, MailboxRoom room) = 0;
  /// The service to send, without mailbox header.
  [[nodiscard]] virtual std::span<const std::byte> outgoing() const noexcept = 0;
  /// False: the dialogue is over as soon as outgoing() has been handed to the slave.
  [[nodiscard]] virtual bool awaits_answer() const noexcept { return true; }
  /// How long each answer may take; none: as all answers of the slave.
  [[nodiscard]] virtual std::optional<std::chrono::nanoseconds> patience() const noexcept { return std::nullopt; }
  /// After Reaction::kPause: how long the slave is left alone.
  [[nodiscard]] virtual std::chrono::nanoseconds pause() const noexcept { return std::chrono::nanoseconds{0}; }
  /// A mail of the dialogue's type, without mailbox header.
  [[nodiscard]] virtual Reaction receive(std::span<const std::byte> service) = 0;
  /// The dialogue cannot go on.
  virtual void fail(const Error& error) = 0;
  /// After fail() because no answer came: true when outgoing() is a last word that frees the slave (an SDO abort).
  [[nodiscard]] virtual bool takes_leave() { return false; }
  /// Called last, with no lock held.
  virtual void completed() {}

  /// For the engine: makes the result visible and calls completed().
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
