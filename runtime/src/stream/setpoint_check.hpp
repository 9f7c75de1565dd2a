#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "driveline/runtime/event/stream_events.hpp"
#include "driveline/stream/greeting.hpp"
#include "driveline/stream/records.hpp"

namespace driveline::runtime {

/// Checks each setpoint of a client, which may have written anything. The trajectory::SetpointStream that receives the
/// setpoints checks how their times relate. Belongs to the cycle; everything except the constructor is \rtsafe.
class SetpointCheck {
 public:
  /// Result of the check of a setpoint.
  struct Verdict {
    bool taken = false;
    std::optional<stream::Refusal> remark{};  ///< reason of a refusal; kGap also for an accepted setpoint
    std::optional<SetpointFault> fault{};     ///< wrong value and its axis; none: the setpoint is invalid as a whole
  };

  /// `bounds`: bounds of the client's axes, as their drives count.
  explicit SetpointCheck(std::vector<stream::AxisBounds> bounds);

  /// From now on, positions in setpoints of this axis are those of the drive plus `offset`.
  void set_offset(std::size_t axis, double offset) noexcept { offsets_[axis] = offset; }

  /// Checks a setpoint. `before`: last accepted setpoint; null: there is none from which this one must be reached.
  [[nodiscard]] Verdict judge(const stream::SetpointRecord& record, const stream::SetpointRecord* before) noexcept;

 private:
  [[nodiscard]] std::optional<Verdict> wrong_by_itself(const stream::SetpointRecord& record) const noexcept;
  [[nodiscard]] std::optional<Verdict> wrong_target(std::size_t axis, const stream::AxisTarget& target) const noexcept;
  [[nodiscard]] std::optional<Verdict> too_far(const stream::SetpointRecord& record,
                                               const stream::SetpointRecord& before) const noexcept;

  std::vector<stream::AxisBounds> bounds_;
  std::vector<double> offsets_;
  std::uint64_t number_ = 0;  ///< number of the last setpoint, accepted or not
};

}  // namespace driveline::runtime
