#pragma once

#include <chrono>
#include <cstdint>
#include <string>
#include <vector>

#include "driveline/bridge/dds_config.hpp"
#include "driveline/snapshot/feed/feed_condition.hpp"
#include "driveline/snapshot/line_status.hpp"
#include "driveline/snapshot/snapshot.hpp"
#include "ros2.h"

namespace driveline::bridge {

/// The DDS topic of the ROS 2 topic `diagnostics`.
inline constexpr const char* kDiagnosticsTopic = "rt/diagnostics";
/// USER_DATA of a writer of this type (REP 2016); computed by scripts/ros2_type_hash.py.
inline constexpr const char* kDiagnosticsTypeHash =
    "typehash=RIHS01_5a8a36efb05fb25070fa0fb3810290c0e6cd4862b54a8fb975a1ee8dc55a333e;";

/// Level of a DiagnosticStatus of ROS 2.
enum class DiagnosticLevel : std::uint8_t { kOk, kWarn, kError, kStale };

/// Combines the state of a line, its slaves and its axes into a DiagnosticArray of ROS 2.
class Diagnostics {
 public:
  explicit Diagnostics(const DdsConfig& config);

  /// Stores the newest sample of an axis.
  void add(const snapshot::AxisSample& sample) {
    if (sample.axis < axes_.size()) axes_[sample.axis] = sample;
  }
  /// Sets the condition of the slaves and the owners of the axes.
  void set(const snapshot::FeedCondition& condition) { condition_ = condition; }
  /// Builds the present message; `wall_time_ns` since 1970-01-01 UTC. Valid until the next call.
  [[nodiscard]] diagnostic_msgs::msg::dds_::DiagnosticArray_* message(const snapshot::LineStatus& line,
                                                                      std::int64_t wall_time_ns);

 private:
  using Status = diagnostic_msgs::msg::dds_::DiagnosticStatus_;

  [[nodiscard]] Status of_line(const snapshot::LineStatus& line) const;
  [[nodiscard]] Status of_slave(std::size_t position) const;
  [[nodiscard]] Status of_axis(std::size_t axis) const;
  [[nodiscard]] Status begin(const std::string& what, DiagnosticLevel level, const std::string& text) const;

  std::string line_;
  std::vector<std::string> names_;          ///< names of the axes
  std::vector<snapshot::AxisSample> axes_;  ///< newest samples; an axis without a sample is unavailable
  snapshot::FeedCondition condition_;
  diagnostic_msgs::msg::dds_::DiagnosticArray_ message_;
};

}  // namespace driveline::bridge
