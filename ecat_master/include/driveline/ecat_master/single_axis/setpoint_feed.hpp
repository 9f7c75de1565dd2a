#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "driveline/ecat_master/single_axis/axis_request.hpp"
#include "driveline/trajectory/setpoint.hpp"

namespace driveline::ecat_master {

/// Setpoints that some axes follow in SynchronizedMotion, from their request AxisCommand::kFollow on until another
/// motion takes them away: a stream out of another process, a gear, a cam. Whatever it gives, the axes follow within
/// their limits: one that is not where the feed wants it gets there in a motion of its own (trajectory::Rejoin), so a
/// leap of the feed is none of the axis.
///
/// All functions belong to the cycle: \rtsafe.
class SetpointFeed {
 public:
  virtual ~SetpointFeed() = default;

  /// The number of axes that it moves; constant.
  [[nodiscard]] virtual std::size_t axis_count() const noexcept = 0;
  /// An axis, by its number in the feed, begins to follow; `from` is its setpoint.
  virtual void join(std::size_t axis, const trajectory::AxisSetpoint& from) noexcept = 0;
  /// An axis does not follow any more: another motion has taken it, or it has failed.
  virtual void leave(std::size_t axis) noexcept = 0;
  /// Positions are those of requests: with AxisCommand::kSetPosition. Once per cycle while an axis follows: `period_s`
  /// later than the last time. Sets the setpoints of all its axes. False: there are no more; the axes come to rest, and
  /// their requests are done.
  [[nodiscard]] virtual bool next(double period_s, std::span<trajectory::AxisSetpoint> setpoints) noexcept = 0;

  /// Once per cycle, whether an axis follows or not, when the requests of the cycle have been taken: the feed may make
  /// its axes follow (SingleAxes::follow_in_cycle()).
  virtual void begin_cycle() noexcept {}
  /// A request of others to one of its axes, following or not. True: the feed has taken it, and reports how far it is
  /// (SingleAxes::finish_in_cycle()); false: it is for the axis.
  [[nodiscard]] virtual bool take(std::size_t /*axis*/, std::uint64_t /*request*/,
                                  const AxisRequest& /*asked*/) noexcept {
    return false;
  }
  /// While an axis follows: so many periods have passed without a cycle, in which the drives went on by themselves.
  virtual void skip(std::int64_t /*missed*/) noexcept {}
  /// Its setpoints never lead an axis out of its software limits, nor to where it cannot stop before them: axes are not
  /// stopped for what their motion could become.
  [[nodiscard]] virtual bool keeps_ranges() const noexcept { return false; }

 protected:
  SetpointFeed() = default;
  /// Copying is for implementations only.
  SetpointFeed(const SetpointFeed&) = default;
  SetpointFeed& operator=(const SetpointFeed&) = default;
};

}  // namespace driveline::ecat_master
