#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <string_view>

#include "driveline/rt/clock.hpp"
#include "driveline/runtime/config/line_config.hpp"
#include "driveline/runtime/error.hpp"

namespace driveline::runtime {

/// An open bus of any kind: its description, its clock, and the claim on it. One thread at a time.
class LineSession {
 public:
  /// Changes or refuses a configuration before anything is opened.
  using Adjust = std::function<Result<void>(LineConfig&)>;
  /// Result of a capture.
  struct Capture {
    std::optional<std::filesystem::path> file;  ///< none: no capture, or no frames
    std::uint64_t dropped = 0;                  ///< frames that are missing in the file
  };

  virtual ~LineSession() = default;
  LineSession(const LineSession&) = delete;
  LineSession& operator=(const LineSession&) = delete;

  /// Returns the configuration with the options applied.
  [[nodiscard]] virtual const LineConfig& config() const noexcept = 0;
  /// Returns the clock of the bus: monotonic or virtual.
  [[nodiscard]] virtual rt::Clock& clock() noexcept = 0;
  /// Whether the bus runs on virtual time.
  [[nodiscard]] virtual bool virtual_time() const noexcept = 0;
  /// Tells other processes of this program that the line has a master, as long as the session exists. `would`: what
  /// this process is about to do to the line, for the sentence of the error. Error: another process has claimed the
  /// line; not with `force`. Does nothing for a line in this process.
  [[nodiscard]] virtual Result<void> claim(bool force, std::string_view would) = 0;
  /// Finishes the capture, if there is one. Call once nothing uses the bus any more.
  [[nodiscard]] virtual Result<Capture> close_capture() = 0;

 protected:
  LineSession() = default;
};

}  // namespace driveline::runtime
