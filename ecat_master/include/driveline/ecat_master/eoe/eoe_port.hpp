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

/// Receiver of the Ethernet frames of the slaves.
class EoeReceiver {
 public:
  virtual ~EoeReceiver() = default;
  /// Receives a frame from the slave at `position`, valid during the call. Called by the thread that steps the engine;
  /// must not call the engine.
  virtual void receive(std::uint16_t position, std::span<const std::byte> frame) = 0;
};

/// An Ethernet frame without check sequence.
struct EoeFrame {
  std::uint16_t size = 0;                             ///< valid bytes of `bytes`
  std::array<std::byte, wire::kMaxEoeFrame> bytes{};  ///< the frame
};

/// Counters of a port.
struct EoePortStatistics {
  std::uint64_t frames_out = 0;     ///< complete frames to the slave
  std::uint64_t frames_in = 0;      ///< complete frames from the slave
  std::uint64_t bytes_out = 0;      ///< bytes of frames_out
  std::uint64_t bytes_in = 0;       ///< bytes of frames_in
  std::uint64_t fragments_out = 0;  ///< fragments of any frame to the slave
  std::uint64_t fragments_in = 0;   ///< fragments of any frame from the slave
  std::uint64_t full = 0;           ///< frames to the slave dropped because the queue was full
  std::uint64_t refused = 0;   ///< frames to the slave refused because of their length or because the port was down
  std::uint64_t given_up = 0;  ///< frames to the slave dropped during sending: it did not take them or was disconnected
  std::uint64_t lost = 0;      ///< frames from the slave with a missing fragment
  std::uint64_t malformed = 0;  ///< malformed mailbox messages from the slave
  std::uint64_t stray = 0;      ///< fragments of no frame in progress, and unexpected answers
  constexpr bool operator==(const EoePortStatistics&) const = default;
};

/// The master's end of a slave's EoE: sends Ethernet frames to the slave and assembles those from the slave (ETG.1000.6
/// 5.7). Frames to the slave wait in a queue of fixed size. The port persists when the slave leaves and returns.
class EoePort final : public MailboxStream {
 public:
  /// Most frames to the slave that may wait.
  static constexpr std::size_t kQueue = 64;

  /// For the slave at `position`; `receiver` must outlive the port.
  EoePort(std::uint16_t position, EoeReceiver& receiver);

  /// Queues an Ethernet frame of 14 to 1518 bytes without check sequence. Returns false and counts the frame when the
  /// queue is full, the length is invalid, or the port is down. One thread at a time; wait-free, no allocation.
  bool send(std::span<const std::byte> frame) noexcept;
  /// False takes the port down, whatever the state of the slave: frames in both directions are dropped. Any thread.
  void set_link(bool up) noexcept { wanted_.store(up, std::memory_order_relaxed); }
  /// Whether frames pass: the slave's mailboxes are open, and set_link() has not taken the port down. Any thread.
  [[nodiscard]] bool up() const noexcept {
    return open_.load(std::memory_order_relaxed) && wanted_.load(std::memory_order_relaxed);
  }
  /// Number of times that the slave's mailboxes were opened. After each time the slave may have lost its EoE settings.
  /// Any thread.
  [[nodiscard]] std::uint64_t openings() const noexcept { return openings_.value(); }
  /// Position of the slave.
  [[nodiscard]] std::uint16_t position() const noexcept { return position_; }
  /// Counters since construction; any thread. The counters may belong to slightly different instants.
  [[nodiscard]] EoePortStatistics statistics() const noexcept;

  /// Processes an EoE message from the slave that does not answer a service. Used by EoePorts.
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
  /// For each message not yet taken by the slave, oldest first: length of the frame that ends with it; 0: none does.
  std::array<std::uint16_t, kMaxOpen> open_mails_{};
  std::size_t open_count_ = 0;
  wire::EoeFragmenter fragmenter_;
  wire::EoeAssembler assembler_;
  Counters counters_;
};

}  // namespace driveline::ecat_master
