#pragma once

#include <string>
#include <tl/expected.hpp>

#include "driveline/runtime/error.hpp"

namespace driveline::cli {

/// Why a command ends: its exit status and one sentence for stderr.
struct Failure {
  Failure(int exit_status, std::string sentence) : status(exit_status), text(std::move(sentence)) {}
  /// Converts an error of the library, in the terms of the command line.
  Failure(const runtime::Error& error);  // NOLINT(google-explicit-constructor): errors pass through commands

  int status;
  std::string text;
};

/// The operation failed.
[[nodiscard]] inline tl::unexpected<Failure> failed(std::string text) {
  return tl::unexpected(Failure{1, std::move(text)});
}
/// The command line or the configuration is wrong.
[[nodiscard]] inline tl::unexpected<Failure> misused(std::string text) {
  return tl::unexpected(Failure{2, std::move(text)});
}

template <typename T>
using Outcome = tl::expected<T, Failure>;

/// Converts a result of the library into the outcome of a command.
[[nodiscard]] inline Outcome<void> outcome(const runtime::Result<void>& result) {
  return result ? Outcome<void>{} : tl::unexpected(Failure(result.error()));
}

}  // namespace driveline::cli
