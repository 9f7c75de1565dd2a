#pragma once

#include <chrono>
#include <cstdint>
#include <deque>
#include <optional>
#include <span>
#include <vector>

#include "driveline/slaves/persona/persona.hpp"
#include "persona/sdo_obstacles.hpp"

namespace driveline::slaves {

/// Mailbox of a device with personas: refuses, loses, delays, adds and renumbers messages. Times are on the line's
/// clock. Not thread-safe.
class MailboxHabits {
 public:
  /// Times are on the line's clock.
  using Nanoseconds = std::chrono::nanoseconds;

  /// Copies what it needs from the personas.
  explicit MailboxHabits(std::span<const Persona> personas);

  /// Called when the mailbox starts, INIT to PREOP, at `now`. Drops the messages that wait.
  void start(Nanoseconds now) noexcept;
  /// Receives a request of the master at `now`. Returns the message for the device; empty: it is lost or refused. The
  /// message has a counter of its own, since the device would take a request for a repetition of an earlier one after
  /// seven that it did not get. Valid until the next call.
  [[nodiscard]] std::span<const std::byte> request(std::span<const std::byte> mail, Nanoseconds now);
  /// Whether a message may be sent at `now`. \rtsafe
  [[nodiscard]] bool may_send(Nanoseconds now) const noexcept { return now >= answer_at_; }
  /// Writes the next message that the personas add or with which they refuse; returns its length, 0: there is none.
  [[nodiscard]] std::size_t own_message(std::span<std::byte> out);
  /// Changes size indication, number of assigned PDOs and counter of a message that is about to be sent. \rtsafe
  void rewrite(std::span<std::byte> mail) noexcept;

 private:
  using Mail = std::vector<std::byte>;
  [[nodiscard]] bool deaf(Nanoseconds now) const noexcept;
  [[nodiscard]] bool loses_next() noexcept;
  [[nodiscard]] std::span<const std::byte> renumbered(std::span<const std::byte> mail, bool repeated);
  void add_unasked();
  [[nodiscard]] std::uint8_t next_counter() noexcept;
  void rewrite_size(std::span<std::byte> mail) const noexcept;
  void rewrite_assignment(std::span<std::byte> mail) const noexcept;

  std::vector<Persona> personas_;
  SdoObstacles obstacles_;
  std::deque<Mail> own_;
  bool unasked_due_ = false;  ///< emergencies and the stale message are still to be queued
  Nanoseconds start_{0};      ///< start of the mailbox
  Nanoseconds answer_at_{0};  ///< when the next message may leave
  std::uint64_t requests_ = 0;
  std::uint8_t counter_ = 0;          ///< counter of the last message, as a device without personas would count
  std::uint8_t request_counter_ = 0;  ///< counter of the last request
  std::uint8_t handled_counter_ = 0;  ///< counter of the last request that was refused or passed on; 0: none
  bool refused_last_ = false;         ///< that request was refused
  std::uint8_t device_counter_ = 0;   ///< counter of the last request that was passed on, as the device sees it
  Mail for_device_;                   ///< message returned by request()
};

}  // namespace driveline::slaves
