#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "driveline/motion/single_axis/axis_request.hpp"
#include "driveline/trajectory/setpoint.hpp"

namespace driveline::motion {

/// Setpoints that axes follow in SynchronizedMotion, from their request AxisCommand::kFollow until another motion
/// replaces it: a stream from another process, a gear, a cam. The axes always stay within their limits: an axis that is
/// not at the position of the feed moves there by a motion of its own (trajectory::Rejoin), so a jump of the feed
/// causes no jump of the axis.
///
/// Time passes for a feed in one of two ways (waits()). A path waits: time along it is the time for which all its axes
/// got their setpoints, without missed periods and lost frames, as for all motions that the master plans. A feed that
/// follows something outside, such as another axis or a client, does not wait, and its axes catch up.
///
/// All functions are called by the cycle thread: \rtsafe.
class SetpointFeed {
 public:
  virtual ~SetpointFeed() = default;

  /// Number of axes that the feed moves; constant.
  [[nodiscard]] virtual std::size_t axis_count() const noexcept = 0;
  /// An axis, by its number in the feed, starts to follow; `from` is its setpoint.
  virtual void join(std::size_t axis, const trajectory::AxisSetpoint& from) noexcept = 0;
  /// An axis no longer follows: another motion has replaced the feed, or the axis has failed.
  virtual void leave(std::size_t axis) noexcept = 0;
  /// Sets the setpoints of all its axes, in request positions (AxisCommand::kSetPosition). Called once per cycle while
  /// an axis follows, unless it waits(); they are for `period_s` after the previous ones. Returns false when the
  /// setpoints have ended; then the axes come to rest, and their requests are done.
  [[nodiscard]] virtual bool next(double period_s, std::span<trajectory::AxisSetpoint> setpoints) noexcept = 0;

  /// Called once per cycle, whether an axis follows or not, after the requests of the cycle have been taken. The feed
  /// may make its axes follow (SingleAxes::follow_in_cycle()).
  virtual void begin_cycle() noexcept {}
  /// Offers a client's request to one of the feed's axes, following or not. Returns true if the feed has taken it and
  /// reports its progress (SingleAxes::finish_in_cycle()); false passes it to the axis.
  [[nodiscard]] virtual bool take(std::size_t /*axis*/, std::uint64_t /*request*/,
                                  const AxisRequest& /*asked*/) noexcept {
    return false;
  }
  /// Whether next() must not be called in a cycle in which one of the following axes did not get its last setpoint. All
  /// of them then continue from where they are.
  [[nodiscard]] virtual bool waits() const noexcept { return false; }
  /// Whether the setpoints never lead an axis out of its software limits, nor to where it cannot stop before them; such
  /// axes are not stopped in anticipation of leaving them.
  [[nodiscard]] virtual bool keeps_ranges() const noexcept { return false; }

 protected:
  SetpointFeed() = default;
  /// Copying is for implementations only.
  SetpointFeed(const SetpointFeed&) = default;
  SetpointFeed& operator=(const SetpointFeed&) = default;
};

}  // namespace driveline::motion
