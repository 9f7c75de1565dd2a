#pragma once

#include <chrono>
#include <string>
#include <string_view>
#include <vector>

#include "options.hpp"
#include "schema.hpp"

namespace driveline::bridge::clients {

/// Prints samples. Returns the exit status if nothing failed.
[[nodiscard]] Outcome<int> echo(const Options& options);
/// Records samples to a file. Returns the exit status if nothing failed.
[[nodiscard]] Outcome<int> record(const Options& options);
/// Shows a line on the terminal. Returns the exit status if nothing failed.
[[nodiscard]] Outcome<int> top(const Options& options);
/// Draws curves of a recording. Returns the exit status if nothing failed.
[[nodiscard]] Outcome<int> plot(const Options& options);

/// Helpers of the commands.

using Clock = std::chrono::steady_clock;

/// Longest single wait for samples; signals are checked after it.
inline constexpr std::chrono::milliseconds kWait{50};

/// The point in time `seconds` from now.
[[nodiscard]] Clock::time_point after(double seconds);

/// Finds topics by their names; the prefix `driveline/`, with or without the version, may be omitted. Failure: status
/// 2; the text lists the known topics.
[[nodiscard]] Outcome<std::vector<const Topic*>> select_topics(const std::vector<std::string>& names);

/// Reports samples that cannot be decoded, from a writer of another version or a malicious one. The first one is
/// reported on stderr at once, their number at the end.
class OmittedSamples {
 public:
  /// `command`: name used in the messages.
  explicit OmittedSamples(std::string_view command) : command_(command) {}
  OmittedSamples(const OmittedSamples&) = delete;
  OmittedSamples& operator=(const OmittedSamples&) = delete;
  ~OmittedSamples();

  /// Counts a sample; the reason of the first one is reported.
  void add(std::string_view topic, std::string_view reason);
  /// Number of samples.
  [[nodiscard]] std::uint64_t count() const noexcept { return count_; }

 private:
  std::string_view command_;
  std::uint64_t count_ = 0;
};

/// Writes to stdout. Failure: stdout cannot be written to.
[[nodiscard]] Outcome<void> print(std::string_view text);

}  // namespace driveline::bridge::clients
