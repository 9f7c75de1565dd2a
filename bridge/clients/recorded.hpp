#pragma once

#include <cstdint>
#include <functional>
#include <string>

#include "options.hpp"
#include "schema.hpp"
#include "value.hpp"

namespace driveline::bridge::clients {

/// A sample of a recording.
struct Recorded {
  const Topic* topic;
  Bytes bytes;               ///< CDR with its encapsulation header; gone when the file is closed
  std::int64_t received_ns;  ///< since 1970-01-01 UTC
};

/// Hands out the samples of topics that are known here, in the order of a MCAP file. A file that was cut off is read up
/// to there. Failure: no such file, none of MCAP, compressed, or of a line of another version.
[[nodiscard]] Outcome<void> read_recording(const std::string& name, const std::function<void(const Recorded&)>& take);

}  // namespace driveline::bridge::clients
