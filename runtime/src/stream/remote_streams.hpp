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
#include "driveline/runtime/event.hpp"
#include "driveline/snapshot/feed/setpoint_records.hpp"
#include "driveline/stream/records.hpp"
#include "stream/session_watch.hpp"
#include "stream/stream_hub.hpp"
#include "stream/stream_session.hpp"

namespace driveline::runtime {

/// Streams of setpoints whose clients are elsewhere: each has a session in the cycle as a client in shared memory has,
/// with the same checks and the same end, and this object writes into its ring. The axes are the client's by the leases
/// that he names in every record; a lease that ends takes its axis out of the stream.
///
/// Belongs to one thread at a time; destroyed when the cycle does not run.
class RemoteStreams {
 public:
  /// At a time; room remains for clients in shared memory.
  static constexpr std::size_t kMostStreams = StreamHub::kMostSessions / 2;
  /// From one report about a stream to the next, if nothing else happens; of refusals of new streams, too.
  static constexpr std::chrono::milliseconds kReportInterval{20};

  /// `axes`: that may be streamed to. `hub` and `authority` must outlive it.
  RemoteStreams(StreamHub& hub, const AxisAuthority& authority, const StreamSettings& settings,
                std::vector<StreamAxis> axes, std::chrono::nanoseconds period)
      : hub_(hub), authority_(authority), settings_(settings), axes_(std::move(axes)), period_(period) {}

  /// One record, of which nothing is believed but whose it is: `owner`, as his leases have him. True: all axes in it
  /// are his.
  bool take(const snapshot::StreamedSetpoint& record, const std::string& owner, std::chrono::nanoseconds now);
  /// Looks after the streams. To be called every few milliseconds.
  void look(std::chrono::nanoseconds now);
  /// All streams end, their axes come to rest.
  void end_all(stream::EndReason reason);
  /// What comes is for the line before this one, or the line ends: no new streams.
  void close() noexcept { closed_ = true; }

  /// Since the last call.
  [[nodiscard]] std::vector<snapshot::StreamReport> take_reports() { return std::exchange(reports_, {}); }
  /// Likewise.
  [[nodiscard]] std::vector<EventFacts> take_events() { return std::exchange(events_, {}); }

 private:
  using Instant = std::chrono::nanoseconds;
  struct Stream {
    snapshot::CommandParticipant participant{};
    snapshot::FeedText<63> client;
    std::unique_ptr<StreamSession> session;
    rt::SharedRingWriter<stream::SetpointRecord> ring;
    SessionWatch watch;
    std::string text{};  ///< what was wrong last
    Instant next_report{};
    stream::SessionState reported = stream::SessionState::kOver;
    bool over = false;  ///< and told
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
  void look_at(Stream& stream, Instant now);
  void report(Stream& stream, Instant now);

  StreamHub& hub_;
  const AxisAuthority& authority_;
  StreamSettings settings_;
  std::vector<StreamAxis> axes_;
  std::chrono::nanoseconds period_;
  bool closed_ = false;
  std::list<Stream> streams_;
  std::vector<snapshot::StreamReport> reports_;
  std::vector<EventFacts> events_;
  Instant next_refusal_{};
  Instant next_refusal_event_{};
  std::uint64_t untold_ = 0;  ///< refusals
};

}  // namespace driveline::runtime
