#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <list>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "driveline/rt/shared_ring.hpp"
#include "driveline/runtime/axes/axis_authority.hpp"
#include "driveline/runtime/config/stream_config.hpp"
#include "driveline/runtime/error.hpp"
#include "driveline/runtime/event/event.hpp"
#include "driveline/snapshot/feed/setpoint_records.hpp"
#include "driveline/stream/records.hpp"
#include "stream/session_watch.hpp"
#include "stream/stream_hub.hpp"
#include "stream/stream_session.hpp"

namespace driveline::runtime {

/// Streams of setpoints from remote clients. Each stream has a session in the cycle, like a client in shared memory,
/// with the same checks and the same end; this object writes into the ring of the session. The client owns the axes by
/// the leases that it names in every record; when a lease ends, its axis leaves the stream.
///
/// Belongs to one thread at a time; destroy it while the cycle does not run.
class RemoteStreams {
 public:
  /// Most streams at a time; the remaining sessions are for clients in shared memory.
  static constexpr std::size_t kMaxStreams = StreamHub::kMaxSessions / 2;
  /// Interval of the reports about a stream if nothing else happens, and of the reports about refused streams.
  static constexpr std::chrono::milliseconds kReportInterval{20};

  /// `axes`: axes that accept streams. `hub` and `authority` must outlive it.
  RemoteStreams(StreamHub& hub, const AxisAuthority& authority, const ClientStreamSettings& settings,
                std::vector<StreamAxis> axes, std::chrono::nanoseconds period)
      : hub_(hub), authority_(authority), settings_(settings), axes_(std::move(axes)), period_(period) {}

  /// Processes one record, which is not trusted except for `owner`, the name of the client in its leases. Returns true
  /// if the client owns all axes of the record.
  bool take(const snapshot::StreamedSetpoint& record, const std::string& owner, std::chrono::nanoseconds now);
  /// Supervises the streams. Call every few milliseconds.
  void poll(std::chrono::nanoseconds now);
  /// Ends all streams; their axes come to rest.
  void end_all(stream::EndReason reason);
  /// Refuses new streams from now on, because the line ends.
  void close() noexcept { closed_ = true; }

  /// Returns the reports since the last call.
  [[nodiscard]] std::vector<snapshot::StreamReport> take_reports() { return std::exchange(reports_, {}); }
  /// Returns the events since the last call.
  [[nodiscard]] std::vector<EventFacts> take_events() { return std::exchange(events_, {}); }

 private:
  using Instant = std::chrono::nanoseconds;
  struct Stream {
    snapshot::CommandParticipant participant{};
    snapshot::FeedText<63> client;
    std::unique_ptr<StreamSession> session;
    rt::SharedRingWriter<stream::SetpointRecord> ring;
    SessionWatch watch;
    std::string text{};  ///< the last fault
    Instant next_report{};
    stream::SessionState reported = stream::SessionState::kOver;
    bool over = false;  ///< the session is over, and reported
  };

  [[nodiscard]] Stream* find(const snapshot::StreamedSetpoint& record) noexcept;
  [[nodiscard]] Result<Stream*> begin(const snapshot::StreamedSetpoint& record, const std::string& owner);
  [[nodiscard]] Result<std::vector<StreamAxis>> choose(const snapshot::StreamedSetpoint& record,
                                                       const std::string& owner) const;
  [[nodiscard]] bool his(std::size_t axis, std::uint64_t lease, const std::string& owner) const;
  [[nodiscard]] bool lease_again(Stream& stream, const snapshot::StreamedSetpoint& record, const std::string& owner);
  void write(Stream& stream, const snapshot::StreamedSetpoint& record);
  void refuse(const snapshot::StreamedSetpoint& record, const std::string& owner, const std::string& reason,
              Instant now);
  void poll_stream(Stream& stream, Instant now);
  void report(Stream& stream, Instant now);

  StreamHub& hub_;
  const AxisAuthority& authority_;
  ClientStreamSettings settings_;
  std::vector<StreamAxis> axes_;
  std::chrono::nanoseconds period_;
  bool closed_ = false;
  std::list<Stream> streams_;
  std::vector<snapshot::StreamReport> reports_;
  std::vector<EventFacts> events_;
  Instant next_refusal_{};
  Instant next_refusal_event_{};
  std::uint64_t unreported_ = 0;  ///< refusals without an event so far
};

}  // namespace driveline::runtime
