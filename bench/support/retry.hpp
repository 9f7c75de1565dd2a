#pragma once

#include <fmt/format.h>
#include <cstdio>
#include <stdexcept>
#include <string_view>

namespace driveline::bench {

/// A measurement that is invalid because the machine was busy, not because of an error: a frame was not answered in
/// time, for example.
struct Disturbed : std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// Calls `measure()`, and repeats it if it was disturbed, with three attempts at most; reports this on stderr and
/// counts it in `repeated`. The exception of the last attempt is passed on. Other errors are not retried.
template <typename Measure>
auto undisturbed(std::string_view what, const Measure& measure, int* repeated = nullptr) {
  constexpr int kTries = 3;
  for (int attempt = 1;; ++attempt) {
    try {
      return measure();
    } catch (const Disturbed& reason) {
      if (repeated != nullptr) ++*repeated;
      fmt::print(stderr, "{}: the measurement is not valid: {}; attempt {} of {}\n", what, reason.what(), attempt,
                 kTries);
      if (attempt == kTries) throw;
    }
  }
}

}  // namespace driveline::bench
