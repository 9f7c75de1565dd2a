#pragma once

#include <array>
#include <atomic>
#include <chrono>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "driveline/motion/cycle/cycle_task.hpp"
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
/// between it belongs to the cycle (StreamHub), except for functions that say otherwise.
///
/// Invalid data in the shared memory cost the client setpoints, and the line only a bounded part of the cycle.
class StreamSession {
 public:
  /// Most records processed per cycle.
  static constexpr std::size_t kRecordsPerCycle = 8;
  /// Records that the ring holds.
  static constexpr std::size_t kRingRecords = 256;
  /// Setpoints for times beyond it are refused.
  static constexpr std::chrono::nanoseconds kLongestAhead = std::chrono::seconds{1};
  /// Most setpoints that can wait for their time.
  static constexpr std::size_t kSetpointsAhead = 1024;
  /// Periods for which the axes continue along the curve after the last setpoint, before they stop.
  static constexpr std::uint32_t kCoastCycles = 8;
  /// Time in which the deceleration of a stop rises to the limit of the axis.
  static constexpr double kStopRiseSeconds = 0.02;

  /// An axis of the session.
  struct Member {
    std::size_t axis = 0;  ///< number on the line
    stream::AxisBounds bounds{};
    std::uint64_t lease = 0;  ///< lease by which the session commands the axis (AxisAuthority)
    bool halt = false;        ///< another client has moved the axis: bring it to rest before it follows
  };

  /// `authority` must outlive it. `sealing` of the memory that the client writes: kSizeOnly for another process, whose
  /// session begins after close_to_writers(). Error (kMachine): no shared memory.
  [[nodiscard]] static Result<std::unique_ptr<StreamSession>> make(
      std::vector<Member> members, bool power, const ClientStreamSettings& settings, std::chrono::nanoseconds period,
      const AxisAuthority& authority, rt::SharedSealing sealing = rt::SharedSealing::kComplete);
  StreamSession(const StreamSession&) = delete;
  StreamSession& operator=(const StreamSession&) = delete;

  // Called on any thread.
  /// Returns the axes.
  [[nodiscard]] std::span<const Member> members() const noexcept { return members_; }
  /// Returns the memory that the client writes.
  [[nodiscard]] const rt::SharedRegion& setpoints() const noexcept { return ring_; }
  /// Returns the memory that the client and the owner read.
  [[nodiscard]] const rt::SharedRegion& status() const noexcept { return broadcast_; }
  /// Seals the memory that the client writes, so that it cannot delay the cycle by page faults. Call when the client
  /// has mapped it and before the session belongs to the cycle. Error (kMachine): the client has sealed it, or there is
  /// not enough memory.
  [[nodiscard]] Result<void> close_to_writers();
  /// Requests the end of the session from the cycle; only the first reason has effect.
  void request_end(stream::EndReason reason) noexcept;
  /// Whether the session may command the axis: its lease is valid.
  [[nodiscard]] bool commands(std::size_t member) const noexcept {
    return authority_.goes_on(members_[member].axis, leases_[member].number.load(std::memory_order_acquire));
  }
  /// Whether the client requests an axis back that another client has taken over.
  [[nodiscard]] bool asks_for(std::size_t member) const noexcept {
    return leases_[member].asked.load(std::memory_order_relaxed);
  }
  /// Returns the fault of the first setpoint that was refused for this reason; none: there was none, or the setpoint
  /// was invalid as a whole. Does not change once the status counts such a refusal.
  [[nodiscard]] std::optional<SetpointFault> first_fault(stream::Refusal reason) const noexcept {
    const auto& first = first_faults_[static_cast<std::size_t>(reason)];
    return first.known.load(std::memory_order_acquire) ? std::optional(first.fault) : std::nullopt;
  }
  /// Sets a new lease for an axis. Call on the owner's thread.
  void give(std::size_t member, std::uint64_t lease) noexcept;
  /// Brings the axis to rest before it follows, because another client has moved it. Call on the owner's thread before
  /// the session belongs to the cycle.
  void halt_first(std::size_t member) noexcept { members_[member].halt = true; }
  /// Returns the present or last lease by which the session commands the axis.
  [[nodiscard]] std::uint64_t lease(std::size_t member) const noexcept {
    return leases_[member].number.load(std::memory_order_relaxed);
  }

  // Called by the cycle: \rtsafe.
  /// Reports whether the feed of an axis belongs to this session.
  void bind(std::size_t member, bool bound) noexcept { axes_[member].bound = bound; }
  /// Whether an axis follows.
  [[nodiscard]] bool follows(std::size_t member) const noexcept { return axes_[member].following; }
  /// Reports that an axis starts to follow.
  void joined(std::size_t member) noexcept;
  /// Reports that another motion has taken an axis, or that the axis has failed.
  void left(std::size_t member) noexcept;
  /// Returns the setpoint of this cycle; null: the axis must come to rest, because the session ends or may no longer
  /// command it.
  [[nodiscard]] const trajectory::AxisSetpoint* setpoint(std::size_t member) noexcept;
  /// Runs one cycle, before the axes read their setpoints. False: the session is over, its axes are free.
  [[nodiscard]] bool update(const motion::TaskCycle& cycle, StreamAxes& axes) noexcept;

 private:
  struct AxisSide {
    bool following = false;
    bool wanted = true;   ///< to follow as soon as possible
    bool let_go = false;  ///< was informed that there are no more setpoints
    bool bound = false;   ///< its feed belongs to this session
  };
  struct Lease {
    std::atomic<std::uint64_t> number{0};
    std::atomic<bool> asked{false};
  };
  /// Written once, by the cycle, before `known` is set.
  struct FirstFault {
    SetpointFault fault{};
    std::atomic<bool> known{false};
  };

  StreamSession(std::vector<Member> members, bool power, const ClientStreamSettings& settings,
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
  void publish(const motion::TaskCycle& cycle, const StreamAxes& axes) noexcept;
  [[nodiscard]] bool ending() const noexcept { return reason_ != stream::EndReason::kNone; }

  std::vector<Member> members_;
  bool power_;
  ClientStreamSettings settings_;
  const AxisAuthority& authority_;
  rt::SharedRegion ring_;
  rt::SharedRegion broadcast_;
  rt::SharedRingReader<stream::SetpointRecord> records_;
  rt::SharedBroadcastWriter<stream::StatusRecord> statuses_;
  SetpointCheck check_;
  trajectory::SetpointStream curve_;
  std::vector<AxisSide> axes_;
  std::vector<Lease> leases_;  ///< leases of the axes
  std::vector<trajectory::AxisSetpoint> setpoints_;
  std::vector<double> positions_;  ///< positions of the axes, for the start of a curve
  std::array<stream::SetpointRecord, kRecordsPerCycle> batch_{};
  std::optional<std::chrono::nanoseconds> heard_{};  ///< grid time of the last record
  std::optional<std::int64_t> stream_ns_{};          ///< present time on the time axis of the client
  std::int64_t begin_ns_ = 0;                        ///< start of the curve on the time axis of the client
  std::optional<stream::SetpointRecord> newest_{};   ///< newest setpoint of the curve
  std::uint64_t breaches_ = 0;
  std::array<FirstFault, stream::kRefusals> first_faults_{};  ///< indexed by stream::Refusal
  stream::EndReason reason_ = stream::EndReason::kNone;
  stream::StatusRecord status_record_{};
  std::atomic<stream::EndReason> end_request_{stream::EndReason::kNone};
};

}  // namespace driveline::runtime
