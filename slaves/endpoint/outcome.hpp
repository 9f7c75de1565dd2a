#pragma once

#include <cerrno>
#include <cstring>
#include <string>
#include <tl/expected.hpp>
#include <utility>

namespace driveline::endpoint {

/// Why an end point cannot run.
struct Failure {
  std::string what;  ///< description of the failure
  int error = 0;     ///< errno of the system call; 0: not a system call
};

/// Formats the failure as a sentence.
[[nodiscard]] inline std::string describe(const Failure& failure) {
  return failure.error == 0 ? failure.what : failure.what + ": " + std::strerror(failure.error);
}

/// A value, or the reason why there is none.
template <typename T>
using Outcome = tl::expected<T, Failure>;

/// Returns a failure of the last system call.
[[nodiscard]] inline tl::unexpected<Failure> failed(std::string what) {
  return tl::unexpected(Failure{std::move(what), errno});
}

}  // namespace driveline::endpoint
