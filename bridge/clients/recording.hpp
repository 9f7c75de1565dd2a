#pragma once

#include <memory>
#include <vector>

#include "options.hpp"
#include "subscription.hpp"

namespace driveline::bridge::clients {

/// A file of samples.
class Recording {
 public:
  virtual ~Recording() = default;
  /// There is something to record: the file gets its name. Failure: as of RecordingFile::take_place().
  [[nodiscard]] virtual Outcome<void> take_place() = 0;
  /// Adds a sample; one that cannot be decoded and would have to be is left out, and told. Failure: the file cannot get
  /// longer; it is to be finished then, and holds what was added before.
  [[nodiscard]] virtual Outcome<void> add(const Sample& sample) = 0;
  /// Writes what waits. Failure: as of add().
  [[nodiscard]] virtual Outcome<void> flush() = 0;
  /// Completes the file.
  [[nodiscard]] virtual Outcome<void> finish() = 0;
  /// Takes the file away.
  virtual void remove() noexcept = 0;
  /// Samples that are in the file, by topic in the order of their selection.
  [[nodiscard]] virtual const std::vector<std::uint64_t>& written() const noexcept = 0;
  [[nodiscard]] virtual std::uint64_t size() const noexcept = 0;  ///< bytes
};

/// By the end of its name: .mcap or .csv. Failure: another end, or the file.
[[nodiscard]] Outcome<std::unique_ptr<Recording>> create_recording(const std::string& name, bool force,
                                                                   const std::vector<const Topic*>& chosen);

/// As MCAP, in chunks, with indices and checksums.
[[nodiscard]] Outcome<std::unique_ptr<Recording>> create_mcap(const std::string& name, bool force,
                                                              const std::vector<const Topic*>& chosen);
/// As a table of one topic.
[[nodiscard]] Outcome<std::unique_ptr<Recording>> create_csv(const std::string& name, bool force, const Topic& topic);

}  // namespace driveline::bridge::clients
