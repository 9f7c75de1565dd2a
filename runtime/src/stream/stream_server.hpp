#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "driveline/rt/file_descriptor.hpp"
#include "driveline/runtime/axes/axis_authority.hpp"
#include "driveline/runtime/config/stream_config.hpp"
#include "driveline/runtime/error.hpp"
#include "driveline/runtime/event/event.hpp"
#include "driveline/stream/greeting.hpp"
#include "driveline/stream/records.hpp"
#include "stream/session_watch.hpp"
#include "stream/stream_hub.hpp"
#include "stream/stream_session.hpp"
#include "stream/stream_socket.hpp"

namespace driveline::runtime {

/// Accepts clients, gives each its axes and its memory, and supervises it until the axes are free. A client owns its
/// axes by leases (AxisAuthority). Belongs to the thread that owns the line; never waits.
class StreamServer {
 public:
  /// Starts to listen. `hub` and `authority` must outlive it. Error (kMachine): that of the socket.
  [[nodiscard]] static Result<std::unique_ptr<StreamServer>> open(const StreamConfig& config,
                                                                  std::vector<StreamAxis> axes, StreamHub& hub,
                                                                  AxisAuthority& authority,
                                                                  std::chrono::nanoseconds period);
  /// Call while the cycle does not run.
  ~StreamServer();
  StreamServer(const StreamServer&) = delete;
  StreamServer& operator=(const StreamServer&) = delete;

  /// Checks all connections once. Returns the events since the last call.
  [[nodiscard]] std::vector<Event> poll();
  /// Ends all sessions, and accepts no further clients; poll() reports when they are over.
  void close();
  /// Whether there are no sessions.
  [[nodiscard]] bool idle() const noexcept { return clients_.empty() && newcomers_.empty(); }
  /// Returns socket and axes.
  [[nodiscard]] events::StreamUp offer() const;

 private:
  using Instant = std::chrono::steady_clock::time_point;

  /// A connected client that has not sent its Hello yet.
  struct Visitor {
    rt::FileDescriptor socket;
    StreamPeer peer;
    Instant since;
  };
  /// A client that has received its memory and has not confirmed yet that it has mapped it. It has no axis yet.
  struct Newcomer {
    Visitor visitor;
    std::unique_ptr<StreamSession> session;
    LeaseTerms terms;
  };
  struct Client {
    rt::FileDescriptor socket;
    std::unique_ptr<StreamSession> session;
    SessionWatch watch;
  };

  StreamServer(const StreamConfig& config, std::vector<StreamAxis> axes, StreamHub& hub, AxisAuthority& authority,
               std::chrono::nanoseconds period, StreamSocket socket);

  void let_in();
  void hear_visitors();
  [[nodiscard]] bool hear(Visitor& visitor);
  void greet(Visitor& visitor, const stream::Hello& hello);
  void hear_newcomers();
  [[nodiscard]] bool hear(Newcomer& newcomer);
  void begin(Newcomer& newcomer);
  [[nodiscard]] Result<std::vector<StreamSession::Member>> choose(const stream::Hello& hello) const;
  [[nodiscard]] Result<void> check(std::span<const StreamSession::Member> members, const LeaseTerms& terms) const;
  [[nodiscard]] Error refusal_of(const StreamSession::Member& member, const LeaseRefusal& owned) const;
  [[nodiscard]] Result<void> admit(StreamSession& session, const LeaseTerms& terms);
  [[nodiscard]] stream::Answer acceptance(const StreamSession& session) const;
  void refuse(Visitor& visitor, const std::string& reason);
  void look_after_clients();
  void lease_again(Client& client);
  void release(const StreamPeer& peer, std::size_t axis, std::uint64_t lease);
  [[nodiscard]] const StreamAxis& offered(std::size_t axis) const;
  void note(EventFacts facts, Severity severity);

  StreamConfig config_;
  std::vector<StreamAxis> axes_;
  StreamHub& hub_;
  AxisAuthority& authority_;
  std::chrono::nanoseconds period_;
  std::optional<StreamSocket> socket_;
  std::vector<Visitor> visitors_;
  std::vector<Newcomer> newcomers_;
  std::vector<std::unique_ptr<Client>> clients_;
  std::vector<Event> events_;
  SessionWatch::Note note_{[this](EventFacts facts, Severity severity) { note(std::move(facts), severity); }};
  Instant last_refusal_{};
  std::uint64_t unreported_ = 0;  ///< refusals without an event so far
};

}  // namespace driveline::runtime
