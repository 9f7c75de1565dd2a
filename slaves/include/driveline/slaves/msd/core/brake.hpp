#pragma once

#include <chrono>
#include <utility>

#include "driveline/slaves/msd/core/drive_values.hpp"
#include "driveline/slaves/msd/core/terminals.hpp"
#include "driveline/slaves/od/object_dictionary.hpp"

namespace driveline::slaves::msd {

/// The motor brake: opens while its output is energised by any function (P 125), with the delays P 213 and P 214.
class Brake {
 public:
  /// Dictionary and terminals must outlive this. Starts closed, without a running delay.
  Brake(const ObjectDictionary& dictionary, const Terminals& terminals) noexcept
      : dictionary_(&dictionary), terminals_(&terminals) {}

  /// Sets the command of the brake control. \rtsafe
  void want_open(bool open) noexcept { open_ = open; }
  /// Updates the brake from its output. \rtsafe
  void follow(std::chrono::nanoseconds now) noexcept {
    const bool energised = output_energised();
    if (std::exchange(energised_, energised) != energised) since_ = now;
  }

  /// Returns the last command of want_open(). \rtsafe
  [[nodiscard]] bool open() const noexcept { return open_; }
  /// Whether the brake holds the shaft. \rtsafe
  [[nodiscard]] bool closed(std::chrono::nanoseconds now) const noexcept { return energised_ != at_rest(now); }
  /// Whether follow() would change nothing and no delay runs: closed() and settled() remain until the command, the
  /// output, P 213 or P 214 changes. \rtsafe
  [[nodiscard]] bool rests(std::chrono::nanoseconds now) const noexcept {
    return output_energised() == energised_ && at_rest(now);
  }
  /// Whether the delay has passed; always true when the output has another function. \rtsafe
  [[nodiscard]] bool settled(std::chrono::nanoseconds now) const noexcept {
    return !terminals_->controls_brake() || at_rest(now);
  }

 private:
  /// Whether the output that the brake is connected to is energised.
  [[nodiscard]] bool output_energised() const noexcept {
    return terminals_->controls_brake() ? open_ : terminals_->output(Output::kBrake);
  }
  /// Whether the lift or close time has passed since the output changed.
  [[nodiscard]] bool at_rest(std::chrono::nanoseconds now) const noexcept {
    const double time_ms = dictionary_->get(energised_ ? kValue.brake_lift_time : kValue.brake_close_time);
    return static_cast<double>((now - since_).count()) >= time_ms * 1e6;
  }

  const ObjectDictionary* dictionary_;
  const Terminals* terminals_;
  std::chrono::nanoseconds since_ = -std::chrono::hours(24);  ///< time of the last change of the output
  bool open_ = false;                                         ///< command of the brake control
  bool energised_ = false;                                    ///< state of the output that the brake is connected to
};

}  // namespace driveline::slaves::msd
