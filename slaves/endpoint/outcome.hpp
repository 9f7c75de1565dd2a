#pragma once

#include <cerrno>
#include <cstring>
#include <string>
#include <tl/expected.hpp>
#include <utility>

namespace driveline::endpoint {

/// Why an end point cannot run.
struct Failure {
  std::string what;  ///< could not be done
  int error = 0;     ///< of the system call; 0: it was none
};

/// One sentence.
[[nodiscard]] inline std::string describe(const Failure& failure) {
  return failure.error == 0 ? failure.what : failure.what + ": " + std::strerror(failure.error);
}

/// A value, or why there is none.
template <typename T>
using Outcome = tl::expected<T, Failure>;

/// The system call that came last has failed.
[[nodiscard]] inline tl::unexpected<Failure> failed(std::string what) {
  return tl::unexpected(Failure{std::move(what), errno});
}

}  // namespace driveline::endpoint
