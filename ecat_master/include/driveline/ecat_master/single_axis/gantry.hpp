#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <optional>

#include "driveline/ecat_master/single_axis/axis_request.hpp"
#include "driveline/ecat_master/single_axis/gantry_settings.hpp"
#include "driveline/ecat_master/single_axis/request_table.hpp"
#include "driveline/ecat_master/single_axis/setpoint_generator.hpp"
#include "driveline/ecat_master/single_axis/single_axis.hpp"
#include "driveline/trajectory/profile_limits.hpp"

namespace driveline::ecat_master {

/// What a gantry does, as seen by other threads.
struct GantryReport {
  bool formed = false;      ///< the follower goes with its leader
  bool squaring = false;    ///< and is on its way to its offset
  bool warned = false;      ///< the skew is beyond its warning
  double skew = 0.0;        ///< difference of the actual positions less the offset in force; rad or m
  double worst_skew = 0.0;  ///< the largest since it was enabled, with its sign
  double stopped_at = 0.0;  ///< the skew of the last AxisError::kSkew
};

/// A gantry pair: one axis for everyone who commands, by the requests of its leader. Both get the setpoint of the
/// leader in the same cycle, are enabled, reset and switched off together, and stop together when one fails: by the
/// same ramp where the drives can, else by their own quick stops. The skew is watched in every cycle.
///
/// Belongs to the cycle; everything but the constructor is \rtsafe.
class Gantry {
 public:
  /// All must outlive it.
  Gantry(SingleAxis& leader, SingleAxis& follower, RequestTable& table, const GantrySettings& settings,
         double period_s);

  /// Whether requests of this axis are for the gantry.
  [[nodiscard]] bool has(std::size_t axis) const noexcept {
    return axis == settings_.leader || axis == settings_.follower;
  }
  /// The settings given to the constructor.
  [[nodiscard]] const GantrySettings& settings() const noexcept { return settings_; }
  /// A request to one of its axes.
  void take(std::size_t axis, std::uint64_t id, const AxisRequest& request) noexcept;
  /// What has become of both, once their cycle has begun.
  void watch() noexcept;
  /// The follower's part of the cycle, once its leader has its setpoint.
  void advance() noexcept;
  /// Any thread.
  [[nodiscard]] GantryReport report() const noexcept;

 private:
  enum class Phase : std::uint8_t {
    kApart,    ///< without power, or on the way to it
    kJoining,  ///< both have power
    kFormed,
    kDissolving,  ///< the leader comes to rest, and then both are switched off
  };
  enum class Homing : std::uint8_t {
    kNone,
    kArming,     ///< both touch probes
    kSearching,  ///< until both have seen their marks
    kReturning,  ///< of the leader to its mark
    kSquaring,
  };
  /// Of one's own, to the axes.
  struct Pair {
    std::uint64_t leader = 0;
    std::uint64_t follower = 0;
  };

  void take_power(std::uint64_t id, const AxisRequest& request) noexcept;
  void take_homing(std::uint64_t id, const AxisRequest& request) noexcept;
  [[nodiscard]] AxisError refusal(const AxisRequest& request) const noexcept;
  [[nodiscard]] AxisError refusal_of_homing(const AxisRequest& request) const noexcept;
  void finish(std::uint64_t& id, RequestPhase phase, AxisError error = AxisError::kNone) noexcept;
  [[nodiscard]] std::uint64_t ask(SingleAxis& axis, const AxisRequest& request) noexcept;
  void ask_both(Pair& pair, const AxisRequest& request) noexcept;
  [[nodiscard]] bool over(const Pair& pair) const noexcept;
  [[nodiscard]] AxisError error_of(const Pair& pair) const noexcept;
  void watch_skew() noexcept;
  void watch_failures() noexcept;
  void watch_reset() noexcept;
  void watch_power() noexcept;
  void form() noexcept;
  void dissolve() noexcept;
  void square() noexcept;
  void advance_homing() noexcept;
  void end_homing(RequestPhase phase, AxisError error = AxisError::kNone) noexcept;
  void name_marks() noexcept;
  [[nodiscard]] double difference() const noexcept;
  void publish() noexcept;

  SingleAxis& leader_;
  SingleAxis& follower_;
  RequestTable& table_;
  GantrySettings settings_;
  double period_s_;
  trajectory::ProfileLimits squaring_;
  std::optional<double> square_at_;  ///< difference of a square pair; none: not known yet
  SetpointGenerator offset_{};       ///< in force: setpoint of the follower less that of the leader
  Phase phase_ = Phase::kApart;
  Homing homing_ = Homing::kNone;
  AxisRequest homing_request_{};
  double skew_ = 0.0;
  double worst_skew_ = 0.0;
  double stopped_at_ = 0.0;
  bool warned_ = false;
  bool failed_ = false;  ///< both are in ErrorStop, or on their way there
  // Of users; 0: there is none.
  std::uint64_t power_request_ = 0;
  std::uint64_t reset_request_ = 0;
  std::uint64_t home_request_ = 0;
  // Of its own.
  Pair powers_{};
  Pair resets_{};
  Pair probes_{};
  std::uint64_t search_ = 0;

  std::atomic<bool> formed_shared_{false};
  std::atomic<bool> squaring_shared_{false};
  std::atomic<bool> warned_shared_{false};
  std::atomic<double> skew_shared_{0.0};
  std::atomic<double> worst_shared_{0.0};
  std::atomic<double> stopped_shared_{0.0};
};

}  // namespace driveline::ecat_master
