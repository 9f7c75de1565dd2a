#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "driveline/runtime/event/stream_events.hpp"
#include "driveline/stream/greeting.hpp"
#include "driveline/stream/records.hpp"

namespace driveline::runtime {

/// Looks at each setpoint of a client before it is believed: the client may have written anything. What times have to
/// do with one another is left to the trajectory::SetpointStream behind it. Belongs to the cycle; everything but the
/// constructor is \rtsafe.
class SetpointCheck {
 public:
  /// What becomes of a setpoint.
  struct Verdict {
    bool taken = false;
    std::optional<stream::Refusal> remark{};  ///< why not; kGap also of one that is taken
    std::optional<SetpointFault> fault{};     ///< what of which axis; none: it is wrong as a whole
  };

  /// `bounds`: of the axes of the client, as their drives count.
  explicit SetpointCheck(std::vector<stream::AxisBounds> bounds);

  /// The positions of setpoints of this axis are those of the drive plus `offset` from now on.
  void set_offset(std::size_t axis, double offset) noexcept { offsets_[axis] = offset; }

  /// `before`: the setpoint that was taken before; null: there is none that this one has to be reached from.
  [[nodiscard]] Verdict judge(const stream::SetpointRecord& record, const stream::SetpointRecord* before) noexcept;

 private:
  [[nodiscard]] std::optional<Verdict> wrong_by_itself(const stream::SetpointRecord& record) const noexcept;
  [[nodiscard]] std::optional<Verdict> wrong_target(std::size_t axis, const stream::AxisTarget& target) const noexcept;
  [[nodiscard]] std::optional<Verdict> too_far(const stream::SetpointRecord& record,
                                               const stream::SetpointRecord& before) const noexcept;

  std::vector<stream::AxisBounds> bounds_;
  std::vector<double> offsets_;
  std::uint64_t number_ = 0;  ///< the last, taken or not
};

}  // namespace driveline::runtime
