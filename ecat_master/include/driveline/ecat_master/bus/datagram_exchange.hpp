#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>

#include "driveline/ecat_master/error.hpp"
#include "driveline/wire/datagram.hpp"
#include "driveline/wire/ethernet.hpp"

namespace driveline::ecat_master {

/// One datagram of acyclic work: what to send, and what came back into the same data.
struct Request {
  wire::Command command = wire::Command::kNop;  ///< kind of access
  wire::DatagramAddress address;                ///< slave and register, or logical address
  std::span<std::byte> data;                    ///< sent; overwritten by the answer
  std::uint16_t working_counter = 0;            ///< of the answer
  bool answered = false;                        ///< false: no answer came
  /// Not sent again when its frame was lost, because a second time would do something else; it may stay unanswered, and
  /// then nobody knows whether the slave has had it.
  bool once = false;
  bool withheld = false;  ///< of Relay::next: it was not sent, because something in front of it failed
};

/// Requests of which some are handed over before others are back, so that no cycle passes unused in between.
struct Relay {
  std::span<Request> begun;     ///< `next` of the call before
  std::span<Request> requests;  ///< as of DatagramExchange::exchange()
  /// Sent as soon as `begun` and `requests` are back, if all of it was answered at the first try and every write has
  /// been taken (working counter not zero). The answers are those of the next relay(); until then the data must stay.
  std::span<Request> next;
};

/// EtherCAT frames of another master on the wire, and the most harmful datagram among them.
struct OtherMaster {
  std::uint64_t frames = 0;                     ///< so far
  wire::MacAddress source{};                    ///< of the last one
  wire::Command command = wire::Command::kNop;  ///< first datagram: a write to AL control or a station address if there
                                                ///< was one, else any write, else the last read
  std::uint16_t adp = 0;                        ///< of that datagram
  std::uint16_t ado = 0;                        ///< of that datagram: the register
};
/// How much harm a datagram of another master does: 0 none, it reads; 1 it writes; 2 it changes states or station
/// addresses. \rtsafe
[[nodiscard]] std::uint8_t harm_of(wire::Command command, std::uint16_t ado) noexcept;
/// A tool of this program (FrameTag::guest()) that reads, or talks to a slave's mailbox or registers, but changes
/// neither states nor station addresses; it is not reported as another master. \rtsafe
[[nodiscard]] bool harmless_guest(std::span<const std::byte> frame) noexcept;
/// One sentence. Allocates: not for the cycle.
[[nodiscard]] std::string describe(const OtherMaster& other);

/// Counters of an exchange.
struct ExchangeStatistics {
  std::uint64_t frames_sent = 0;        ///< retries included
  std::uint64_t frames_received = 0;    ///< own ones, in time and undamaged
  std::uint64_t frames_lost = 0;        ///< not answered in time, sent again or given up
  std::uint64_t frames_stale = 0;       ///< came back after they had been given up, or twice
  std::uint64_t frames_foreign = 0;     ///< not ours, or damaged; without those of a harmless_guest()
  std::uint64_t frames_of_masters = 0;  ///< those of them that are EtherCAT frames of another sender
  wire::MacAddress other_master{};      ///< source address of the last of these
};

/// One sentence on foreign traffic: another master, or other devices on the wire. Empty when there was none. Allocates:
/// not for the cycle.
[[nodiscard]] std::string describe_traffic(const ExchangeStatistics& statistics);

/// Carries the datagrams of acyclic work (discovery, states, mailboxes): directly through the port before the cycle
/// runs, in the gaps of the cycle while it does. Callers need not know which.
///
/// Not real-time safe; one thread at a time.
class DatagramExchange {
 public:
  virtual ~DatagramExchange() = default;

  /// Sends all requests, packed into as few frames as fit, and waits for the answers; what was in lost frames is
  /// repeated, except Request::once.
  /// Errors: NoAnswer when a frame stays unanswered after all retries, LinkDown, ProcessDataSize when one
  /// request does not fit into a frame. A working counter of zero is no error here.
  [[nodiscard]] virtual Result<void> exchange(std::span<Request> requests) = 0;
  /// relay() makes use of Relay::next.
  [[nodiscard]] virtual bool relays() const noexcept { return false; }
  /// exchange() for Relay::begun, of which each request is sent once, and Relay::requests. What was begun with another
  /// exchange stays unanswered. Without relays() there must be no Relay::next.
  [[nodiscard]] virtual Result<void> relay(const Relay& relay) {
    for (auto& request : relay.begun) request.answered = request.withheld = false;
    return exchange(relay.requests);
  }

  /// Lets time pass between two polls (on the clock of the line, so that virtual time moves on).
  virtual void pause(std::chrono::nanoseconds duration) = 0;
  /// Time of the clock that pause() advances.
  [[nodiscard]] virtual std::chrono::nanoseconds now() const noexcept = 0;
};

}  // namespace driveline::ecat_master
