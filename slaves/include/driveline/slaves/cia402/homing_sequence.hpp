#pragma once

#include <array>
#include <chrono>
#include <cstdint>
#include <optional>

namespace driveline::slaves {

/// Inputs of homing in one control cycle. Positions in encoder increments, counted upwards in the positive direction of
/// the axis.
struct HomingInputs {
  bool negative_limit = false;              ///< limit switch at the negative end, active
  bool positive_limit = false;              ///< limit switch at the positive end, active
  bool home_switch = false;                 ///< home switch (cam), active
  std::int64_t position = 0;                ///< present position
  std::optional<std::int64_t> index_pulse;  ///< position of the pulse, if it was passed in this cycle
  int travel = 0;                           ///< direction the axis really moves in: -1, 0, 1
  bool standstill = false;                  ///< the demand is zero and the axis stands
};

/// The movements of the homing methods of CiA 402 (6098h): 1-14 with index pulse, 17-30 without, 33 and 34 index pulse
/// alone, 35 and 37 the present position. 15, 16, 31, 32 are reserved, 36 and the manufacturer's negative methods are
/// not part of CiA 402 or not described.
///
/// Switches are searched with the fast speed; the edge that becomes the home position is always passed with the slow
/// one, so without an index pulse an edge found on the way there is left and passed again. An index pulse counts from
/// the switch edge on. Where the home position is found, the axis stops; it does not return to it (ours).
class HomingSequence {
 public:
  /// State of the homing.
  enum class State : std::uint8_t {
    kIdle,         ///< nothing was started
    kSearching,    ///< moving towards the home position
    kStopping,     ///< home position found, the axis brakes
    kAttained,     ///< home position found, the axis stands
    kInterrupted,  ///< ended by interrupt()
    kFailed,       ///< failed, failure() is the cause
  };
  /// Cause of a failure.
  enum class Failure : std::uint8_t {
    kNone,         ///< no failure, or the method is not supported
    kLimitSwitch,  ///< a limit switch stopped the axis where the method does not turn round
    kTimeOut,      ///< it took longer than step() allows
  };
  /// Movement that homing demands: run in this direction (0: stand still).
  struct Demand {
    int direction = 0;  ///< -1, 0 or 1
    bool slow = false;  ///< with the slow speed (6099h:02), else with the fast one (6099h:01)
  };

  /// Whether the method is one of those above. \rtsafe
  [[nodiscard]] static bool supported(std::int8_t method) noexcept;

  /// Starts; an earlier result is discarded. Fails at once with a method that is not supported. \rtsafe
  void start(std::int8_t method, const HomingInputs& inputs) noexcept;
  /// Stops the axis and ends homing; no effect unless it runs. \rtsafe
  void interrupt() noexcept;
  /// Forgets everything. \rtsafe
  void reset() noexcept { *this = HomingSequence{}; }
  /// One control cycle; fails when `time_out` has passed since the start. \rtsafe
  void step(const HomingInputs& inputs, std::chrono::nanoseconds dt, std::chrono::nanoseconds time_out) noexcept;

  /// \rtsafe
  [[nodiscard]] State state() const noexcept { return state_; }
  /// Valid in State::kFailed. \rtsafe
  [[nodiscard]] Failure failure() const noexcept { return failure_; }
  /// Whether homing runs: started, and neither attained nor ended. \rtsafe
  [[nodiscard]] bool running() const noexcept { return state_ == State::kSearching || state_ == State::kStopping; }
  /// The present demand: standing still in every state but kSearching. \rtsafe
  [[nodiscard]] Demand demand() const noexcept;
  /// The home position, once it is found. \rtsafe
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
  int mirror_ = 1;        ///< -1: the method is the mirror image of its neighbour
  int cam_variant_ = -1;  ///< methods 7-14, 23-30 while a limit switch may still turn the axis round
  bool with_index_ = false;
  bool level_ = false;     ///< of the switch, one cycle ago
  std::int64_t edge_ = 0;  ///< where the last edge was found
  std::optional<std::int64_t> home_;
  std::chrono::nanoseconds elapsed_{0};
};

}  // namespace driveline::slaves
