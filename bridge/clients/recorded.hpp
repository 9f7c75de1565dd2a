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
  Bytes bytes;               ///< CDR with its encapsulation header; invalid after the file is closed
  std::int64_t received_ns;  ///< since 1970-01-01 UTC
};

/// Passes the samples of known topics to `take`, in the order of the MCAP file. A truncated file is read up to its end.
/// Failure: no such file, not an MCAP file, compressed, or recorded from a line of another version.
[[nodiscard]] Outcome<void> read_recording(const std::string& name, const std::function<void(const Recorded&)>& take);

}  // namespace driveline::bridge::clients
