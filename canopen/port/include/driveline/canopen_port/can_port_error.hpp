#pragma once

#include <cstdint>
#include <string>

namespace driveline::canopen {

/// Why a port could not be opened.
enum class CanPortErrorCode : std::uint8_t {
  kUsage,    ///< the text names no port, or an option has a value that does not exist
  kMachine,  ///< the interface, the adapter or the server is not there or refuses
};

/// An error of start-up; none of them occurs in the cycle.
struct CanPortError {
  CanPortErrorCode code = CanPortErrorCode::kMachine;  ///< kind of error
  std::string message;                                 ///< one sentence: what is wrong, and what was expected
};

/// The error as a sentence.
[[nodiscard]] inline std::string describe(const CanPortError& error) {
  return error.message;
}

}  // namespace driveline::canopen
