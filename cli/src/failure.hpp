#pragma once

#include <string>
#include <tl/expected.hpp>

namespace driveline::cli {

/// Why a command ends: its exit status and one sentence for stderr.
struct Failure {
  int status = 1;
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

}  // namespace driveline::cli
