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

/// One datagram of acyclic access: the data to send, overwritten by the answer.
struct Request {
  wire::Command command = wire::Command::kNop;  ///< kind of access
  wire::DatagramAddress address;                ///< slave and register, or logical address
  std::span<std::byte> data;                    ///< sent; overwritten by the answer
  std::uint16_t working_counter = 0;            ///< working counter of the answer
  bool answered = false;                        ///< whether an answer arrived
  /// Not repeated when its frame is lost, because a repetition would have a different effect. The request may stay
  /// unanswered, and it is then unknown whether the slave received it.
  bool once = false;
  bool withheld = false;  ///< only for Relay::next: not sent, because an earlier request failed
};

/// Requests that are pipelined: some are sent before the answers to others are processed, so that no cycle passes
/// unused in between.
struct Relay {
  std::span<Request> begun;     ///< `next` of the previous call
  std::span<Request> requests;  ///< requests as for DatagramExchange::exchange()
  /// Sent as soon as `begun` and `requests` are answered, if all of them were answered at the first try and every write
  /// was accepted (working counter not zero). The next relay() returns the answers; until then the data must stay
  /// valid.
  std::span<Request> next;
};

/// Counts EtherCAT frames of another master on the wire and describes its most harmful datagram.
struct OtherMaster {
  std::uint64_t frames = 0;                     ///< number of frames so far
  wire::MacAddress source{};                    ///< source address of the last frame
  wire::Command command = wire::Command::kNop;  ///< most harmful datagram: a write to AL control or a station address
                                                ///< if seen, else any write, else the last read
  std::uint16_t adp = 0;                        ///< position or station address of that datagram
  std::uint16_t ado = 0;                        ///< register address of that datagram
};
/// Harm of a datagram of another master: 0: it only reads; 1: it writes; 2: it changes states or station addresses.
/// \rtsafe
[[nodiscard]] std::uint8_t harm_of(wire::Command command, std::uint16_t ado) noexcept;
/// Whether the frame comes from a driveline tool (FrameTag::guest()) that reads, or accesses a slave's mailbox or
/// registers, but changes neither states nor station addresses; such a tool is not reported as another master. \rtsafe
[[nodiscard]] bool harmless_guest(std::span<const std::byte> frame) noexcept;
/// The other master in one sentence. Allocates: not for the cycle.
[[nodiscard]] std::string describe(const OtherMaster& other);

/// Counters of an exchange.
struct ExchangeStatistics {
  std::uint64_t frames_sent = 0;        ///< frames sent, retries included
  std::uint64_t frames_received = 0;    ///< own frames received in time and undamaged
  std::uint64_t frames_lost = 0;        ///< frames without an answer in time, repeated or abandoned
  std::uint64_t frames_stale = 0;       ///< frames that arrived twice or after they were abandoned
  std::uint64_t frames_foreign = 0;     ///< foreign or damaged frames; without those of a harmless_guest()
  std::uint64_t floods = 0;             ///< waits for answers that were ended by too many other frames
  std::uint64_t frames_of_masters = 0;  ///< number of these that are EtherCAT frames of another sender
  wire::MacAddress other_master{};      ///< source address of the last such frame
};

/// One sentence on foreign traffic: another master, or other devices on the wire. Empty when there is none. Allocates:
/// not for the cycle.
[[nodiscard]] std::string describe_traffic(const ExchangeStatistics& statistics);

/// Carries the datagrams of acyclic access (discovery, states, mailboxes): directly through the port before the cycle
/// runs, in the gaps of the cycle while it runs. Callers need not know which.
///
/// Not real-time safe; one thread at a time.
class DatagramExchange {
 public:
  virtual ~DatagramExchange() = default;

  /// Sends all requests, packed into as few frames as possible, and waits for the answers; requests in lost frames are
  /// repeated, except with Request::once. Errors: NoAnswer when a frame stays unanswered after all retries, LinkDown,
  /// ProcessDataSize when a request does not fit into a frame. A working counter of zero is not an error here.
  [[nodiscard]] virtual Result<void> exchange(std::span<Request> requests) = 0;
  /// Whether relay() uses Relay::next.
  [[nodiscard]] virtual bool relays() const noexcept { return false; }
  /// Does exchange() for Relay::begun, sending each of its requests once, and for Relay::requests. Requests begun by
  /// another exchange stay unanswered. Relay::next must be empty unless relays().
  [[nodiscard]] virtual Result<void> relay(const Relay& relay) {
    for (auto& request : relay.begun) request.answered = request.withheld = false;
    return exchange(relay.requests);
  }

  /// Waits between two polls, on the clock of the line, so that virtual time advances.
  virtual void pause(std::chrono::nanoseconds duration) = 0;
  /// Time of the clock that pause() advances.
  [[nodiscard]] virtual std::chrono::nanoseconds now() const noexcept = 0;
};

}  // namespace driveline::ecat_master
