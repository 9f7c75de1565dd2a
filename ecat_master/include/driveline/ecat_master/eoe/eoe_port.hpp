#pragma once

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <span>

#include "driveline/ecat_master/mailbox/mailbox_stream.hpp"
#include "driveline/rt/spsc_ring.hpp"
#include "driveline/wire/eoe_frames.hpp"
#include "driveline/wire/mailbox.hpp"

namespace driveline::ecat_master {

/// Who gets the Ethernet frames of the slaves.
class EoeReceiver {
 public:
  virtual ~EoeReceiver() = default;
  /// A frame from the slave at `position`, valid during the call. Called by the thread that steps the engine; must not
  /// call the engine back.
  virtual void receive(std::uint16_t position, std::span<const std::byte> frame) = 0;
};

/// An Ethernet frame without check sequence.
struct EoeFrame {
  std::uint16_t size = 0;                             ///< of `bytes`
  std::array<std::byte, wire::kMaxEoeFrame> bytes{};  ///< the frame
};

/// What a port has seen.
struct EoePortStatistics {
  std::uint64_t frames_out = 0;     ///< to the slave, whole
  std::uint64_t frames_in = 0;      ///< from the slave, whole
  std::uint64_t bytes_out = 0;      ///< of frames_out
  std::uint64_t bytes_in = 0;       ///< of frames_in
  std::uint64_t fragments_out = 0;  ///< of any frame
  std::uint64_t fragments_in = 0;   ///< of any frame
  std::uint64_t full = 0;           ///< frames to the slave that found the queue full
  std::uint64_t refused = 0;    ///< frames to the slave of a length that EoE does not carry, or while the port was down
  std::uint64_t given_up = 0;   ///< frames to the slave dropped on their way: it did not take them, or went away
  std::uint64_t lost = 0;       ///< frames from the slave with a missing fragment
  std::uint64_t malformed = 0;  ///< mails from the slave that cannot be
  std::uint64_t stray = 0;      ///< fragments from the slave of no frame in progress, answers nobody waits for
  constexpr bool operator==(const EoePortStatistics&) const = default;
};

/// The master's end of one slave's EoE: takes Ethernet frames to the slave and puts those from it together (ETG.1000.6
/// 5.7). Frames to the slave wait in a queue of fixed size. Stays the same when the slave leaves and comes back.
class EoePort final : public MailboxStream {
 public:
  /// Frames to the slave that may wait.
  static constexpr std::size_t kQueue = 64;

  /// For the slave at `position`; `receiver` must outlive the port.
  EoePort(std::uint16_t position, EoeReceiver& receiver);

  /// Hands over an Ethernet frame without check sequence, of 14 to 1518 bytes. False, and the frame is counted: the
  /// queue is full, the length is impossible, or the port is down. One thread at a time; wait-free, no allocation.
  bool send(std::span<const std::byte> frame) noexcept;
  /// False takes the port down, whatever the slave does: frames from both sides are dropped. Any thread.
  void set_link(bool up) noexcept { wanted_.store(up, std::memory_order_relaxed); }
  /// Frames pass: the slave's mailboxes are open, and nobody has taken the port down. Any thread.
  [[nodiscard]] bool up() const noexcept {
    return open_.load(std::memory_order_relaxed) && wanted_.load(std::memory_order_relaxed);
  }
  /// How often the slave's mailboxes have been opened. After each time the slave may have forgotten what it was told.
  /// Any thread.
  [[nodiscard]] std::uint64_t openings() const noexcept { return openings_.value(); }
  /// Of the slave.
  [[nodiscard]] std::uint16_t position() const noexcept { return position_; }
  /// Since it was made; any thread. Numbers of one moment that differ by what happens meanwhile.
  [[nodiscard]] EoePortStatistics statistics() const noexcept;

  /// An EoE mail of the slave that answers no service. For EoePorts.
  void receive(std::span<const std::byte> service) noexcept;

  [[nodiscard]] wire::MailboxType type() const noexcept override { return wire::MailboxType::kEoe; }
  void opened(std::size_t room) override;
  void closed() override;
  [[nodiscard]] std::size_t next(std::span<std::byte> out) override;
  [[nodiscard]] std::size_t expected() const override { return assembler_.missing(); }
  void taken() override;
  void given_up() override;

 private:
  /// Written by one thread, read by any.
  class Counter {
   public:
    void add(std::uint64_t more = 1) noexcept {
      value_.store(value_.load(std::memory_order_relaxed) + more, std::memory_order_relaxed);
    }
    [[nodiscard]] std::uint64_t value() const noexcept { return value_.load(std::memory_order_relaxed); }

   private:
    std::atomic<std::uint64_t> value_{0};
  };
  struct Counters {
    Counter frames_out, frames_in, bytes_out, bytes_in, fragments_out, fragments_in;
    Counter refused, given_up, lost, malformed, stray;
  };

  void drop_all() noexcept;
  void forget() noexcept;

  std::uint16_t position_;
  EoeReceiver& receiver_;
  Counter openings_;
  std::atomic<bool> open_{false};
  std::atomic<bool> wanted_{true};
  rt::SpscRing<EoeFrame> queue_{kQueue};
  EoeFrame sending_;
  /// Of the mails that the slave has not taken, oldest first: bytes of the frame that ends with it; 0: none does.
  std::array<std::uint16_t, kMostOpen> open_mails_{};
  std::size_t open_count_ = 0;
  wire::EoeFragmenter fragmenter_;
  wire::EoeAssembler assembler_;
  Counters counters_;
};

}  // namespace driveline::ecat_master
