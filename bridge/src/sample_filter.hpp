#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "driveline/bridge/dds_config.hpp"
#include "driveline/snapshot/snapshot.hpp"

namespace driveline::bridge {

/// Selects the samples that a topic publishes. Samples must arrive in order of cycles.
class SampleFilter {
 public:
  /// `axes`: number of axes of the line.
  SampleFilter(SampleRate rate, std::size_t axes) : rate_(rate), last_(rate.on_change ? axes : 0) {}

  /// Whether to publish this sample; if so, later samples are compared with it.
  [[nodiscard]] bool takes(const snapshot::AxisSample& sample);

 private:
  struct Taken {
    bool any = false;
    snapshot::AxisSample sample;
  };

  SampleRate rate_;
  std::vector<Taken> last_;  ///< by axis; empty: no comparison
};

}  // namespace driveline::bridge
