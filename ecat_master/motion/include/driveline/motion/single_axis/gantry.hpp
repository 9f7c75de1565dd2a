#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <optional>

#include "driveline/motion/single_axis/axis_request.hpp"
#include "driveline/motion/single_axis/gantry_settings.hpp"
#include "driveline/motion/single_axis/request_table.hpp"
#include "driveline/motion/single_axis/setpoint_generator.hpp"
#include "driveline/motion/single_axis/single_axis.hpp"
#include "driveline/trajectory/profile_limits.hpp"

namespace driveline::motion {

/// State of a gantry as seen by other threads.
struct GantryReport {
  bool formed = false;      ///< the follower moves with its leader
  bool squaring = false;    ///< the pair is formed, and the follower moves to its offset
  bool warned = false;      ///< the skew exceeds its warning threshold
  double skew = 0.0;        ///< difference of the actual positions minus the offset in force; rad or m
  double worst_skew = 0.0;  ///< largest skew since the pair was enabled, signed; rad or m
  double stopped_at = 0.0;  ///< skew at the last AxisError::kSkew, rad or m
};

/// A gantry pair: two axes commanded as one, by requests to its leader. Both get the setpoint of the leader in the same
/// cycle, and are enabled, reset and switched off together. If one fails, both stop together: by the same ramp if the
/// drives can, else by their own quick stops. The skew is checked in every cycle.
///
/// Used by the cycle thread only; everything except the constructor is \rtsafe.
class Gantry {
 public:
  /// All references must outlive the gantry.
  Gantry(SingleAxis& leader, SingleAxis& follower, RequestTable& table, const GantrySettings& settings,
         double period_s);

  /// Whether the gantry handles requests to this axis.
  [[nodiscard]] bool has(std::size_t axis) const noexcept {
    return axis == settings_.leader || axis == settings_.follower;
  }
  /// The settings given to the constructor.
  [[nodiscard]] const GantrySettings& settings() const noexcept { return settings_; }
  /// Takes a request to an axis of the pair.
  void take(std::size_t axis, std::uint64_t id, const AxisRequest& request) noexcept;
  /// Updates the state of the pair; to be called after begin_cycle() of both axes.
  void watch() noexcept;
  /// Computes the setpoint of the follower; to be called after that of its leader.
  void advance() noexcept;
  /// State of the pair. Any thread.
  [[nodiscard]] GantryReport report() const noexcept;

 private:
  enum class Phase : std::uint8_t {
    kApart,    ///< without power, or being enabled or switched off
    kJoining,  ///< both have power
    kFormed,
    kDissolving,  ///< the leader comes to rest, then both are switched off
  };
  enum class Homing : std::uint8_t {
    kNone,
    kArming,     ///< both touch probes are being armed
    kSearching,  ///< moving until both have detected their marks
    kReturning,  ///< the leader returns to its mark
    kSquaring,
  };
  /// Numbers of the requests that the gantry itself sent to its axes.
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
  std::optional<double> square_at_;  ///< follower minus leader position when square; none: not known yet
  SetpointGenerator offset_{};       ///< offset in force: setpoint of the follower minus that of the leader
  Phase phase_ = Phase::kApart;
  Homing homing_ = Homing::kNone;
  AxisRequest homing_request_{};
  double skew_ = 0.0;
  double worst_skew_ = 0.0;
  double stopped_at_ = 0.0;
  bool warned_ = false;
  bool failed_ = false;  ///< both are in ErrorStop, or stopping
  // Numbers of user requests; 0: none.
  std::uint64_t power_request_ = 0;
  std::uint64_t reset_request_ = 0;
  std::uint64_t home_request_ = 0;
  // Numbers of the gantry's own requests.
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

}  // namespace driveline::motion
