#pragma once

#include <array>
#include <optional>
#include <span>

#include "driveline/canopen_wire/nmt.hpp"

namespace driveline::slaves::cia301 {

using canopen::NmtState;

/// NMT requests that wait for the cycle in which a device obeys them. \rtsafe throughout.
class NmtQueue {
 public:
  /// Adds a message; false: there is no room.
  bool add(const canopen::Frame& frame) noexcept;
  /// The oldest message, which leaves the queue; empty: none.
  [[nodiscard]] std::optional<canopen::Frame> take() noexcept;
  /// Forgets all messages.
  void clear() noexcept { count_ = 0; }

 private:
  static constexpr std::size_t kCapacity = 8;
  std::array<canopen::Frame, kCapacity> frames_{};
  std::size_t first_ = 0;
  std::size_t count_ = 0;
};

/// NMT state machine of a device (CiA 301 7.3.2). \rtsafe throughout.
class NmtMachine {
 public:
  /// What a request asks for beyond a change of the state.
  enum class Action : std::uint8_t { kNone, kStateChanged, kResetNode, kResetCommunication };

  /// State; Initialising from a reset to the boot-up message.
  [[nodiscard]] NmtState state() const noexcept { return state_; }
  /// Enters a state; returns whether it is another one.
  bool enter(NmtState state) noexcept;
  /// Takes an NMT message. Other lengths, commands and nodes are ignored and counted, and everything while the device
  /// initialises; so is a start that is not permitted.
  [[nodiscard]] Action request(std::span<const std::byte> payload, std::uint8_t node_id, bool may_start) noexcept;
  /// A message was dropped.
  void ignore() noexcept { ++ignored_; }
  /// Messages that were ignored.
  [[nodiscard]] std::uint64_t ignored() const noexcept { return ignored_; }

  /// Services by state (CiA 301 Table 38). NMT and error control are there in all but Initialising.
  [[nodiscard]] bool configurable() const noexcept {  // SDO, EMCY, SYNC, TIME
    return state_ == NmtState::kPreOperational || state_ == NmtState::kOperational;
  }
  /// Whether PDOs exist.
  [[nodiscard]] bool operational() const noexcept { return state_ == NmtState::kOperational; }

 private:
  [[nodiscard]] Action entered(NmtState state) noexcept;

  NmtState state_ = NmtState::kInitialising;
  std::uint64_t ignored_ = 0;
};

}  // namespace driveline::slaves::cia301
