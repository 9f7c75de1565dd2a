#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "driveline/bridge/dds_config.hpp"
#include "driveline/snapshot/snapshot.hpp"

namespace driveline::bridge {

/// Chooses the samples that a topic has. Samples come by cycle.
class SampleFilter {
 public:
  /// Of a line with so many axes.
  SampleFilter(SampleRate rate, std::size_t axes) : rate_(rate), last_(rate.on_change ? axes : 0) {}

  /// Whether this one is among them; if so, the next ones are compared with it.
  [[nodiscard]] bool takes(const snapshot::AxisSample& sample);

 private:
  struct Taken {
    bool any = false;
    snapshot::AxisSample sample;
  };

  SampleRate rate_;
  std::vector<Taken> last_;  ///< by axis; none: all are taken
};

}  // namespace driveline::bridge
