#pragma once

#include <array>
#include <atomic>
#include <chrono>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "driveline/ecat_master/cyclic/cycle_task.hpp"
#include "driveline/rt/shared_broadcast.hpp"
#include "driveline/rt/shared_region.hpp"
#include "driveline/rt/shared_ring.hpp"
#include "driveline/runtime/axes/axis_authority.hpp"
#include "driveline/runtime/config/stream_config.hpp"
#include "driveline/runtime/error.hpp"
#include "driveline/stream/greeting.hpp"
#include "driveline/stream/records.hpp"
#include "driveline/trajectory/setpoint.hpp"
#include "driveline/trajectory/setpoint_stream.hpp"
#include "stream/setpoint_check.hpp"
#include "stream/stream_axes.hpp"

namespace driveline::runtime {

/// One client from its greeting until its axes are free. Made and destroyed by the thread that owns the line; in
/// between it belongs to the cycle (StreamHub), except where something else is said.
///
/// Whatever the client writes into the shared memory costs it setpoints, and the line a bounded part of the cycle.
class StreamSession {
 public:
  /// Records that are taken in a cycle.
  static constexpr std::size_t kRecordsPerCycle = 8;
  /// Records that the ring holds.
  static constexpr std::size_t kRingRecords = 256;
  /// Setpoints of later times are refused.
  static constexpr std::chrono::nanoseconds kLongestAhead = std::chrono::seconds{1};
  /// Setpoints that may wait for their time.
  static constexpr std::size_t kSetpointsAhead = 1024;
  /// Periods for which the axes go on along the curve when the setpoints are used up, before they stop.
  static constexpr std::uint32_t kCoastCycles = 8;
  /// In a stop the deceleration rises to the limit of the axis in this time.
  static constexpr double kStopRiseSeconds = 0.02;

  /// An axis of the session.
  struct Member {
    std::size_t axis = 0;  ///< number on the line
    stream::AxisBounds bounds{};
    std::uint64_t lease = 0;  ///< by which it commands the axis (AxisAuthority)
    bool halt = false;        ///< somebody else has moved it up to now: it comes to rest before it follows
  };

  /// `authority` must outlive it. Error (kMachine): there is no memory to share.
  [[nodiscard]] static Result<std::unique_ptr<StreamSession>> make(std::vector<Member> members, bool power,
                                                                   const StreamSettings& settings,
                                                                   std::chrono::nanoseconds period,
                                                                   const AxisAuthority& authority);
  StreamSession(const StreamSession&) = delete;
  StreamSession& operator=(const StreamSession&) = delete;

  // Any thread.
  /// The axes.
  [[nodiscard]] std::span<const Member> members() const noexcept { return members_; }
  /// Memory for the client.
  [[nodiscard]] const rt::SharedRegion& setpoints() const noexcept { return ring_; }
  /// Memory for the client, and for the owner to read.
  [[nodiscard]] const rt::SharedRegion& status() const noexcept { return broadcast_; }
  /// Asks the cycle to end it; the first reason counts.
  void request_end(stream::EndReason reason) noexcept;
  /// It may command the axis: its lease goes on.
  [[nodiscard]] bool commands(std::size_t member) const noexcept {
    return authority_.goes_on(members_[member].axis, leases_[member].number.load(std::memory_order_acquire));
  }
  /// The client wants to have an axis again that somebody has taken over.
  [[nodiscard]] bool asks_for(std::size_t member) const noexcept {
    return leases_[member].asked.load(std::memory_order_relaxed);
  }
  /// What was wrong with the first setpoint that was refused for this reason; none: with it as a whole, or there was
  /// none. Once its status counts one, it stays.
  [[nodiscard]] std::optional<SetpointFault> first_fault(stream::Refusal reason) const noexcept {
    const auto& first = first_faults_[static_cast<std::size_t>(reason)];
    return first.known.load(std::memory_order_acquire) ? std::optional(first.fault) : std::nullopt;
  }
  /// A new lease for an axis. The owner's thread.
  void give(std::size_t member, std::uint64_t lease) noexcept;
  /// Somebody else has moved the axis up to now: it comes to rest before it follows. The owner's thread, before the
  /// session belongs to the cycle.
  void halt_first(std::size_t member) noexcept { members_[member].halt = true; }
  /// The lease by which it commands the axis, or did.
  [[nodiscard]] std::uint64_t lease(std::size_t member) const noexcept {
    return leases_[member].number.load(std::memory_order_relaxed);
  }

  // The cycle's side: \rtsafe.
  /// The feed of an axis is that of this session, or is not any more.
  void bind(std::size_t member, bool bound) noexcept { axes_[member].bound = bound; }
  /// An axis follows.
  [[nodiscard]] bool follows(std::size_t member) const noexcept { return axes_[member].following; }
  /// An axis begins to follow.
  void joined(std::size_t member) noexcept;
  /// Another motion has taken an axis, or it has failed.
  void left(std::size_t member) noexcept;
  /// The setpoint of this cycle; null: the session ends, or may not command the axis any more: it is to come to rest.
  [[nodiscard]] const trajectory::AxisSetpoint* setpoint(std::size_t member) noexcept;
  /// One cycle, before the axes ask for setpoints. False: it is over, its axes are free.
  [[nodiscard]] bool update(const ecat_master::TaskCycle& cycle, StreamAxes& axes) noexcept;

 private:
  struct AxisSide {
    bool following = false;
    bool wanted = true;   ///< it is to follow as soon as it can
    bool let_go = false;  ///< it has been told that there are no more setpoints
    bool bound = false;   ///< its feed is that of this session
  };
  struct Lease {
    std::atomic<std::uint64_t> number{0};
    std::atomic<bool> asked{false};
  };
  /// Written once, by the cycle, before it is known.
  struct FirstFault {
    SetpointFault fault{};
    std::atomic<bool> known{false};
  };

  StreamSession(std::vector<Member> members, bool power, const StreamSettings& settings,
                std::chrono::nanoseconds period, const AxisAuthority& authority, rt::SharedRegion ring,
                rt::SharedRegion broadcast);

  void take_records(std::chrono::nanoseconds now) noexcept;
  void take(const stream::SetpointRecord& record) noexcept;
  void take_setpoint(const stream::SetpointRecord& record) noexcept;
  void follow_again() noexcept;
  [[nodiscard]] std::optional<stream::Refusal> push(const stream::SetpointRecord& record) noexcept;
  void begin_at(std::int64_t time_ns) noexcept;
  void refuse(stream::Refusal refusal) noexcept { ++status_record_.refused[static_cast<std::size_t>(refusal)]; }
  void note_fault(const SetpointCheck::Verdict& verdict) noexcept;
  void end(stream::EndReason reason) noexcept;
  void watch(std::chrono::nanoseconds now) noexcept;
  void advance(std::chrono::nanoseconds elapsed) noexcept;
  [[nodiscard]] bool moving() const noexcept;
  [[nodiscard]] double seconds(std::int64_t time_ns) const noexcept;
  void command(StreamAxes& axes) noexcept;
  [[nodiscard]] bool at_rest(const StreamAxes& axes) const noexcept;
  void publish(const ecat_master::TaskCycle& cycle, const StreamAxes& axes) noexcept;
  [[nodiscard]] bool ending() const noexcept { return reason_ != stream::EndReason::kNone; }

  std::vector<Member> members_;
  bool power_;
  StreamSettings settings_;
  const AxisAuthority& authority_;
  rt::SharedRegion ring_;
  rt::SharedRegion broadcast_;
  rt::SharedRingReader<stream::SetpointRecord> records_;
  rt::SharedBroadcastWriter<stream::StatusRecord> statuses_;
  SetpointCheck check_;
  trajectory::SetpointStream curve_;
  std::vector<AxisSide> axes_;
  std::vector<Lease> leases_;  ///< of the axes
  std::vector<trajectory::AxisSetpoint> setpoints_;
  std::vector<double> positions_;  ///< of the axes, for the begin of a curve
  std::array<stream::SetpointRecord, kRecordsPerCycle> batch_{};
  std::optional<std::chrono::nanoseconds> heard_{};  ///< grid time of the last record
  std::optional<std::int64_t> stream_ns_{};          ///< now, on the time axis of the client
  std::int64_t begin_ns_ = 0;                        ///< where the curve has begun there
  std::optional<stream::SetpointRecord> newest_{};   ///< of the curve
  std::uint64_t breaches_ = 0;
  std::array<FirstFault, stream::kRefusals> first_faults_{};  ///< by stream::Refusal
  stream::EndReason reason_ = stream::EndReason::kNone;
  stream::StatusRecord status_record_{};
  std::atomic<stream::EndReason> end_request_{stream::EndReason::kNone};
};

}  // namespace driveline::runtime
