#pragma once

#include <memory>
#include <vector>

#include "options.hpp"
#include "subscription.hpp"

namespace driveline::bridge::clients {

/// A file of recorded samples.
class Recording {
 public:
  virtual ~Recording() = default;
  /// Gives the file its final name once there is something to record. Failure: see RecordingFile::take_place().
  [[nodiscard]] virtual Outcome<void> take_place() = 0;
  /// Adds a sample. A sample that must be decoded but cannot be is omitted and reported. Failure: the file cannot grow;
  /// call finish() then; the samples added before remain in it.
  [[nodiscard]] virtual Outcome<void> add(const Sample& sample) = 0;
  /// Writes buffered samples. Failure: see add().
  [[nodiscard]] virtual Outcome<void> flush() = 0;
  /// Completes the file.
  [[nodiscard]] virtual Outcome<void> finish() = 0;
  /// Deletes the file.
  virtual void remove() noexcept = 0;
  /// Number of samples in the file, per topic in the order of selection.
  [[nodiscard]] virtual const std::vector<std::uint64_t>& written() const noexcept = 0;
  [[nodiscard]] virtual std::uint64_t size() const noexcept = 0;  ///< size of the file in bytes
};

/// Creates a recording; the file name extension selects the format, .mcap or .csv. Failure: another extension, or the
/// file cannot be created.
[[nodiscard]] Outcome<std::unique_ptr<Recording>> create_recording(const std::string& name, bool force,
                                                                   const std::vector<const Topic*>& chosen);

/// Creates an MCAP recording, in chunks, with indices and checksums.
[[nodiscard]] Outcome<std::unique_ptr<Recording>> create_mcap(const std::string& name, bool force,
                                                              const std::vector<const Topic*>& chosen);
/// Creates a CSV recording: the table of a topic.
[[nodiscard]] Outcome<std::unique_ptr<Recording>> create_csv(const std::string& name, bool force, const Topic& topic);

}  // namespace driveline::bridge::clients
