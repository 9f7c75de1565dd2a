#pragma once

#include <array>
#include <chrono>
#include <cstdint>
#include <optional>

namespace driveline::slaves {

/// Inputs of homing in one control cycle. Positions are in encoder increments in the positive direction of the axis.
struct HomingInputs {
  bool negative_limit = false;              ///< limit switch at the negative end is active
  bool positive_limit = false;              ///< limit switch at the positive end is active
  bool home_switch = false;                 ///< home switch (cam) is active
  std::int64_t position = 0;                ///< current position
  std::optional<std::int64_t> index_pulse;  ///< position of the index pulse, if it was passed in this cycle
  int travel = 0;                           ///< actual direction of motion: -1, 0, 1
  bool standstill = false;                  ///< the demand is zero and the axis is at standstill
};

/// Movements of the homing methods of CiA 402 (6098h): 1-14 with index pulse, 17-30 without, 33 and 34 index pulse
/// only, 35 and 37 the current position. 15, 16, 31, 32 are reserved; 36 and the manufacturer's negative methods are
/// not part of CiA 402 or not described.
///
/// Switches are searched at the fast speed, but the edge that becomes the home position is always crossed at the slow
/// speed; without an index pulse, an edge found at the fast speed is therefore left and crossed again. An index pulse
/// counts only after the switch edge. The axis stops after the home position is found; it does not return to it (ours).
class HomingSequence {
 public:
  /// State of the homing.
  enum class State : std::uint8_t {
    kIdle,         ///< not started
    kSearching,    ///< moving towards the home position
    kStopping,     ///< home position found, the axis decelerates
    kAttained,     ///< home position found, the axis is at standstill
    kInterrupted,  ///< ended by interrupt()
    kFailed,       ///< failed, failure() is the cause
  };
  /// Cause of a failure.
  enum class Failure : std::uint8_t {
    kNone,         ///< no failure, or the method is not supported
    kLimitSwitch,  ///< a limit switch stopped the axis where the method does not reverse
    kTimeOut,      ///< homing took longer than step() allows
  };
  /// Movement that homing demands: run in this direction (0: standstill).
  struct Demand {
    int direction = 0;  ///< -1, 0 or 1
    bool slow = false;  ///< at the slow speed (6099h:02), else at the fast speed (6099h:01)
  };

  /// Whether the method is supported, see above. \rtsafe
  [[nodiscard]] static bool supported(std::int8_t method) noexcept;

  /// Starts homing; discards an earlier result. Fails at once if the method is not supported. \rtsafe
  void start(std::int8_t method, const HomingInputs& inputs) noexcept;
  /// Stops the axis and ends homing; no effect unless homing runs. \rtsafe
  void interrupt() noexcept;
  /// Resets to State::kIdle. \rtsafe
  void reset() noexcept { *this = HomingSequence{}; }
  /// Runs one control cycle; homing fails when `time_out` has passed since the start. \rtsafe
  void step(const HomingInputs& inputs, std::chrono::nanoseconds dt, std::chrono::nanoseconds time_out) noexcept;

  /// \rtsafe
  [[nodiscard]] State state() const noexcept { return state_; }
  /// Valid in State::kFailed. \rtsafe
  [[nodiscard]] Failure failure() const noexcept { return failure_; }
  /// Whether homing was started and is neither attained nor ended. \rtsafe
  [[nodiscard]] bool running() const noexcept { return state_ == State::kSearching || state_ == State::kStopping; }
  /// Returns the current demand: standstill in every state but kSearching. \rtsafe
  [[nodiscard]] Demand demand() const noexcept;
  /// Returns the home position; nullopt until it is found. \rtsafe
  [[nodiscard]] std::optional<std::int64_t> home() const noexcept { return home_; }

 private:
  enum class Switch : std::uint8_t { kNegativeLimit, kPositiveLimit, kHome };
  enum class Until : std::uint8_t { kActive, kInactive, kIndex };
  struct Leg {
    int direction = 0;
    Until until = Until::kIndex;
    bool slow = false;
  };
  void plan(std::int8_t method, const HomingInputs& inputs) noexcept;
  void plan_limit(bool on) noexcept;
  void plan_half(int variant, bool on, bool index) noexcept;
  void plan_cam(int variant, bool on, bool index) noexcept;
  void add(int direction, Until until, bool slow) noexcept;
  void finish_with(bool index) noexcept;
  [[nodiscard]] bool level(const HomingInputs& inputs) const noexcept;
  [[nodiscard]] bool blocked(const HomingInputs& inputs) const noexcept;
  void turn_at_limit() noexcept;
  void leg_done(std::int64_t position) noexcept;

  State state_ = State::kIdle;
  Failure failure_ = Failure::kNone;
  Switch switch_ = Switch::kHome;
  std::array<Leg, 8> legs_{};
  std::size_t count_ = 0;
  std::size_t current_ = 0;
  int mirror_ = 1;        ///< -1: the directions of the planned method are mirrored
  int cam_variant_ = -1;  ///< variant of methods 7-14, 23-30 while a limit switch may still reverse the search; else -1
  bool with_index_ = false;
  bool level_ = false;     ///< level of the switch in the previous cycle
  std::int64_t edge_ = 0;  ///< position of the last edge
  std::optional<std::int64_t> home_;
  std::chrono::nanoseconds elapsed_{0};
};

}  // namespace driveline::slaves
